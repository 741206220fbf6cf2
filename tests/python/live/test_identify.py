"""scripts/identify --live against the simulated plant, and Ctrl-C in a course. The drive runs half or a quarter of a
second of control periods at each wake-up, so that a machine that stands still for less misses none."""

import os
import signal
import subprocess
import sys
import time
import tomllib
from pathlib import Path

import h5py
import numpy as np
import pytest
from drive_process import WIDE
from programs import ProgramProcess, overrides, program
from sextant_py import identify
from sextant_py.paths import ROOT

SETTINGS = (
    *WIDE,
    *("drive.period_us=200", "plant.integrator=fixed", "plant.inverter.dead_time_us=3"),
    *("realtime.wake_every_periods=2500", "dds.telemetry_rate_hz=100"),
    *("control.commissioning.levels=2", "control.commissioning.settle_ms=500", "control.commissioning.hold_ms=50"),
)
STARTED_S = 60.0


# A torque that the drive has to hear of soon.
OFTEN = "realtime.wake_every_periods=1250"


def words_of(bus: str, domain: int, out: Path, only: str = "dead_time") -> list[str]:
    often = (OFTEN,) if only == "inertia" else ()
    settings = overrides((*SETTINGS, f"dds.domain={domain}", *often))
    words = [str(ROOT / "configs" / "ecu_foc.toml"), "--live", "--only", only, "--can", bus, "--out", str(out)]
    return [*words, "--ecu", str(program("sextant-ecu")), *settings]


def test_a_live_drive_finds_dead_time_and_resistance(
    live_bus: str, domain: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert identify.main(words_of(live_bus, domain, tmp_path)) == 0
    said = capsys.readouterr().out
    assert "drive: TORQUE" in said, "its progress"
    assert "levels: over, the drive is off" in said
    inverter, machine = (tomllib.loads((tmp_path / f"{name}.toml").read_text()) for name in ("inverter", "machine"))
    assert inverter["dead_time_us"] == pytest.approx(3, rel=0.1)
    assert machine["r_s_ohm"] == pytest.approx(0.435, rel=0.03)


def test_a_live_drive_turns_a_free_shaft_and_finds_its_inertia(
    live_bus: str, domain: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert identify.main(words_of(live_bus, domain, tmp_path, "inertia")) == 0
    said = capsys.readouterr().out
    assert "rad/s" in said, "its progress"
    assert "inertia: over, the drive is off" in said
    machine = tomllib.loads((tmp_path / "machine.toml").read_text(encoding="utf-8"))
    assert machine["inertia_kg_m2"] == pytest.approx(0.5, rel=0.03)  # of configs/ecu_foc.toml


@pytest.mark.parametrize(("only", "course"), [("dead_time", "levels"), ("inertia", "inertia")])
def test_ctrl_c_in_a_course_turns_the_gates_off(
    only: str, course: str, live_bus: str, domain: int, tmp_path: Path
) -> None:
    command = [sys.executable, "-m", "sextant_py.identify", *words_of(live_bus, domain, tmp_path, only)]
    environment = os.environ | {"PYTHONPATH": str(ROOT / "scripts"), "PYTHONUNBUFFERED": "1"}
    # A session of its own: the signal goes to this program alone, and its drive has to hear of it over CAN.
    own = {"env": environment, "start_new_session": True, "stderr": subprocess.STDOUT}
    with ProgramProcess(command, tmp_path / "said.txt", **own) as running:
        deadline = time.monotonic() + STARTED_S
        while "drive: TORQUE" not in running.text():
            assert running.is_running() and time.monotonic() < deadline, running.text()
            time.sleep(0.05)
        running.send_signal(signal.SIGINT)
        assert running.wait(STARTED_S) == 130, running.text()
        assert f"{course}: stopped, the drive is off" in running.text()
    with h5py.File(tmp_path / f"{course}_cycles.h5") as recording:
        assert "dropped" in recording.attrs, "it was closed"
        cycles = recording["cycles"][()]
    enabled = cycles["enable"].astype(bool)
    ends = np.flatnonzero(enabled)[-1] + 1
    assert ends < cycles["enable"].size, "the drive got a disable"
    pattern = cycles["pattern"]
    parts = np.arange(pattern["state"].shape[1]) < pattern["segments"][:, None]
    driven = np.any(parts & (pattern["state"] & 0b111000 != 0), axis=1)
    assert driven[ends - 1]
    assert not driven[ends:].any()
