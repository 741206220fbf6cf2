"""A live run, recorded by python-can, replays in virtual time as what it was."""

import csv
import re
import signal
import subprocess
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import can
import numpy as np
import pytest
from attempts import APART_NS, REPEATS
from drive_process import DriveProcess
from failures import SpoiltByHostError
from kernel import native_kernel_only
from programs import program
from sextant_py import bus as can_bus
from sextant_py import e2e
from sextant_py.contract import Contract
from sextant_py.paths import ROOT
from sextant_py.vcu import COMMAND

TORQUE_NM = 14.0
SECONDS = 0.8
PLANT = ("plant.integrator=fixed", "machine.inertia_kg_m2=0.5")


@dataclass(frozen=True)
class Played:
    """A profile that scripts/vcu has played to a drive."""

    log: Path
    status: int  # of the vehicle
    words: str  # what it had to say

    def disturbance(self) -> str | None:
        """What there is to say of commands that came too far apart to hold a torque, or past the recorder."""
        contract = Contract()
        decoded = ((frame.timestamp, contract.decode(frame)) for frame in can.LogReader(self.log))
        commands = [(time_s, found[1]["Counter"]) for time_s, found in decoded if found and found[0] == COMMAND]
        if len(commands) < 2:
            return None
        times_s, counters = np.array(commands, dtype=float).T
        missing = int(np.sum((np.diff(counters) - 1) % e2e.COUNTER_COUNT))
        if missing:
            return f"{missing} commands went past the recorder"
        apart_s = np.diff(times_s).max()
        return f"commands came {apart_s * 1e3:.0f} ms apart" if apart_s > APART_NS * 1e-9 else None


def play(address: str, start_drive: Callable[..., DriveProcess], folder: Path, attempt: int) -> Played:
    """sextant-ecu and scripts/vcu over a real bus, with python-can beside them."""
    log = folder / f"live.{attempt}.log"
    profile = folder / "profile.csv"
    profile.write_text(f"time_s,torque_nm\n0,{TORQUE_NM}\n{SECONDS},{TORQUE_NM}\n", encoding="utf-8")
    listener = can_bus.open_bus(can_bus.parse(address))
    with can.CanutilsLogWriter(log) as writer:
        notifier = can.Notifier(listener, [writer])
        drive = start_drive(address, *PLANT)
        try:
            vcu = [ROOT / "scripts" / "vcu", "--profile", profile, "--can", address, "--quiet"]
            found = subprocess.run(vcu, capture_output=True, text=True, check=False, timeout=60)
            drive.leave(signal.SIGTERM)
        finally:
            notifier.stop()
            listener.shutdown()
    return Played(log, found.returncode, found.stdout + found.stderr)


def replayed(log: Path, table: Path) -> tuple[str, list[dict[str, str]]]:
    """The report of a replay, and its telemetry."""
    command = [program("sextant-ecu"), ROOT / "configs" / "ecu.toml", "--virtual-time", log, "--telemetry-out", table]
    for setting in PLANT:
        command += ["--set", setting]
    found = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert found.returncode == 0, found.stderr
    with table.open(encoding="utf-8") as file:
        return found.stdout, list(csv.DictReader(file))


def test_a_live_recording_replays(live_bus: str, start_drive: Callable[..., DriveProcess], tmp_path: Path) -> None:
    native_kernel_only()
    for attempt in range(1 + REPEATS):
        played = play(live_bus, start_drive, tmp_path, attempt)
        reason = played.disturbance()
        if reason is None:
            break
        print(f"recording, attempt {attempt + 1} disturbed by the host: {reason}")
    else:
        raise SpoiltByHostError(f"each of {1 + REPEATS} recordings was disturbed")
    assert played.status == 0, played.words
    report, rows = replayed(played.log, tmp_path / "run.csv")
    assert re.search(r"commands \d+ accepted, 0 rejected", report), report
    torque = np.array([float(row["torque_mean_nm"]) for row in rows if row["state"] == "TORQUE"])
    print(f"{len(torque)} ms in TORQUE, {torque[100:700].mean():.2f} N·m of {TORQUE_NM:g} N·m")
    assert 0.7 < len(torque) * 1e-3 < 1.2
    assert torque[100:700].mean() == pytest.approx(TORQUE_NM, abs=2.5)
