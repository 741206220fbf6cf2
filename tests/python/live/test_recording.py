"""A live run, recorded by python-can, replays in virtual time as what it was."""

import csv
import re
import signal
import subprocess
from collections.abc import Callable
from pathlib import Path

import can
import numpy as np
import pytest
from drive_process import WIDE, DriveProcess
from frame_log import widen
from kernel import native_kernel_only
from programs import overrides, program
from sextant_py import bus as can_bus
from sextant_py.commander import COMMAND
from sextant_py.contract import Contract
from sextant_py.paths import ROOT
from sextant_py.reports import STATUS

TORQUE_NM = 14.0
SECONDS = 0.8
SETTINGS = ("plant.integrator=fixed", "machine.inertia_kg_m2=0.5", *WIDE)
SECONDS_PER_SAMPLE = 1e-3
AN_END_S = 0.1  # what hand-shake and the end of a run may take


def play(address: str, start_drive: Callable[..., DriveProcess], folder: Path) -> Path:
    """sextant-ecu and scripts/vcu over a real bus, with python-can beside them; the recording."""
    log = folder / "live.log"
    profile = folder / "profile.csv"
    profile.write_text(f"time_s,torque_nm\n0,{TORQUE_NM}\n{SECONDS},{TORQUE_NM}\n", encoding="utf-8")
    listener = can_bus.open_bus(can_bus.parse(address))
    widen(listener)
    with can.CanutilsLogWriter(log) as writer:
        notifier = can.Notifier(listener, [writer])
        drive = start_drive(address, *SETTINGS)
        try:
            vcu = [ROOT / "scripts" / "vcu", "--profile", profile, "--can", address, "--quiet", "--timeout", "60"]
            found = subprocess.run(vcu, capture_output=True, text=True, check=False, timeout=300)
            drive.leave(signal.SIGTERM)
        finally:
            notifier.stop()
            listener.shutdown()
    assert found.returncode == 0, found.stdout + found.stderr
    # The kernel may stamp two datagrams in another order than it hands them over in.
    lines = log.read_text(encoding="utf-8").splitlines(keepends=True)
    log.write_text("".join(sorted(lines, key=lambda line: float(line.split()[0].strip("()")))), encoding="utf-8")
    return log


def replayed(log: Path, folder: Path) -> tuple[str, list[dict[str, str]], Path]:
    """The report of a replay, its telemetry and its frames."""
    table, frames = folder / "run.csv", folder / "replay.log"
    command = [program("sextant-ecu"), ROOT / "configs" / "ecu.toml", "--virtual-time", log, *overrides(SETTINGS)]
    command += ["--telemetry-out", table, "--frames-out", frames]
    found = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    assert found.returncode == 0, found.stderr
    with table.open(encoding="utf-8") as file:
        return found.stdout, list(csv.DictReader(file)), frames


def signals_of(log: Path, message: str) -> list[tuple[float, dict]]:
    """Every frame of a message, with its time."""
    contract = Contract()
    decoded = ((frame.timestamp, contract.decode(frame)) for frame in can.LogReader(log))
    return [(time_s, found[1]) for time_s, found in decoded if found and found[0] == message]


def states_of(log: Path) -> list[str]:
    """The states that the drive has told over CAN, each once as long as it lasts. Its first periods nobody may hear."""
    found: list[str] = []
    for _, signals in signals_of(log, STATUS):
        state = str(signals["DriveState"])
        if state != "INIT" and found[-1:] != [state]:
            found.append(state)
    return found


def test_a_live_recording_replays(live_bus: str, start_drive: Callable[..., DriveProcess], tmp_path: Path) -> None:
    native_kernel_only()
    log = play(live_bus, start_drive, tmp_path)
    enabled_s = [time_s for time_s, signals in signals_of(log, COMMAND) if str(signals["Enable"]) == "ENABLE"]
    report, rows, frames = replayed(log, tmp_path)
    assert re.search(r"commands \d+ accepted, 2 rejected", report), report
    torque = np.array([float(row["torque_mean_nm"]) for row in rows if row["state"] == "TORQUE"])
    print(f"{len(torque)} ms in TORQUE, {np.median(torque):.2f} N·m of {TORQUE_NM:g} N·m")
    # As long as the vehicle asked for it, however long that was, and in the order of states that was seen live.
    assert len(torque) * SECONDS_PER_SAMPLE == pytest.approx(enabled_s[-1] - enabled_s[0], abs=AN_END_S)
    assert np.median(torque) == pytest.approx(TORQUE_NM, abs=2.5)
    heard = states_of(log)
    assert heard[:2] in (["STANDBY", "READY"], ["READY", "MAGNETISING"]), "at most the first state was over too soon"
    assert states_of(frames)[-len(heard) :] == heard
