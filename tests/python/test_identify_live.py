"""scripts/identify with sextant-ecu: in virtual time, and what ends a course."""

import re
import sys
import time
import tomllib
from pathlib import Path

import h5py
import numpy as np
import pytest
import sextant
from programs import overrides, program
from sextant_py import identify, identify_command, identify_live
from sextant_py.errors import UserError
from sextant_py.identify_live import EcuProcess, replayed
from sextant_py.identify_machine import estimate_of
from sextant_py.identify_run import CONTROL, gaps_of, undisturbed
from test_identify import MACHINE, drive_file
from test_virtual_time import launch

PERIOD_S = 250e-6
COURSE = ("control.controller=commissioning", "drive.magnetise_first=false", "drive.period_us=250")
SHORT = (f"{CONTROL}settle_ms=100", f"{CONTROL}hold_ms=20")
FIXED = "plant.integrator=fixed"


def words_of(file: Path, *settings: str) -> list[str]:
    own = overrides(("drive.period_us=250", FIXED, *settings))
    return [str(file), "--virtual-time", "--out", str(file.parent), "--ecu", str(program("sextant-ecu")), *own]


def toml_of(file: Path) -> dict:
    return tomllib.loads(file.read_text(encoding="utf-8"))


def legs_off(pattern: np.ndarray) -> np.ndarray:
    """Of each row whether no leg is driven in any of its segments: bits 3 to 5 of a state say which legs are."""
    parts = np.arange(pattern["state"].shape[1]) < pattern["segments"][:, None]
    return ~np.any(parts & (pattern["state"] & 0b111000 != 0), axis=1)


def cycles_of(file: Path) -> np.ndarray:
    with h5py.File(file) as recording:
        return recording["cycles"][()]


def test_a_drive_of_the_ecu_finds_its_machine_and_inverter(tmp_path: Path) -> None:
    """With a wrong estimate of the rotor. Each pattern of the course comes again in the replay, or it is refused."""
    file = drive_file(tmp_path, "[control.machine_estimate]\nr_r_ohm = 1.0\nx_m_ohm = 21\n")
    fewer = (f"{CONTROL}levels=2", f"{CONTROL}tones=3", f"{CONTROL}blocks=2", f"{CONTROL}hold_ms=40")
    assert identify.main([*words_of(file, "plant.inverter.dead_time_us=3", *fewer), "--limit-a", "24"]) == 0
    told = toml_of(tmp_path / "machine.toml")
    found = estimate_of({f"machine.{key}": value for key, value in told.items()}).terminals
    true = estimate_of({f"machine.{key}": value for key, value in toml_of(MACHINE).items()}).terminals
    for name, value in vars(true).items():
        assert getattr(found, name) == pytest.approx(value, rel=0.01), name
    assert toml_of(tmp_path / "inverter.toml")["dead_time_us"] == pytest.approx(3, rel=0.01)
    of_the_flux = 1.1 / ((21 + 0.754) / (2 * np.pi * 50))
    for course, limit in (("tones", of_the_flux), ("levels", 24)):
        cycles = cycles_of(tmp_path / f"{course}_cycles.h5")
        assert 0.9 * limit < np.abs(cycles["i_a_a"]).max() < limit, "the limit of the current"


def shaft_words(file: Path, *settings: str) -> list[str]:
    return [*words_of(file, "control.machine_estimate.inertia_kg_m2=0.05", *settings), "--only", "inertia"]


def test_a_free_shaft_of_the_ecu_tells_its_inertia_and_is_braked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """J of the paper's machine, with friction and load; by a wrong estimate, behind which a second course follows."""
    file = drive_file(tmp_path)
    assert identify.main(shaft_words(file, "plant.viscous_friction_nm_s=0.02", "load.torque_nm.value=1")) == 0
    assert toml_of(tmp_path / "machine.toml") == {"inertia_kg_m2": pytest.approx(0.089, rel=0.01)}
    said = capsys.readouterr().out
    assert float(re.search(r"load +(-?[0-9.]+) N·m", said)[1]) == pytest.approx(1, abs=0.2)
    cycles = cycles_of(tmp_path / "inertia_cycles.h5")
    speed, off = cycles["speed_rad_s"], legs_off(cycles["pattern"])
    assert np.max(np.abs(speed)) > 20
    assert np.abs(speed[~off][-1]) < 2, "the drive brakes the shaft"


def test_a_coasting_shaft_of_the_ecu_tells_the_inductance_and_the_curve(tmp_path: Path) -> None:
    file = drive_file(tmp_path, "[plant.saturation]\nknee_wb = 1.1\nmachine_flux_wb = 1.1\n")
    words = [*words_of(file, f"{CONTROL}tones=3", f"{CONTROL}blocks=2"), "--only", "impedance,no_load"]
    assert identify.main(words) == 0
    told = toml_of(tmp_path / "machine.toml")
    true = estimate_of({f"machine.{key}": value for key, value in toml_of(MACHINE).items()}).terminals
    found = estimate_of({f"machine.{key}": value for key, value in told.items() if key != "saturation"}).terminals
    assert found.l_magnetising == pytest.approx(true.l_magnetising, rel=0.02)
    assert told["saturation"]["knee_wb"] == pytest.approx(1.1, rel=0.02)


def test_an_over_speed_in_a_course_of_torque_ends_it(tmp_path: Path) -> None:
    words = shaft_words(drive_file(tmp_path), "protection.over_speed_rad_s=10")
    with pytest.raises(
        UserError, match=r"the drive tripped with OVER_SPEED at .*, before the course of inertia was over"
    ):
        identify.main(words)
    cycles = cycles_of(tmp_path / "inertia_cycles.h5")
    over = np.flatnonzero(np.abs(cycles["speed_rad_s"]) > 10)[0]
    assert legs_off(cycles["pattern"])[over:].all()
    assert not (tmp_path / "machine.toml").exists()


def test_a_shaft_that_turns_before_a_course_or_is_held_in_it_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(identify_command, "REST_S", 1.0)
    file = drive_file(tmp_path)
    with pytest.raises(UserError, match=r"the shaft turns at 20 rad/s before the course of inertia.*come to rest"):
        identify.main(shaft_words(file, "plant.initial_speed_rad_s=20"))
    assert legs_off(cycles_of(tmp_path / "inertia_cycles.h5")["pattern"]).all(), "no enable was sent"
    with pytest.raises(UserError, match="free to turn"):
        identify.main(shaft_words(file, "load.kind=imposed_speed"))


@pytest.fixture
def stopped(tmp_path: Path) -> np.ndarray:
    """Control periods of a course that a disable ends after 0.3 s, begun anew, and left without commands."""
    with sextant.Vcu(log=tmp_path / "commands.log") as vcu:
        vcu.run(0.1)
        vcu.demand(0.0, enable=True)
        vcu.run(0.3)
        vcu.disable()
        vcu.demand(0.0, enable=True)
        vcu.run(0.3)
        vcu.spoil("lost", 60)
        vcu.run(0.6)
    cycles = tmp_path / "cycles.h5"
    words = ["--virtual-time", tmp_path / "commands.log", "--record-cycles", cycles]
    found = launch(drive_file(tmp_path), *words, *overrides((*COURSE, *SHORT, FIXED)))
    assert "COMMAND_LOST" in found.stderr
    return cycles_of(cycles)


def test_no_gate_is_on_from_the_period_of_a_disable_or_a_lost_command(stopped: np.ndarray) -> None:
    off = legs_off(stopped["pattern"])
    enabled = stopped["enable"].astype(bool)
    falls = np.flatnonzero(enabled[:-1] & ~enabled[1:]) + 1
    assert np.abs(stopped["i_a_a"][falls[0] - 1]) > 10, "a current flows"
    assert not off[falls[0] - 1]
    assert off[~enabled].all(), "in the same period, and for as long as it holds"
    lost = np.flatnonzero(enabled & (stopped["t_ns"] - stopped["received_ns"] > 201e6))
    assert lost.size > 1000
    assert off[lost].all()
    assert not off[enabled].all()


def test_an_over_current_in_a_course_trips_and_ends_it(tmp_path: Path) -> None:
    file = drive_file(tmp_path)
    words = words_of(file, "protection.over_current_a=50", *SHORT)
    with pytest.raises(UserError, match="the drive tripped with OVER_CURRENT, before the course of levels") as refused:
        identify.main([*words, "--only", "dead_time", "--limit-a", "60"])
    assert "\n" not in str(refused.value)
    cycles = cycles_of(tmp_path / "levels_cycles.h5")
    over = np.flatnonzero(np.abs(cycles["i_a_a"]) > 50)[0]
    off = legs_off(cycles["pattern"])
    assert not off[over - 1]
    assert off[over:].all()
    assert not (tmp_path / "machine.toml").exists()


def test_a_recording_that_is_not_what_the_drive_did_is_refused(tmp_path: Path) -> None:
    words = words_of(drive_file(tmp_path), *SHORT)
    assert identify.main([*words, "--only", "dead_time"]) == 0
    cycles = tmp_path / "levels_cycles.h5"
    with h5py.File(cycles, "r+") as recording:
        rows = recording["cycles"][()]
        rows["i_a_a"][rows.size // 2] += 1
        recording["cycles"][...] = rows
    with pytest.raises(UserError, match="does not replay as it was recorded"):
        replayed(program("sextant-ecu"), cycles, tmp_path / "again.h5")


@pytest.mark.parametrize("period_ns", [25_000, 100_000, 125_000])
def test_one_missed_period_is_a_gap_of_a_trace(tmp_path: Path, period_ns: int) -> None:
    interval_ns = 1_000_000 // period_ns * period_ns
    time_ns = 5 * period_ns + interval_ns * np.arange(1, 9)
    time_ns[4:] += period_ns
    with h5py.File(tmp_path / "trace.h5", "w") as trace:
        trace["t_ns"] = time_ns
        trace.attrs["interval_ns"], trace.attrs["control_period_ns"] = interval_ns, period_ns
    assert gaps_of(tmp_path / "trace.h5").tolist() == [pytest.approx(1e-9 * time_ns[3])]


@pytest.mark.parametrize(
    ("script", "said"),
    [
        ("import time; time.sleep(60)", "ended with status -15: see that the power stage is off"),
        ("import signal; signal.signal(15, lambda *_: exit(0)); print(flush=True); signal.pause()", "the drive is off"),
        (
            "import signal; signal.signal(15, signal.SIG_IGN); print(flush=True)\nwhile True: signal.pause()",
            "ended with status -9: see that the power stage is off",
        ),
    ],
)
def test_the_drive_is_off_where_its_program_shut_it_down(
    script: str, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(identify_live, "LEAVE_S", 0.3 if "IGN" in script else 20.0)
    log = tmp_path / "log"
    with EcuProcess([sys.executable, "-c", script], log) as ecu:
        assert "has not ended yet" in ecu.end
        end_s = time.monotonic() + 20
        while "print" in script and not log.stat().st_size and time.monotonic() < end_s:
            time.sleep(0.01)
    assert said in ecu.end


def test_levels_with_missed_periods_do_not_count() -> None:
    """Levels of 0.5 s after 0.1 s: a gap in one spoils it alone, in the settling too. A block of a tone is spoiled by a
    gap in the block before as well, which the rotor has not forgotten."""
    configuration = {f"{CONTROL}settle_ms": 400.0, f"{CONTROL}hold_ms": 100.0, "drive.period_us": 250.0}
    levels = [{"end_s": 0.6 + 0.5 * k, "tone_periods": 0.0} for k in range(8)]
    gaps = np.array([0.05, 1.2, 1.56, 5.0])
    assert undisturbed(levels, gaps, "levels", configuration) == levels[:2] + levels[3:]
    blocks = [{"end_s": 0.6 + 0.1 * k, "tone_periods": 400.0} for k in range(12)]
    kept = undisturbed(blocks, np.array([0.85]), "tones", configuration)
    assert [block["end_s"] for block in blocks if block not in kept] == pytest.approx([0.9, 1.0, 1.1, 1.2, 1.3])
    with pytest.raises(UserError, match=r"missed control periods in 5 of 8 levels.*docs/realtime\.md"):
        undisturbed(levels, np.array([0.3, 0.8, 1.3, 1.8, 2.3]), "levels", configuration)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--live", "--only", "no_load"], "no_load needs impedance"),
        (["--can", "udp_multicast:239.74.163.2"], "--can needs --live"),
        (["--ecu", "sextant-ecu"], "--ecu needs --live"),
        (["--virtual-time", "--mil", "sextant-mil"], "--ecu names it"),
        (["--virtual-time", "--live"], "not allowed with"),
    ],
)
def test_options_that_do_not_go_together_are_refused(
    words: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        identify.parse_arguments(["x.toml", *words])
    assert said in capsys.readouterr().err


def test_a_file_that_the_ecu_refuses_is_one_sentence(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"sextant-ecu refuses the drive: .*period_us"):
        identify.main(words_of(drive_file(tmp_path), "drive.period_us=-1"))
