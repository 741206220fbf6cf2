"""sextant-plant and sextant-ecu as two processes on one link."""

import ctypes
import os
import re
import signal
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from programs import ProgramProcess, overrides, program
from sextant_py.paths import LOOPBACK, ROOT

PLANT = ROOT / "configs" / "plant.toml"
DRIVE = ROOT / "configs" / "ecu_hil.toml"
# Slow enough for two processes on a machine that others share; the low link voltage keeps a period's torque small.
SLOW = ("plant.u_dc_v=200",)
PERIOD_US = 250
# So wide that a machine that stands still does not trip either side: silence is a second without a sign of life.
SILENCE_MS = 1000
WIDE_GATE = (
    *("command.timeout_ms=10000", "command.lost_ms=60000"),
    *("command.status_timeout_ms=10000", "command.status_lost_ms=60000"),
)
WATCHDOG_MS = 60000
PATIENCE_S = 60.0  # a wait ends as soon as what it waits for is there
CONTROL_THREAD = "sextant-control"


class Side(ProgramProcess):
    """One program of the two."""

    def __init__(self, name: str, config: Path, folder: Path, settings: tuple[str, ...], *words: str | Path) -> None:
        self.name = name
        super().__init__(
            [program(name), config, *overrides(settings), *words],
            folder / f"{name}.{time.monotonic_ns()}.out",
            env={**os.environ, "CYCLONEDDS_URI": LOOPBACK.read_text(encoding="utf-8")},
        )

    def __exit__(self, kind: type[BaseException] | None, *rest: object) -> None:
        super().__exit__(kind, *rest)
        if kind is not None:
            print(f"{self.name}, of a test that fails:\n{self.text()}")

    def kill(self) -> None:
        self._process.send_signal(signal.SIGKILL)
        self._process.wait()

    def stop(self) -> None:
        self._process.send_signal(signal.SIGSTOP)

    def go_on(self) -> None:
        self._process.send_signal(signal.SIGCONT)

    @property
    def process_id(self) -> int:
        return self._process.pid

    def leave(self) -> int:
        self._process.terminate()
        return self._process.wait(PATIENCE_S)

    def status(self, timeout_s: float) -> int:
        return self._process.wait(timeout_s)

    def wait_for(self, words: str, timeout_s: float = PATIENCE_S, count: int = 1) -> None:
        """Until its output holds the words so many times."""
        self.wait_until(lambda text: text.count(words) >= count, f"{words!r}", timeout_s)

    def wait_until(self, condition: Callable[[str], bool], what: str, timeout_s: float = PATIENCE_S) -> None:
        """Until its output satisfies the condition."""
        end = time.monotonic() + timeout_s
        while not condition(self.text()):
            assert self.is_running(), f"{self.name} has ended: {self.text()}"
            assert time.monotonic() < end, f"{self.name} never said {what}: {self.text()}"
            time.sleep(0.005)


def plant_side(link: str, folder: Path, *settings: str) -> Side:
    shaft = ("load.kind=imposed_speed", "load.speed_rad_s.value=5")
    wide = (f"hil.pattern_timeout_ms={SILENCE_MS}",)
    own = (f"hil.link={link}", f"period_us={PERIOD_US}", *wide, *SLOW, *shaft, *settings)
    return Side("sextant-plant", PLANT, folder, own)


def drive_side(link: str, bus: str, domain: int, folder: Path, *settings: str) -> Side:
    own = (
        f"hil.link={link}",
        f"can.bus={bus}",
        f"dds.domain={domain}",
        f"drive.period_us={PERIOD_US}",
        f"hil.pattern_timeout_ms={SILENCE_MS}",
        f"hil.measurement_timeout_ms={SILENCE_MS}",
        f"hil.missing_periods={SILENCE_MS * 1000 // PERIOD_US}",
        f"realtime.watchdog_ms={WATCHDOG_MS}",
        *WIDE_GATE,
        *SLOW,
        *settings,
    )
    return Side("sextant-ecu", DRIVE, folder, own)


class Opening(NamedTuple):
    """Gates that opened, in times of CLOCK_MONOTONIC [ns]."""

    opened_ns: int
    pattern_ns: int  # when the last pattern had come
    seen_ns: int  # when its cause was seen


def openings(plant_text: str, cause: str) -> list[Opening]:
    """Each time that driven gates turned off for that cause; a plant that has had no drive yet logs another line."""
    pattern = rf"gates stay off since ([\d.]+) s: {cause}; last pattern at ([\d.]+) s, .* seen at ([\d.]+) s"
    return [Opening(*(round(float(x) * 1e9) for x in found)) for found in re.findall(pattern, plant_text)]


def opening_after(plant: Side, cause: str, before: int) -> Opening:
    """The first opening for that cause beside those `before` it, once there is one."""
    plant.wait_until(lambda text: len(openings(text, cause)) > before, f"that the gates turn off because {cause}")
    return openings(plant.text(), cause)[before]


PTRACE_SEIZE, PTRACE_INTERRUPT, PTRACE_DETACH = 0x4206, 0x4207, 17


class HeldThread:
    """One thread of a process, held for the time of a `with` while the others run on."""

    def __init__(self, thread_id: int) -> None:
        self._id = thread_id
        self._libc = ctypes.CDLL(None, use_errno=True)

    def _ask(self, request: int) -> None:
        if self._libc.ptrace(request, self._id, None, None) != 0:
            raise OSError(ctypes.get_errno(), "ptrace")

    def __enter__(self) -> "HeldThread":
        self._ask(PTRACE_SEIZE)
        self._ask(PTRACE_INTERRUPT)
        os.waitpid(self._id, 0x40000000)  # __WALL
        return self

    def __exit__(self, *_: object) -> None:
        self._ask(PTRACE_DETACH)


def thread_named(process_id: int, name: str) -> int:
    """The thread of a process that has this name."""
    for task in Path(f"/proc/{process_id}/task").iterdir():
        if (task / "comm").read_text(encoding="utf-8").strip() == name:
            return int(task.name)
    raise AssertionError(f"no thread is called {name}")
