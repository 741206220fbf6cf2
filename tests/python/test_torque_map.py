"""The torque map: its analytic capability, what its records mean, its page, and a few of its points."""

import math
import re
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from programs import program
from sextant_py import drive_file, sweep_reader
from sextant_py.errors import UserError
from sextant_py.paths import ROOT
from studies import json_file
from studies.page import filled, put
from studies.torque_map import counts as torque_map_counts
from studies.torque_map import drive as torque_map_drive
from studies.torque_map import figures as torque_map_figures
from studies.torque_map import file as torque_map_file
from studies.torque_map import kinds as torque_map_kinds
from studies.torque_map import page as torque_map_page
from studies.torque_map import points as torque_map_points
from studies.torque_map import run as torque_map_run
from studies.torque_map import torque_map
from studies.torque_map.capability import Limits, largest_torque, limits_of, worst_difference
from studies.torque_map.points import Conditions, Point
from studies.torque_map.results import (
    BRIEF,
    DERATED,
    FAILED,
    OFF,
    RIGHT,
    SILENT,
    TRIPPED,
    UNSEEN,
    Results,
    beyond_r_s,
    map_of,
    outcome,
)
from studies.torque_map.scale import SENSORS, SPEEDS, TORQUES, scale_of

COMMITTED = ROOT / "docs" / "torque_map"
OMEGA = 2 * math.pi * 50
PAPER = Limits(
    r_s=0.435,
    r_r=0.816,
    l_s=(0.754 + 26.13) / OMEGA,
    l_r=(0.754 + 26.13) / OMEGA,
    l_m=26.13 / OMEGA,
    pole_pairs=2,
    voltage=math.inf,
    current=math.inf,
    flux=1.1,
    torque=math.inf,
)
EXACT = Conditions()


def sigma_l_s(m: Limits) -> float:
    return m.l_s - m.l_m**2 / m.l_r


def brute_force(m: Limits, omega_m: float, sign: int) -> float:
    """Every slip up to the breakdown and every flux, by the rotor equation of the T-equivalent circuit."""
    slip = sign * np.linspace(1e-3, m.l_s / (sigma_l_s(m) * m.l_r / m.r_r), 2000)[:, None]
    psi = np.linspace(0, m.flux, 1000)[None, :]
    # psi_s = L_s i_s + L_m i_r; 0 = R_r i_r + j slip (L_r i_r + L_m i_s)
    rotor_by_stator = -1j * slip * m.l_m / (m.r_r + 1j * slip * m.l_r)
    i_s = psi / (m.l_s + m.l_m * rotor_by_stator)
    u_s = m.r_s * i_s + 1j * (m.pole_pairs * omega_m + slip) * psi
    torque = 1.5 * m.pole_pairs * psi * i_s.imag
    possible = (abs(i_s) <= m.current) & (abs(u_s) <= m.voltage)
    return min(float(np.max(np.where(possible, sign * torque, 0))), m.torque)


def test_without_limits_the_largest_torque_is_the_breakdown_torque() -> None:
    m = PAPER
    breakdown = 0.75 * m.pole_pairs * m.l_m**2 / (sigma_l_s(m) * m.l_s * m.l_r) * m.flux**2
    for sign in (1, -1):
        assert largest_torque(m, 100, sign) == pytest.approx(breakdown, rel=1e-6)
    assert largest_torque(replace(m, torque=150), 100, 1) == 150


@pytest.mark.parametrize("speed", [0, 20, 100, 136, 160, 260, 400])
@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("current", [40.0, 160.0, math.inf])
def test_the_largest_torque_is_that_of_every_slip_and_flux(speed: float, sign: int, current: float) -> None:
    m = replace(PAPER, voltage=0.98 * 530 / math.sqrt(3), current=current)
    assert largest_torque(m, speed, sign) == pytest.approx(brute_force(m, speed, sign), rel=6e-3)


def test_limits_are_those_of_the_configuration_in_force() -> None:
    machine = {"r_s_ohm": 0.435, "r_r_ohm": 0.816, "x_ls_ohm": 0.754, "x_lr_ohm": 0.754, "x_m_ohm": 26.13}
    machine |= {"reactance_frequency_hz": 50, "poles": 4}
    configuration = {
        **{f"machine.{key}": value for key, value in machine.items()},
        "capability.voltage_use": 0.98,
        "capability.torque_nm": 150,
        "capability.current_limit_a": 160,
        "plant.u_dc_v": 530,
        "control.flux_reference_wb": 1.1,
    }
    wanted = replace(PAPER, voltage=0.98 * 530 / math.sqrt(3), torque=150)
    assert limits_of(configuration, "capability.current_limit_a") == replace(wanted, current=160)
    assert limits_of(configuration, "capability.none") == wanted


def test_the_worst_difference_is_found_with_its_place() -> None:
    capability = {"speeds": [0, 100], "motoring": [100, 99], "motoring_analytic": [100, 100]}
    capability |= {"regenerating": [103, None], "regenerating_analytic": [100, 0]}
    assert worst_difference(capability) == (pytest.approx(3), 0, "regenerating")


def record(silent_ms: float | None = 0, faults: tuple = (), available: float = 150, reason: str = "") -> dict:
    found = {"reason": reason, "faults": list(faults), "torque_silent_ms": silent_ms, "torque_deviation_nm": 1.0}
    return found | {"torque_motoring_nm": available, "torque_regenerating_nm": 150}


TRIP = (["OVER_CURRENT", 0.3],)


@pytest.mark.parametrize(
    ("found", "conditions", "speed", "torque", "letter"),
    [
        (record(), EXACT, 50, 15, RIGHT),
        (record(available=20), EXACT, 50, 60, DERATED),
        (record(available=20), EXACT, -50, 60, RIGHT),
        (record(available=59), EXACT, 50, 60, RIGHT),
        (record(10), EXACT, 50, 15, BRIEF),
        (record(10.1), EXACT, 50, 15, SILENT),
        (record(10.1, TRIP), EXACT, 50, 15, SILENT),
        (record(9, TRIP), EXACT, 50, 15, TRIPPED),
        (record(None, TRIP), EXACT, 50, 15, TRIPPED),
        (record(None, available=0), EXACT, 200, 15, OFF),
        (record(None, available=1), EXACT, 200, 2, OFF),
        (record(None), EXACT, 200, 15, SILENT),
        (record(None), EXACT, 200, 0, OFF),
        (record(500), Conditions(r_r=1.5), 10, 15, UNSEEN),
        (record(500), Conditions(l_m=0.7), -10, 15, UNSEEN),
        (record(500), Conditions(l_m=0.7), 20, 15, SILENT),
        (record(500), Conditions(r_s=1.5), 0, 15, SILENT),
        (record(reason="no result"), EXACT, 0, 15, FAILED),
    ],
)
def test_an_outcome(found: dict, conditions: Conditions, speed: float, torque: float, letter: str) -> None:
    assert outcome(found, Point(conditions, speed, torque)) == letter


def test_the_sets_are_those_of_the_factors() -> None:
    full, default = torque_map_points.full_sets(), torque_map_points.default_sets()
    assert len(full) == len(set(full)) == (2 * 5 * 3 * 3 - 1) * 2 * 2 * 2
    assert len(default) == len(set(default)) and set(default) < set(full)
    assert set(torque_map_points.axes() + torque_map_points.corners()) < set(default)
    assert set(torque_map_points.quick_sets()) < set(full)
    assert [-speed for speed in reversed(SPEEDS)] == list(SPEEDS)
    assert SPEEDS[-1] == 400
    points = torque_map_points.points(default, SPEEDS, TORQUES)
    assert len({point.key for point in points}) == len(points)


def drive(**more: object) -> torque_map_drive.Drive:
    machine = {"r_s_ohm": 0.4, "r_r_ohm": 0.8, "x_m_ohm": 26, "inertia_kg_m2": 0.5}
    return torque_map_drive.Drive("shipped", {}, machine, set(), **more)


def test_the_factors_scale_the_machine_or_what_the_controller_believes() -> None:
    conditions = Conditions(r_s=0.5, l_m=1.5)
    real = torque_map_points.machine_settings(drive(), conditions)
    assert real["machine.r_s_ohm"] == 0.2 and real["control.machine_estimate.r_s_ohm"] == 0.4
    assert real["machine.x_m_ohm"] == 39 and real["control.machine_estimate.x_m_ohm"] == 26
    believed = torque_map_points.machine_settings(drive(), replace(conditions, detune="estimate"))
    assert believed["machine.r_s_ohm"] == 0.4 and believed["control.machine_estimate.r_s_ohm"] == 0.2


def test_a_free_shaft_has_its_speed_when_the_torque_steps() -> None:
    load = torque_map_points.load_settings(drive(), Point(Conditions(shaft="free"), -100, 15))
    (_, still), (from_s, push), (step_s, torque) = load["load.torque_nm.points"]
    assert still == 0
    assert -push / 0.5 * (step_s - from_s) == pytest.approx(-100)
    assert torque == 15


def test_nested_tables_become_dotted_keys() -> None:
    assert sweep_reader.flat({"a": {"b": 1, "c": {"d": 2}}, "e": 3}) == {"a.b": 1, "a.c.d": 2, "e": 3}


def made_up(name: str, silent_ms: float) -> Results:
    """Every set and point; wrong with a warm winding at 50 rad/s."""
    speeds, torques, sets = [*SPEEDS], [*TORQUES], torque_map_points.default_sets()
    maps = []
    for one in sets:
        records = {}
        for point in torque_map_points.points([one], speeds, torques):
            wrong = one == Conditions(r_s=1.5) and (point.speed, point.torque) == (50, 15)
            records[point.key] = record(silent_ms if wrong else 0) | {"torque_deviation_nm": 30.0 if wrong else 0.5}
        maps.append(map_of(one, speeds, torques, records))
    analytic = {"motoring_analytic": [150.0] * len(speeds), "regenerating_analytic": [150.0] * len(speeds)}
    capability = {
        "speeds": speeds,
        "motoring": [147.0] * len(speeds),
        "regenerating": [150.0] * len(speeds),
        **analytic,
    }
    capability["limits"] = {k: v if math.isfinite(v) else None for k, v in replace(PAPER, torque=150).__dict__.items()}
    return Results(name, f"drive {name}", "1.0", "0123456789ab", speeds, torques, maps, capability)


def test_results_are_kept(tmp_path: Path) -> None:
    results = made_up("shipped", 500)
    json_file.write(tmp_path / "shipped.json", results)
    assert torque_map.results_in(tmp_path, "shipped") == results
    (tmp_path / "shipped.json").write_text("{}")
    with pytest.raises(UserError, match="holds no results of scripts/torque_map"):
        torque_map.results_in(tmp_path, "shipped")


def test_a_point_beyond_the_tolerance_of_the_stator_resistance_is_found() -> None:
    assert beyond_r_s(made_up("shipped", 5)) == [(Conditions(r_s=1.5), 50, 15, 30.0)]


def test_the_page_has_the_figures_of_its_results_and_every_picture(tmp_path: Path) -> None:
    maps = {"paper": made_up("paper", 500), "shipped": made_up("shipped", 500), "foc": made_up("foc", 5)}
    written = torque_map_page.write(maps, tmp_path)
    page = (tmp_path / "README.md").read_text(encoding="utf-8")
    assert all(file.is_file() for file in written)
    assert set(re.findall(r"\]\((\w+\.png)\)", page)) == {file.name for file in written if file.suffix == ".png"}
    assert not re.search(r"(?<![\\_])\{\w+\}", page.replace(r"\omega_{slip}", "")), "a field of the template is left"
    points = maps["foc"].points
    assert f"| all | {points} | {points} | {points} |" in page
    assert "| **silently wrong** | 1 | 1 | 0 |" in page
    assert "drive foc: no point is silently wrong." in page
    assert "from `paper.json`, `shipped.json`, `foc.json` (" in page
    assert "At worst -2.0 %: drive paper, motoring" in page


def test_the_counts_of_the_guarantees_are_those_of_their_sets_and_speeds() -> None:
    results = made_up("shipped", 500)  # one point is silently wrong, of a set that no count has
    row = results.torques.index(15)
    for conditions, letter in (
        (Conditions(r_r=0.5), SILENT),
        (Conditions(l_m=1.3, detune="estimate"), UNSEEN),
        (Conditions(**torque_map_points.SENSORS_ALONE), SILENT),
    ):
        results.find(conditions).outcomes[row] = letter * len(results.speeds)
    names = [*torque_map_counts.COUNTS, "unobservable"]
    page = put("".join(f"<!-- {name} --><!-- end -->" for name in names), torque_map_counts.blocks(results))
    assert re.findall(r"-->([^<]+)<", page) == [
        "12 of 2,592", "10 of 2,160", "0 of 648", "0 of 648", "0 of 1,080", "29 of 2,610", "29",
    ]  # fmt: skip


def test_every_silently_wrong_point_is_of_one_kind() -> None:
    results = made_up("shipped", 500)  # one point is silently wrong, with R_s alone wrong
    row, all_speeds = results.torques.index(15), len(results.speeds)
    for conditions in (Conditions(r_r=0.5), Conditions(**torque_map_points.SENSORS_ALONE)):
        results.find(conditions).outcomes[row] = SILENT * all_speeds
    fast = sum(abs(speed) >= torque_map_kinds.WEAKENING_RAD_S for speed in results.speeds)
    found = {kind.name: len(kind.speeds) for kind in torque_map_kinds.found([results], torque_map_kinds.kinds())}
    assert list(found.values()) == [fast, all_speeds - fast, all_speeds, 1]
    assert sum(found.values()) == results.counts[SILENT]
    last = torque_map_kinds.kinds_table([results]).splitlines()[-1]
    assert last.startswith("| $R_r$ and $L_m$ exact, ideal sensors | 1 | 50 | 30 | 500 | at standstill")


@pytest.mark.parametrize("torque", TORQUES)
def test_at_the_marked_speed_the_stator_frequency_is_zero(torque: float) -> None:
    speed = torque_map_figures.zero_frequency_speed(made_up("shipped", 5), torque)
    m, slip = PAPER, -PAPER.pole_pairs * speed
    i_s = m.flux / (m.l_s - 1j * slip * m.l_m**2 / (m.r_r + 1j * slip * m.l_r))
    assert 1.5 * m.pole_pairs * m.flux * i_s.imag == pytest.approx(torque, abs=1e-9)


@pytest.mark.skipif(not (COMMITTED / "README.md").is_file(), reason="scripts/torque_map has not written the page yet")
def test_the_committed_pages_are_those_of_their_results() -> None:
    maps = torque_map.results_of_drives(torque_map.RESULTS)
    page = filled(torque_map_page.TEMPLATE, torque_map_page.fields(maps))
    assert (COMMITTED / "README.md").read_text(encoding="utf-8") == page
    guarantees = torque_map_counts.PAGE.read_text(encoding="utf-8")
    assert guarantees == put(guarantees, torque_map_counts.blocks(maps[torque_map_drive.GUARANTEED]))


def run_map(out: Path, *options: str) -> subprocess.CompletedProcess:
    mil = ["--mil", str(program("sextant-mil"))]
    words = [str(ROOT / "scripts" / "torque_map"), *mil, "--out", str(out), *options]
    return subprocess.run(words, capture_output=True, text=True, timeout=600)


def quick(drive: str, directory: Path, monkeypatch: pytest.MonkeyPatch) -> tuple[int, Results]:
    monkeypatch.setattr(torque_map, "OUT", directory)
    where = ["--mil", str(program("sextant-mil")), "--out", str(directory), "--jobs", "2"]
    status = torque_map.main(["--quick", "--drive", drive, *where])
    return status, torque_map.results_in(directory, f"{drive}_quick")


def test_no_point_of_the_shipped_drive_is_silently_wrong(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    status, results = quick("shipped", tmp_path, monkeypatch)
    assert status == 0
    assert re.search(r"ecu\.toml: [0-9.e-]+ minutes, [0-9.e-]+ minutes of processor time\n", capsys.readouterr().out)
    assert results.points == 4 * len(results.speeds) * len(results.torques)
    exact = results.find(Conditions())
    assert exact.outcomes[results.torques.index(15)][results.speeds.index(50)] == RIGHT


def test_points_are_kept_and_the_paper_s_drive_is_wrong(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    status, results = quick("paper", tmp_path, monkeypatch)
    assert status == 0, "it is the drive with which the other is compared"
    half = results.find(Conditions(r_s=0.5))
    assert half.outcomes[results.torques.index(15)][results.speeds.index(50)] == SILENT
    records = tmp_path / "torque_map" / "paper.jsonl"
    lines = records.read_text().splitlines()
    assert len(lines) == results.points + 1
    quick("paper", tmp_path, monkeypatch)
    assert records.read_text().splitlines() == lines, "nothing runs twice"
    changed = torque_map_points.settings
    monkeypatch.setattr(torque_map_run, "settings", lambda *point: changed(*point) | {"duration_s": 0.9})
    quick("paper", tmp_path, monkeypatch)
    assert len(records.read_text().splitlines()) == 2 * results.points + 1, "points with other settings run again"


def test_the_command_line_says_what_is_wrong(tmp_path: Path) -> None:
    for options, sentence in (
        (("--quick", "--full"), "not allowed with"),
        (("--jobs", "0"), "expected a number from 1"),
        (("--page",), "paper.json is missing"),
        (("--drive", "none"), "invalid choice"),
    ):
        done = run_map(tmp_path, *options)
        assert done.returncode and sentence in done.stderr, options
    assert "examples:" in run_map(tmp_path, "--help").stdout


def write_drive(directory: Path, text: str = "") -> Path:
    machine = ROOT / "configs" / "machines" / "mathworks_215hp.toml"
    (directory / "base.toml").write_text(
        f'[machine]\nfile = "{machine}"\n[control]\ncontroller = "foc"\n[can]\nbus = "socketcan:can0"\n',
        encoding="utf-8",
    )
    file = directory / "my.toml"
    head = 'base = "base.toml"\n[drive]\nperiod_us = 125\n[plant]\nu_dc_v = 566\n[load]\nkind = "torque"\n'
    file.write_text(head + text, encoding="utf-8")
    return file


def test_the_file_of_a_section_that_is_named_last_stands_below_every_key(tmp_path: Path) -> None:
    (tmp_path / "a.toml").write_text("dead_time_us = 1\nthreshold_v = 1\n", encoding="utf-8")
    (tmp_path / "b.toml").write_text("dead_time_us = 2\nslope_ohm = 0.1\n", encoding="utf-8")
    (tmp_path / "base.toml").write_text(
        'drive.inverter.file = "a.toml"\ndrive.inverter.slope_ohm = 0.5\n', encoding="utf-8"
    )
    derived = tmp_path / "derived.toml"
    derived.write_text('base = "base.toml"\ndrive.inverter.file = "b.toml"\n', encoding="utf-8")
    assert drive_file.read(derived) == {"drive.inverter.dead_time_us": 2, "drive.inverter.slope_ohm": 0.5}


@pytest.mark.parametrize("text", ['machine = "m.toml"\n', '[machine]\nfile = "m.toml"\n', 'machine.file = "m.toml"\n'])
def test_a_relative_path_of_a_machine_is_seen_from_its_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, text: str
) -> None:
    (tmp_path / "of").mkdir()
    (tmp_path / "of" / "m.toml").write_text("poles = 4\n", encoding="utf-8")
    (tmp_path / "of" / "drive.toml").write_text(text, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    assert drive_file.read(Path("of/drive.toml")) == {"machine.poles": 4}


def test_a_file_is_read_with_its_base_and_machine(tmp_path: Path) -> None:
    found = drive_file.read(write_drive(tmp_path, "[machine]\ninertia_kg_m2 = 5\n"))
    assert found["machine.l_m_h"] == 0.00769 and found["machine.inertia_kg_m2"] == 5
    assert found["control.controller"] == "foc" and found["drive.period_us"] == 125
    known = {"control.controller", "drive.period_us", "plant.u_dc_v", "load.kind"}
    settings, left_out = drive_file.of_the_drive(found, known, Path("my.toml"))
    assert settings == {"control.controller": "foc", "drive.period_us": 125, "plant.u_dc_v": 566}
    assert left_out == ["can"]
    with pytest.raises(UserError, match=r"my.toml: drive.period_ms is unknown"):
        drive_file.of_the_drive(found | {"drive.period_ms": 1}, known, Path("my.toml"))


def test_files_that_are_none(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="cannot be read: No such file"):
        drive_file.read(tmp_path / "none.toml")
    (tmp_path / "self.toml").write_text('base = "self.toml"\n', encoding="utf-8")
    with pytest.raises(UserError, match="is based on itself"):
        drive_file.read(tmp_path / "self.toml")
    (tmp_path / "bad.toml").write_text("control = [\n", encoding="utf-8")
    with pytest.raises(UserError, match="is no TOML"):
        drive_file.read(tmp_path / "bad.toml")


def test_points_of_another_drive_scale_with_its_speed_and_torque() -> None:
    configuration = {
        "machine.poles": 4, "plant.u_dc_v": 530, "control.flux_reference_wb": 1.1, "command.torque_limit_nm": 150,
        "capability.torque_nm": 150, "protection.over_current_a": 250, "drive.magnetise_timeout_ms": 50,
    }  # fmt: skip
    shipped = scale_of(configuration)
    assert shipped.speeds == SPEEDS
    assert shipped.torques == TORQUES and shipped.torque_floor == 2.0
    assert shipped.sensors == SENSORS and shipped.from_s == pytest.approx(0.15)
    large = scale_of(
        configuration | {"plant.u_dc_v": 1060, "command.torque_limit_nm": 1500, "capability.torque_nm": 1800}
        | {"protection.over_current_a": 2500, "drive.magnetise_timeout_ms": 1000}
    )  # fmt: skip
    assert large.speeds[-1] == pytest.approx(800, rel=1e-3) and large.torques[-1] == 1300
    assert large.sensors["real"]["plant.sensors.current.noise_a"] == 2.0
    assert large.sensors["real"]["plant.sensors.voltage.range_v"] == 2000
    assert large.sensors["real"]["plant.sensors.current.bits"] == 12
    assert large.step_s > large.from_s == pytest.approx(1.1)


def test_a_file_of_its_own_is_mapped(tmp_path: Path) -> None:
    mil = program("sextant-mil")
    drive = torque_map_file.load(write_drive(tmp_path), mil, tmp_path)
    assert drive.label == "my.toml" and drive.left_out == ["can"]
    assert drive.factors["l_m"] == "l_m_h"
    lab = torque_map_run.Lab(mil, drive, tmp_path)
    point = Point(EXACT, drive.scale.quick_speeds[2], drive.scale.quick_torques[1])
    lab.run([point], 1, lambda: None)
    assert outcome(lab.records[point.key], point, drive.scale.torque_floor) == RIGHT
    # The configured limits hold in the independent computation of a machine given by inductances.
    limits = limits_of(drive.configuration, torque_map_drive.CURRENT_LIMIT)
    assert limits.l_s == pytest.approx(0.00769 + 0.000152)


@pytest.mark.parametrize("words", [["--drive", "foc"], ["--page"]])
def test_a_file_excludes_the_shipped_drives(words: list[str], tmp_path: Path) -> None:
    with pytest.raises(SystemExit):
        torque_map.parse_arguments([str(write_drive(tmp_path)), *words])
