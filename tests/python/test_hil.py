"""The plant in a process of its own: each side starts first, dies and comes back, and the gates turn off.

A time-out is a second here, the watchdog's time a minute. That the gates turn off within the shipped times is tested
where time is the test's own (tests/hil) and measured by scripts/bench.
"""

import os
import struct
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from handling import MEASUREMENT_INVALID, WATCHDOG, at_torque, bring_up
from hil_processes import (
    CONTROL_THREAD,
    DRIVE,
    PATIENCE_S,
    PLANT,
    SILENCE_MS,
    HeldThread,
    drive_side,
    opening_after,
    openings,
    plant_side,
    thread_named,
)
from programs import overrides, program
from sextant_py.paths import ROOT
from telemetry_record import TelemetryRecord
from vehicle import Vehicle

TORQUE_NM = 10.0
MEANT = pytest.approx(TORQUE_NM, abs=4.0)
SOON_WATCHDOG = f"realtime.watchdog_ms={SILENCE_MS}"
SILENT = "the drive has timed out"
LINE_OFF = "the gate-enable line is off"
JOINED = "a drive has joined the lockstep"


@pytest.fixture
def link() -> Iterator[str]:
    name = f"sextant_test_{os.getpid()}_{time.monotonic_ns()}"
    yield name
    Path("/dev/shm", name).unlink(missing_ok=True)


def wait_for_fault(record: TelemetryRecord, bit: int) -> None:
    """FAULT, with this among its reasons."""
    record.wait_for_state("FAULT")
    record.wait(lambda own: own.states[-1].faults_latched & 1 << bit, f"the fault {bit} among the latched")


def test_drive_first_then_torque_then_plant_killed_and_back(
    link: str, bus_address: str, domain: int, tmp_path: Path
) -> None:
    record = TelemetryRecord(domain)
    with drive_side(link, bus_address, domain, tmp_path) as drive, Vehicle(bus_address) as vehicle:
        vehicle.demand()
        drive.wait_for("no plant; the drive waits in INIT")
        record.wait_until_heard()
        record.wait_for_state("INIT")
        assert drive.text().count("no plant;") == 1
        with plant_side(link, tmp_path) as plant:
            drive.wait_for("the plant answers")
            torque_nm = np.median(at_torque(record, vehicle, TORQUE_NM).torque_mean_nm)
            print(f"torque {torque_nm:.2f} N·m of {TORQUE_NM} N·m")
            assert torque_nm == MEANT
            silences, answers = (drive.text().count(f"the plant {does}") for does in ("has timed out", "answers"))
            plant.kill()
            wait_for_fault(record, MEASUREMENT_INVALID)
            assert record.states[-1].first_fault == MEASUREMENT_INVALID
            assert record.states[-1].reason.startswith("MEASUREMENT_INVALID")
            drive.wait_for("the plant has timed out", count=silences + 1)
        with plant_side(link, tmp_path):
            drive.wait_for("the plant answers", count=answers + 1)
            bring_up(record, vehicle, TORQUE_NM)
        assert drive.leave() == 0
        assert "restarted 1 times" in drive.text()


def test_killed_drive_turns_the_gates_off_and_comes_back_locked_out(
    link: str, bus_address: str, domain: int, tmp_path: Path
) -> None:
    with plant_side(link, tmp_path) as plant, Vehicle(bus_address) as vehicle:
        with drive_side(link, bus_address, domain, tmp_path) as drive:
            drive.wait_for("the plant answers")
            at_torque(TelemetryRecord(domain), vehicle, TORQUE_NM, 0.1)
            before = len(openings(plant.text(), SILENT))
            drive.kill()
            opening = opening_after(plant, SILENT, before)
        # The gates are off before the drive is given up: a pattern that is not renewed acts no longer.
        assert opening.pattern_ns <= opening.opened_ns <= opening.seen_ns
        assert opening.seen_ns - opening.opened_ns >= 0.5 * SILENCE_MS * 1e6
        # The vehicle goes on demanding torque; a new drive must not follow before it has seen a disable.
        record = TelemetryRecord(domain)
        vehicle.demand(TORQUE_NM, enable=True)
        with drive_side(link, bus_address, domain, tmp_path) as drive:
            drive.wait_for("the plant answers")
            record.wait_until_heard()
            record.wait(lambda own: own.counted_commands()[0] >= 20, "commands that the new drive has heard")
            assert set(record.everything().states) <= {"INIT", "STANDBY", "FAULT"}
            assert drive.leave() == 0
        assert plant.leave() == 0
        assert "0 unreadable" in plant.text()


def test_stopped_drive_trips_its_own_watchdog_and_the_plants(
    link: str, bus_address: str, domain: int, tmp_path: Path
) -> None:
    with (
        plant_side(link, tmp_path) as plant,
        drive_side(link, bus_address, domain, tmp_path, SOON_WATCHDOG) as drive,
        Vehicle(bus_address) as vehicle,
    ):
        record = TelemetryRecord(domain)
        at_torque(record, vehicle, TORQUE_NM, 0.1)
        before = len(openings(plant.text(), SILENT))
        drive.stop()
        opening_after(plant, SILENT, before)
        time.sleep(1.5e-3 * SILENCE_MS)  # longer than the watchdog waits
        drive.go_on()
        wait_for_fault(record, WATCHDOG)
        bring_up(record, vehicle, TORQUE_NM)
        assert drive.leave() == 0


def test_watchdog_turns_the_gates_off_while_the_control_thread_hangs(
    link: str, bus_address: str, domain: int, tmp_path: Path
) -> None:
    """The plant's timeout of patterns is long, so that only the drive's own watchdog turns its gates off."""
    patient = ("hil.pattern_timeout_ms=60000", "plant.hold_periods=1000000")
    with (
        plant_side(link, tmp_path, *patient) as plant,
        drive_side(link, bus_address, domain, tmp_path, SOON_WATCHDOG) as drive,
        Vehicle(bus_address) as vehicle,
    ):
        record = TelemetryRecord(domain)
        at_torque(record, vehicle, TORQUE_NM, 0.1)
        before = len(openings(plant.text(), LINE_OFF))
        try:
            with HeldThread(thread_named(drive.process_id, CONTROL_THREAD)):
                opening_after(plant, LINE_OFF, before)  # while it hangs
        except PermissionError as error:
            pytest.skip(f"NOT TESTED: a thread of another process may not be held here: {error}")
        wait_for_fault(record, WATCHDOG)


@pytest.mark.skipif(len(os.sched_getaffinity(0)) < 2, reason="it needs two CPUs")
def test_the_plants_thread_has_its_cpu_alone(link: str, tmp_path: Path) -> None:
    cpus = os.sched_getaffinity(0)
    cpu = max(cpus)
    with plant_side(link, tmp_path, f"realtime.cpu={cpu}") as plant:
        plant.wait_for("plant on link")
        tasks = {int(task.name) for task in Path(f"/proc/{plant.process_id}/task").iterdir()}
        alone = {task for task in tasks if os.sched_getaffinity(task) == {cpu}}
        assert len(alone) == 1 and plant.process_id not in alone
        assert all(os.sched_getaffinity(task) == cpus - {cpu} for task in tasks - alone)
        assert plant.leave() == 0


def refusal(name: str, config: Path, *settings: str) -> str:
    command = [program(name), config, *overrides(settings)]
    found = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert found.returncode == 2, found
    lines = [line for line in found.stderr.splitlines() if line.startswith(f"{name}: ")]
    assert len(lines) == 1, found.stderr
    return lines[0]


@pytest.mark.parametrize(("name", "config"), [("sextant-plant", PLANT), ("sextant-ecu", DRIVE)])
def test_memory_of_another_version_is_refused(
    name: str, config: Path, link: str, bus_address: str, domain: int
) -> None:
    header = struct.pack("<QIIqII", 0x004C494854584553, 99, 4096, 0, 0, 0)
    memory = Path("/dev/shm", link)
    memory.touch(mode=0o600)
    memory.write_bytes(header.ljust(4096, b"\0"))
    own = () if name == "sextant-plant" else (f"can.bus={bus_address}", f"dds.domain={domain}")
    sentence = refusal(name, config, f"hil.link={link}", *own)
    assert "layout version 99, this program has 1" in sentence
    assert f"/dev/shm/{link}" in sentence


def test_a_second_plant_and_another_period_are_refused(
    link: str, bus_address: str, domain: int, tmp_path: Path
) -> None:
    with plant_side(link, tmp_path) as plant:
        plant.wait_for("plant on link")
        assert "already has a plant" in refusal("sextant-plant", PLANT, f"hil.link={link}")
        own = (f"can.bus={bus_address}", f"dds.domain={domain}", f"hil.link={link}")
        assert "a period of 250000 ns" in refusal("sextant-ecu", DRIVE, *own)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--frobnicate"], ["--frobnicate", "--help"]),
        (["no_such.toml"], ["no_such.toml"]),
        ([str(PLANT), "--set", "hil.link=a/b"], ["hil", "link must be a name"]),
        ([str(PLANT), "--set", "period_us=nan"], ["period_us", "got nan"]),
        ([str(PLANT), "--duration", "-1"], ["--duration", "-1"]),
    ],
)
def test_bad_input_of_the_plant_is_one_sentence(arguments: list[str], words: list[str]) -> None:
    found = subprocess.run(
        [program("sextant-plant"), *arguments], capture_output=True, text=True, timeout=120, check=False
    )
    assert found.returncode == 2
    assert found.stdout == ""
    assert found.stderr.startswith("sextant-plant: ")
    assert found.stderr.count("\n") == 1, found.stderr
    for word in words:
        assert word in found.stderr


def test_several_periods_a_wake_up_are_refused_in_real_time() -> None:
    sentence = refusal("sextant-ecu", DRIVE, "realtime.wake_every_periods=40")
    assert "realtime.wake_every_periods must be 1" in sentence


LONG = "hil.lockstep_timeout_ms=3600000"
LOCKSTEP = ("hil.pacing=lockstep", LONG, "drive.actuation_delay_periods=0")
# Far before hil.lockstep_timeout_ms gives up a side that is there but silent, which the tests set to an hour.
LOSS_SEEN_S = PATIENCE_S


def lockstep_command(link: str, seconds: float) -> list[str | Path]:
    """A whole drive in lockstep with the plant of a link, for so much virtual time."""
    default = ROOT / "build" / "dev" / "tests" / "hil" / "lockstep" / "sextant_lockstep_drive"
    command = [os.environ.get("SEXTANT_LOCKSTEP_DRIVE", default), ROOT / "configs" / "ecu.toml", link, str(seconds)]
    return [*command, "power_stage=shared_memory", "hil.pacing=lockstep", LONG]


def test_lockstep_runs_are_equal_bit_by_bit(link: str, tmp_path: Path) -> None:
    results = []
    for u_dc in (530, 530, 531):
        settings = (*LOCKSTEP, "period_us=25", f"plant.u_dc_v={u_dc}")
        with plant_side(link, tmp_path, *settings) as plant:
            found = subprocess.run(
                lockstep_command(link, 0.5), capture_output=True, text=True, timeout=500, check=False
            )
            assert found.returncode == 0, found.stderr
            assert plant.status(PATIENCE_S) == 0
        results.append(dict(line.split() for line in found.stdout.splitlines()))
        print(found.stdout)
    assert results[0]["state"] == "TORQUE"
    assert results[0]["digest"] == results[1]["digest"]
    assert results[0]["digest"] != results[2]["digest"], "the digest does not see the plant"


@contextmanager
def endless_lockstep_drive(link: str) -> Iterator[subprocess.Popen]:
    """The same with far more virtual time than a test waits for; ended with it, whatever happened."""
    with subprocess.Popen(lockstep_command(link, 1000), stderr=subprocess.PIPE, text=True) as drive:
        try:
            yield drive
        finally:
            drive.kill()


def test_a_dead_plant_ends_the_lockstep_with_a_sentence(link: str, tmp_path: Path) -> None:
    with plant_side(link, tmp_path, *LOCKSTEP, "period_us=25") as plant:
        plant.wait_for("in lockstep")
        with endless_lockstep_drive(link) as drive:
            plant.wait_for(JOINED)
            plant.kill()
            assert drive.wait(LOSS_SEEN_S) == 1
            assert drive.stderr.read() == "lockstep_drive: the plant is lost\n"


def test_a_dead_drive_ends_the_plant_of_a_lockstep_with_a_sentence(link: str, tmp_path: Path) -> None:
    with plant_side(link, tmp_path, *LOCKSTEP, "period_us=25") as plant:
        with endless_lockstep_drive(link) as drive:
            plant.wait_for(JOINED)
            drive.kill()
        assert plant.status(LOSS_SEEN_S) == 1
        assert f'sextant-plant: hil.link: the drive on "{link}" ended or timed out' in plant.text()


def test_the_drive_ends_by_itself_when_the_plant_of_its_lockstep_dies(
    link: str, bus_address: str, domain: int, tmp_path: Path
) -> None:
    settings = ("hil.pacing=lockstep", LONG, "realtime.wake_every_periods=4")
    with (
        plant_side(link, tmp_path, "hil.pacing=lockstep", LONG) as plant,
        drive_side(link, bus_address, domain, tmp_path, *settings) as drive,
    ):
        plant.wait_for(JOINED)
        TelemetryRecord(domain).wait_until_heard()
        plant.kill()
        assert drive.status(LOSS_SEEN_S) == 1
        assert f'sextant-ecu: hil.link: the plant on "{link}" ended or timed out' in drive.text()


def test_a_run_in_virtual_time_ends_with_its_plant(link: str, bus_address: str, domain: int, tmp_path: Path) -> None:
    with plant_side(link, tmp_path, "hil.pacing=lockstep", LONG) as plant:
        drive = drive_side(link, bus_address, domain, tmp_path, "hil.pacing=lockstep", LONG)
        # Far more virtual time than the test waits for.
        drive.command += ["--virtual-time", "--duration", "1000000"]
        with drive:
            plant.wait_for(JOINED)
            plant.kill()
            assert drive.status(LOSS_SEEN_S) == 1
        assert f'sextant-ecu: hil.link: the plant on "{link}" ended or timed out' in drive.text()


def test_a_drive_that_stood_still_for_less_than_its_watchdog_does_not_go_on(
    link: str, bus_address: str, domain: int, tmp_path: Path
) -> None:
    """Neither its watchdog nor the command supervision has seen anything; the plant has given it up meanwhile."""
    with (
        plant_side(link, tmp_path) as plant,
        drive_side(link, bus_address, domain, tmp_path) as drive,
        Vehicle(bus_address) as vehicle,
    ):
        record = TelemetryRecord(domain)
        at_torque(record, vehicle, TORQUE_NM, 0.1)
        silences = len(openings(plant.text(), SILENT))
        drive.stop()
        opening_after(plant, SILENT, silences)
        drive.go_on()
        wait_for_fault(record, MEASUREMENT_INVALID)
        assert not record.states[-1].faults_latched & 1 << WATCHDOG
        bring_up(record, vehicle, TORQUE_NM)
        assert drive.leave() == 0
        assert plant.leave() == 0
