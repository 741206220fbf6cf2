"""Part of the stage `live`: how soon the gates of a plant in another process open when its drive dies or hangs."""

import contextlib
import os
import re
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TypeVar

from sextant_py import bus as can_bus
from sextant_py.contract import Contract
from sextant_py.errors import UserError
from sextant_py.paths import ROOT
from sextant_py.vcu import STATUS, Reports

from . import live_runs
from .figure import Figure, NotMeasurableError
from .lab import Lab

Found = TypeVar("Found")
ROUNDS = 5
KILLED_MS, HUNG_MS = 10.0, 5.0
WATCHDOG_MS, WATCHDOG_LOOKS_MS = 10, 2  # the drive's watchdog compares every 2 ms
HOG_PRIORITY, HOG_S = 95, 0.3  # above the control thread, and shorter than the kernel's throttling
SILENT, LINE_OFF = "the drive is silent", "the gate-enable line is off"
BUS = "udp_multicast:239.74.163.2:43178"
PROFILE = "time_s,torque_nm\n0,10\n30,10\n"
BEGIN_WITHIN_S = 20.0
# A period that a shared machine holds, and a link voltage at which a period's torque stays small.
COMMON = {"plant__u_dc_v": 200}
PLANT = {"period_us": 250, "load__kind": "imposed_speed", "load__speed_rad_s__value": 5}
DRIVE = {"control__period_us": 250, "hil__stale_ms": 20, "hil__missing_periods": 80}
# Only the drive's own watchdog can open the gates of a plant that waits for ever.
PATIENT = {"hil__silence_ms": 60000, "plant__hold_periods": 1000000}

# Takes its CPU away from everything below its priority, and says since when.
HOG = f"""
import os, sys, time
os.sched_setaffinity(0, {{int(sys.argv[1])}})
os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param({HOG_PRIORITY}))
since = time.monotonic_ns()
while time.monotonic_ns() - since < {HOG_S} * 1e9:
    pass
print(since)
"""


@contextlib.contextmanager
def program(command: list[str], out: Path) -> Iterator[subprocess.Popen]:
    """Its output goes to a file, where it can be read while it runs."""
    with out.open("wb") as text:
        running = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=text, stderr=subprocess.STDOUT, env=live_runs.environment()
        )
    try:
        yield running
    finally:
        running.terminate()
        try:
            running.wait(10)
        except subprocess.TimeoutExpired:
            running.kill()
            running.wait()


def openings_ns(plant_text: str, cause: str) -> list[tuple[int, int]]:
    """Of each opening for that cause: since when the gates were open, and when the plant knew it [ns]."""
    found = re.findall(rf"gates stay open since ([\d.]+) s: {cause};.* seen at ([\d.]+) s", plant_text)
    return [(round(float(since) * 1e9), round(float(seen) * 1e9)) for since, seen in found]


def until(what: str, look: Callable[[], Found | None], within_s: float = BEGIN_WITHIN_S) -> Found:
    end = time.monotonic() + within_s
    while (found := look()) is None:
        if time.monotonic() > end:
            raise UserError(f"{what} did not come within {within_s:g} s")
        time.sleep(0.002)
    return found


def wait_for_torque(reports: Reports) -> None:
    def look() -> bool | None:
        status = reports.latest.get(STATUS, {})
        return True if reports.state() == "TORQUE" and status["TorqueEstimated"] > 2.0 else None

    until("torque of the drive on a plant in another process", look)
    time.sleep(0.2)


def opening_ms(lab: Lab, stop: Callable[[subprocess.Popen], int], which: int, cause: str, **patience: object) -> float:
    """From the time that `stop` returns to the opening of the gates; which: 0 counts until they were open, 1 until the
    plant knew it."""
    link = f"sextant_bench_{os.getpid()}_{time.monotonic_ns()}"
    own = {"hil__link": link, **COMMON}
    cpus = live_runs.other_cpus().split(",")
    plant_out, profile = lab.out / "gates_plant.txt", lab.out / "gates.csv"
    profile.write_text(PROFILE, encoding="utf-8")
    plant = [str(live_runs.PROGRAMS / "sextant-plant"), str(ROOT / "configs" / "plant.toml")]
    plant += live_runs.settings(**own, **PLANT, **patience, realtime__cpu=cpus[0])
    drive = [str(live_runs.PROGRAMS / "sextant-ecu"), str(ROOT / "configs" / "ecu_hil.toml"), "--can", BUS]
    drive += live_runs.settings(
        **own, **DRIVE, realtime__cpu=live_runs.measured_cpu(), realtime__watchdog_ms=WATCHDOG_MS
    )
    vcu = [sys.executable, "-m", "sextant_py.vcu", "--can", BUS, "--profile", str(profile), "--reset-faults"]
    bus = can_bus.open_bus(can_bus.parse(BUS))
    reports = Reports(bus, Contract())
    reports.start()
    try:
        with (
            program(plant, plant_out),
            program(drive, lab.out / "gates_drive.txt") as running,
            program([*vcu, "--timeout", str(BEGIN_WITHIN_S)], lab.out / "gates_vcu.txt"),
        ):
            wait_for_torque(reports)
            before = len(openings_ns(plant_out.read_text(encoding="utf-8"), cause))
            stopped_ns = stop(running)

            def look() -> tuple[int, int] | None:
                # An opening before the stop was another one.
                new = openings_ns(plant_out.read_text(encoding="utf-8"), cause)[before:]
                return next((one for one in new if one[which] > stopped_ns), None)

            return (until("an opening of the gates", look, 5.0)[which] - stopped_ns) * 1e-6
    finally:
        reports.stop()
        bus.shutdown()


def kill(drive: subprocess.Popen) -> int:
    sent_ns = time.monotonic_ns()
    drive.kill()
    return sent_ns


def hang(_: subprocess.Popen) -> int:
    """The control thread's CPU is taken away for a while; the watchdog's thread has the others."""
    hog = subprocess.run([sys.executable, "-c", HOG, str(live_runs.measured_cpu())], capture_output=True, text=True)
    if hog.returncode != 0:
        raise UserError(f"the control thread's CPU cannot be taken away: {hog.stderr.strip()[-200:]}")
    return int(hog.stdout)


def rounds(lab: Lab, name: str, measure: Callable[[], float]) -> tuple[float, str]:
    """The median of the rounds, and what came out of them."""
    found = []
    for number in range(ROUNDS):
        found.append(measure())
        lab.say(f"{name}, round {number + 1} of {ROUNDS}: {found[-1]:.2f} ms")
    return statistics.median(found), f"{min(found):.3g} to {max(found):.3g} in {len(found)} rounds"


def killed(lab: Lab) -> list[Figure]:
    live_runs.require_real_time()
    value, note = rounds(lab, "drive killed", lambda: opening_ms(lab, kill, 1, SILENT))
    measure = "HIL: from SIGKILL of the drive at torque until its plant has opened the gates and declared it dead"
    return [Figure(measure, value, unit="ms", at_most=KILLED_MS, note=note)]


def hung(lab: Lab) -> list[Figure]:
    live_runs.require_real_time()
    if len(os.sched_getaffinity(0)) < 2:
        raise NotMeasurableError("a watchdog beside a control thread that hangs needs a second processor")
    value, note = rounds(
        lab, "control thread hung", lambda: opening_ms(lab, hang, 0, LINE_OFF, **PATIENT) - WATCHDOG_MS
    )
    return [
        Figure(
            "HIL: from the end of the watchdog's time to open gates, while the drive's control thread hangs",
            value,
            unit="ms",
            at_most=HUNG_MS + WATCHDOG_LOOKS_MS,
            wanted=f"≤ {HUNG_MS:g} ms from detection on, every {WATCHDOG_LOOKS_MS} ms",
            note=note,
        )
    ]
