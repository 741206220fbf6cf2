"""The monitor: what it shows, and what it says about silence. Writers run in the same process, over the loopback."""

import io
import math
import os
import pty
import re
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from cyclonedds.core import Policy, Qos
from cyclonedds.pub import DataWriter
from cyclonedds.topic import Topic
from cyclonedds.util import duration
from rich.console import Console
from sextant_py import dds, drive_view, sparkline, telemetry_types
from sextant_py.paths import ROOT
from topic_writer import Writer

LABELS = 15  # columns of border and label in front of a value
VALUES = {
    "drive_id": 7,
    "sequence": 1,
    "torque_requested_nm": 16.0,
    "torque_reference_nm": 15.0,
    "torque_mean_nm": 14.5,
    "torque_min_nm": 10.0,
    "torque_max_nm": 19.0,
    "flux_mean_wb": 1.1012,
    "current_mean_a": 20.25,
    "speed_rad_s": 30.0,
    "u_dc_v": 530.0,
    "state": telemetry_types.DriveStateKind.TORQUE,
}


def test_bar_marks_band_mean_reference_and_zero() -> None:
    assert drive_view.torque_bar(-4, -2, 0, 3, full_scale=5, width=11) == "·─" + "─" + "█" + "──" + "··" + "◆" + "··"
    assert drive_view.torque_bar(6, 7, 8, 9, full_scale=10, width=21)[10] == "│"
    assert len(drive_view.torque_bar(-99, 0, 99, 50, full_scale=10, width=21)) == 21


@pytest.mark.parametrize(("value", "expected"), [(0.2, 1), (1, 1), (1.1, 2), (19, 20), (21, 50), (130, 200)])
def test_scale(value: float, expected: float) -> None:
    assert drive_view.rounded_up(value) == expected


def test_faults_are_named_by_the_contract() -> None:
    assert drive_view.fault_names(1 << 8 | 1 << 0) == ["COMMAND_LOST", "OVER_CURRENT"]
    assert drive_view.fault_names(0) == []
    assert drive_view.fault_names(1 << 47) == ["BIT_47"]


def test_contract_fields_are_those_of_the_idl() -> None:
    fields = dds.contract_fields("DriveTelemetry")
    assert fields[0] == "drive_id"
    assert {"sequence", "t_ns", "torque_mean_nm", "flux_angle_rad", "command_received_ns"} <= set(fields)


def full_drive() -> dds.Drive:
    drive = dds.Drive(7)
    drive.take_telemetry(telemetry_types.sample(telemetry_types.struct("DriveTelemetry"), **VALUES))
    drive.state = telemetry_types.sample(
        telemetry_types.struct("DriveState"), drive_id=7, faults_latched=1 << 8, reason="[too much] current"
    )
    drive.statistics = telemetry_types.sample(
        telemetry_types.struct("RealTimeStatistics"),
        drive_id=7,
        period_ns=25000,
        periods_missed=3,
        overruns=2,
        overruns_machine=1,
        overruns_late_wake=1,
        real_time_scheduling=True,
        policy=telemetry_types.enum("SchedulingKind").FIFO,
        page_faults=5,
        r_s_ohm=0.4351,
        r_r_ohm=0.9,
        l_m_h=0.0693,
        r_s_deviation=0.031,
        r_r_deviation=0.25,
        l_m_deviation=0.1,
        winding_temperature_k=354.15,
        periods_unchecked=17,
        commands_rejected=5,
        rejected_wrong_crc=3,
        rejected_repeated=2,
    )
    return drive


@pytest.mark.parametrize("width", [100, 80, 60, 48])
def test_panel_shows_everything_at_any_width(width: int) -> None:
    console = Console(width=width, record=True, file=io.StringIO())
    console.print(drive_view.DriveView().panel(full_drive(), width))
    text = console.export_text()
    assert max(len(line) for line in text.splitlines()) <= width
    assert "…" not in text.replace(" … ", ""), text
    values = [line[LABELS:].strip(" │") for line in text.splitlines()[1:-1]]
    text = " ".join(" ".join([text.splitlines()[0], *values]).split())
    for expected in (
        "drive 7",
        "TORQUE",
        "+14.50 N·m mean",
        "+10.00 … +19.00",
        "+15.00 N·m reference",
        "+16.00 requested",
        "1.1012 Wb",
        "20.25 A",
        "+30.00 rad/s",
        "+286.5 rpm",
        "530.0 V",
        "[too much] current",
        "OVER_CURRENT",
        "3 missed",
        "2 overruns",
        "machine 1, late wake-up 1",
        "SCHED_FIFO, wait sleep, memory not locked, 5 page faults",
        "R_s 0.4351 Ω ± 3 %, R_r 0.9 Ω ± 25 %, L_m 0.0693 H ± 10 %",
        "81 °C",
        "17 control periods",
        "accepted, 5 rejected",
        "CRC 3, counter of the frame before 2",
    ):
        assert expected in text, text


def test_a_torque_beside_the_request_is_said_in_panel_and_line() -> None:
    drive, view = full_drive(), drive_view.DriveView()
    console = Console(width=80, record=True, file=io.StringIO())
    assert "NOT FOLLOWING" not in view.line(drive)
    kind = telemetry_types.struct("DriveTelemetry")
    for k in range(1, 30):
        values = {**VALUES, "t_ns": k * 10_000_000, "torque_mean_nm": -20.0}
        drive.take_telemetry(telemetry_types.sample(kind, **values))
        view.line(drive)
    assert "NOT FOLLOWING: -36.0 N·m beside the request" in view.line(drive)
    console.print(view.panel(drive, 80))
    assert "NOT FOLLOWING: -36.0 N·m beside the request" in console.export_text()


NOBODY = b"no other DDS participant was discovered"


@pytest.mark.parametrize("terminal", ["dumb", "xterm"])
def test_a_terminal_shows_something_whatever_it_is(domain: int, terminal: str) -> None:
    """A dumb terminal takes no cursor movements: lines."""
    main, subordinate = pty.openpty()
    command = [ROOT / "scripts" / "monitor", "--domain", str(domain)]
    environment = {**os.environ, "TERM": terminal}
    shown = b""
    with subprocess.Popen(command, stdout=subordinate, stderr=subprocess.DEVNULL, env=environment) as program:
        os.close(subordinate)
        try:
            while NOBODY not in shown and (chunk := os.read(main, 4096)):
                shown += chunk
        except OSError:  # the program has ended
            pass
        program.terminate()
    os.close(main)
    assert NOBODY in shown
    assert (b"\x1b" in shown) == (terminal == "xterm")


@pytest.mark.parametrize("width", [100, 80, 60])
def test_the_course_of_torque_and_speed_is_drawn(width: int) -> None:
    """A torque that rises over 20 s rises from the lowest level to the highest; a speed stands still."""
    drive, view = full_drive(), drive_view.DriveView()
    kind = telemetry_types.struct("DriveTelemetry")
    console = Console(width=width, record=True, file=io.StringIO())
    for k in range(200):
        values = {**VALUES, "t_ns": k * 100_000_000, "torque_mean_nm": k / 10}
        drive.take_telemetry(telemetry_types.sample(kind, **values))
        view.line(drive)
    console.print(view.panel(drive, width))
    courses = [line.strip("│ ") for line in console.export_text().splitlines() if "▁" in line or "▅▅" in line]
    assert len(courses) == 2
    torque, _, about = courses[0].partition(" ")
    assert list(torque) == sorted(torque, key=sparkline.LEVELS.index)
    assert (torque[0], torque[-1]) == ("▁" if len(torque) == 40 else torque[0], "█")
    assert about.startswith("+0.2 … +19.7 in ")
    assert courses[1].startswith("▅▅▅▅")


def test_a_sparkline_has_the_means_of_its_steps() -> None:
    line = sparkline.Sparkline(8)
    for k in range(40):  # 0.1 s apart
        if not 10 <= k < 20:
            line.add(k / 10, float(k % 5))
    assert line.values(8) == [2.0, 2.0, None, None, 2.0, 2.0, 2.0, 2.0]
    line.add(3.95, math.nan)
    for value, time_s in ((0.0, 4.0), (7.0, 4.5)):
        line.add(time_s, value)
    assert line.text(4) == ("▃▃▁█", 0.0, 7.0)
    noise = sparkline.Sparkline(8, span=1.0)
    for k in range(8):
        noise.add(k / 2, 20 + 0.001 * k)
    assert noise.text(8)[0] == "▄▄▄▄▅▅▅▅"
    line.add(1.0, 3.0)  # the drive was started again
    assert line.text(4) == ("   ▅", 3.0, 3.0)


@pytest.mark.parametrize("no_color", [False, True])
def test_no_colour_where_none_is_wanted(no_color: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("NO_COLOR", raising=False)
    if no_color:
        monkeypatch.setenv("NO_COLOR", "1")
    shown = io.StringIO()
    console = Console(width=80, file=shown, force_terminal=True, color_system="standard")
    console.print(drive_view.DriveView().panel(full_drive(), 80))
    colours = re.findall(r"\x1b\[[\d;]*3[1-7]", shown.getvalue())
    assert bool(colours) != no_color
    plain = io.StringIO()
    Console(width=80, file=plain).print(drive_view.DriveView().panel(full_drive(), 80))
    assert "\x1b" not in plain.getvalue()


def test_line_is_one_line() -> None:
    line = drive_view.DriveView().line(full_drive())
    assert "\n" not in line
    assert "torque +14.50 N·m (+10.00 … +19.00) of +15.00" in line
    assert "FAULTS OVER_CURRENT" in line


def until(telemetry: dds.Telemetry, condition: Callable[[], bool], patience_s: float = 120.0) -> bool:
    end_s = time.monotonic() + patience_s
    while not condition() and time.monotonic() < end_s:
        telemetry.poll()
        time.sleep(0.02)
    return condition()


def test_type_is_discovered_and_samples_arrive(domain: int) -> None:
    kind = telemetry_types.struct("DriveTelemetry")
    telemetry = dds.Telemetry(domain, depth=1000)
    with Writer(domain, dds.TELEMETRY, kind, dds.streaming_qos(1), **VALUES):
        assert until(telemetry, lambda: 7 in telemetry.drives and telemetry.drives[7].received > 20)
    drive = telemetry.drives[7]
    assert drive.telemetry.torque_mean_nm == 14.5
    assert drive.telemetry.state.name == "TORQUE"
    assert telemetry.stream.diagnosis() is None
    assert any(dds.STATE in problem and "none writes" in problem for problem in telemetry.problems())


def test_missing_samples_are_counted() -> None:
    kind = telemetry_types.struct("DriveTelemetry")
    drive = dds.Drive(1)
    for sequence in (5, 6, 9, 10, 2, 3):
        drive.take_telemetry(telemetry_types.sample(kind, drive_id=1, sequence=sequence))
    assert drive.lost == 2


def test_nobody_there_is_said(domain: int) -> None:
    telemetry = dds.Telemetry(domain)
    telemetry.poll()
    assert len(telemetry.problems()) == 1
    assert "no other DDS participant was discovered" in telemetry.problems()[0]
    assert f"domain {domain}" in telemetry.problems()[0]


def test_the_configuration_in_force_is_named(domain: int, monkeypatch: pytest.MonkeyPatch) -> None:
    telemetry = dds.Telemetry(domain)
    assert telemetry.problems()[0].count("configs/cyclonedds_loopback.xml") == 1
    monkeypatch.setenv("CYCLONEDDS_URI", "file:///my/own.xml")
    assert "CYCLONEDDS_URI=file:///my/own.xml" in telemetry.problems()[0]


def test_incompatible_qos_is_named(domain: int) -> None:
    kind = telemetry_types.struct("DriveState")
    volatile = Qos(
        Policy.Reliability.Reliable(duration(milliseconds=100)), Policy.Durability.Volatile, Policy.History.KeepLast(1)
    )
    telemetry = dds.Telemetry(domain)
    with Writer(domain, dds.STATE, kind, volatile, drive_id=7):
        assert until(telemetry, lambda: "incompatible QoS" in (telemetry.states.diagnosis() or ""))
    assert "does not offer the DURABILITY asked for" in telemetry.states.diagnosis()


def test_best_effort_state_is_named(domain: int) -> None:
    kind = telemetry_types.struct("DriveState")
    qos = Qos(Policy.Reliability.BestEffort, Policy.Durability.TransientLocal, Policy.History.KeepLast(1))
    telemetry = dds.Telemetry(domain)
    with Writer(domain, dds.STATE, kind, qos, drive_id=7):
        assert until(telemetry, lambda: "RELIABILITY" in (telemetry.states.diagnosis() or ""))


def test_type_mismatch_is_named(domain: int) -> None:
    kind = telemetry_types.struct("DriveTelemetry", without=("flux_mean_wb", "u_dc_v"))
    values = {name: value for name, value in VALUES.items() if name in kind.__annotations__}
    telemetry = dds.Telemetry(domain)
    with Writer(domain, dds.TELEMETRY, kind, dds.streaming_qos(1), **values):
        assert until(telemetry, lambda: "type mismatch" in (telemetry.stream.diagnosis() or ""))
    assert "lacks flux_mean_wb, u_dc_v of configs/interfaces/telemetry.idl" in telemetry.stream.diagnosis()


def test_a_writer_that_never_writes_is_said(domain: int) -> None:
    kind = telemetry_types.struct("DriveTelemetry")
    node = dds.Node(domain)
    writer = DataWriter(node.participant, Topic(node.participant, dds.TELEMETRY, kind), dds.streaming_qos(1))
    telemetry = dds.Telemetry(domain)
    assert until(telemetry, lambda: "no sample has arrived" in (telemetry.stream.diagnosis() or ""))
    del writer


def test_the_command_fails_with_the_reason(domain: int) -> None:
    command = [ROOT / "scripts" / "monitor", "--once", "--duration", "1", "--domain", str(domain)]
    found = subprocess.run(command, capture_output=True, text=True, timeout=480)
    assert found.returncode == 1
    assert found.stderr.startswith("monitor: no other DDS participant was discovered")
    assert found.stderr.count("\n") == 1


def test_a_refused_configuration_is_named_with_its_reason(domain: int, tmp_path: Path) -> None:
    uri = f"file://{tmp_path / 'dds.xml'}"
    (tmp_path / "dds.xml").write_text("<CycloneDDS><Domain><Nonsense>1</Nonsense></Domain></CycloneDDS>", "utf-8")
    found = subprocess.run(
        [ROOT / "scripts" / "monitor", "--domain", str(domain)],
        capture_output=True,
        text=True,
        timeout=120,
        env={**os.environ, "CYCLONEDDS_URI": uri},
    )
    assert found.returncode != 0
    reason, sentence = found.stderr.splitlines()
    assert "Nonsense: unknown element" in reason
    assert sentence.startswith(f"monitor: DDS cannot start in domain {domain} with CYCLONEDDS_URI={uri}: ")
    assert "Traceback" not in found.stderr
