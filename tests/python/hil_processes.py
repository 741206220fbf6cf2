"""sextant-plant and sextant-ecu as two processes on one link."""

import ctypes
import os
import re
import signal
import subprocess
import time
from pathlib import Path

from drive_process import program
from sextant_py.paths import LOOPBACK, ROOT

PLANT = ROOT / "configs" / "plant.toml"
DRIVE = ROOT / "configs" / "ecu_hil.toml"
# Slow enough for two processes on a machine that others share; the low link voltage keeps a period's torque small.
SLOW = ("plant.u_dc_v=200",)
PERIOD_US = 250


class Side:
    """One program of the two; a context that ends it whatever happened."""

    def __init__(self, name: str, config: Path, folder: Path, settings: tuple[str, ...]) -> None:
        self.name = name
        self.command = [str(program(name)), str(config)]
        for setting in settings:
            self.command += ["--set", setting]
        self._out = folder / f"{name}.{time.monotonic_ns()}.out"
        self._process: subprocess.Popen | None = None

    def __enter__(self) -> "Side":
        with self._out.open("wb") as out:
            self._process = subprocess.Popen(
                self.command,
                stdin=subprocess.DEVNULL,
                stdout=out,
                stderr=subprocess.STDOUT,
                env={**os.environ, "CYCLONEDDS_URI": LOOPBACK.read_text(encoding="utf-8")},
            )
        return self

    def __exit__(self, *_: object) -> None:
        if self._process.poll() is None:
            self._process.terminate()
            try:
                self._process.wait(5)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()

    def kill(self) -> int:
        """SIGKILL; the time at which it was sent, on CLOCK_MONOTONIC [ns]."""
        sent_ns = time.monotonic_ns()
        self._process.send_signal(signal.SIGKILL)
        self._process.wait()
        return sent_ns

    def signal(self, how: signal.Signals) -> None:
        self._process.send_signal(how)

    @property
    def process_id(self) -> int:
        return self._process.pid

    def leave(self) -> int:
        self._process.terminate()
        return self._process.wait(10)

    def status(self, timeout_s: float) -> int:
        return self._process.wait(timeout_s)

    def text(self) -> str:
        return self._out.read_text(encoding="utf-8")

    def wait_for(self, words: str, timeout_s: float = 10.0, count: int = 1) -> str:
        """Its output, once it holds the words so many times."""
        end = time.monotonic() + timeout_s
        while self.text().count(words) < count:
            assert self._process.poll() is None, f"{self.name} has ended: {self.text()}"
            assert time.monotonic() < end, f"{self.name} never said {words!r}: {self.text()}"
            time.sleep(0.005)
        return self.text()


def plant_side(link: str, folder: Path, *settings: str) -> Side:
    shaft = ("load.kind=imposed_speed", "load.speed_rad_s.value=5")
    own = (f"hil.link={link}", f"period_us={PERIOD_US}", *SLOW, *shaft, *settings)
    return Side("sextant-plant", PLANT, folder, own)


def drive_side(link: str, bus: str, domain: int, folder: Path, *settings: str) -> Side:
    own = (
        f"hil.link={link}",
        f"can.bus={bus}",
        f"dds.domain={domain}",
        f"control.period_us={PERIOD_US}",
        "hil.stale_ms=20",
        "hil.missing_periods=80",  # as long: the machine has other work
        *SLOW,
        *settings,
    )
    return Side("sextant-ecu", DRIVE, folder, own)


def openings_ns(plant_text: str, cause: str) -> list[tuple[int, int, int]]:
    """Of each opening for that cause: when the gates opened, the last pattern's time, when it was seen [ns]."""
    pattern = rf"gates stay open since ([\d.]+) s: {cause}; last pattern at ([\d.]+) s, .* seen at ([\d.]+) s"
    return [tuple(round(float(x) * 1e9) for x in found) for found in re.findall(pattern, plant_text)]


PTRACE_SEIZE, PTRACE_INTERRUPT, PTRACE_DETACH = 0x4206, 0x4207, 17


class HeldThread:
    """One thread of a process, held for the time of a `with` while the others run on."""

    def __init__(self, thread_id: int) -> None:
        self._id = thread_id
        self._libc = ctypes.CDLL(None, use_errno=True)
        self.since_ns = 0

    def _ask(self, request: int) -> None:
        if self._libc.ptrace(request, self._id, None, None) != 0:
            raise OSError(ctypes.get_errno(), "ptrace")

    def __enter__(self) -> "HeldThread":
        self._ask(PTRACE_SEIZE)
        self._ask(PTRACE_INTERRUPT)
        os.waitpid(self._id, 0x40000000)  # __WALL
        self.since_ns = time.monotonic_ns()
        return self

    def __exit__(self, *_: object) -> None:
        self._ask(PTRACE_DETACH)


def control_thread(process_id: int) -> int:
    """The thread of a drive that has real-time scheduling and the program's own name; its helpers have theirs."""
    for task in Path(f"/proc/{process_id}/task").iterdir():
        named = (task / "comm").read_text(encoding="utf-8").strip() == "sextant-ecu"
        if named and os.sched_getscheduler(int(task.name)) == os.SCHED_FIFO:
            return int(task.name)
    raise AssertionError("no control thread has real-time scheduling")
