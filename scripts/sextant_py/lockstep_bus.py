"""The bus and the clock of a drive in virtual time, which goes on as far as it is asked to."""

import subprocess
from collections.abc import Callable, Iterable
from pathlib import Path

import can

from . import mil_program
from .errors import EndedError
from .sweep_point import clean_reason

PROGRAM = "sextant-ecu"
LEAVE_S = 60.0  # in which the drive has shut down, real time


class LockstepBus:
    """A bus and its clock in one: `sextant-ecu --virtual-time --lockstep` on the other end of two pipes. `deliver` gets
    each frame of the drive while the time passes in which it was sent."""

    def __init__(self, file: Path, words: Iterable[str]) -> None:
        self.deliver: Callable[[can.Message], None] = lambda frame: None
        self.report = ""
        self._now_ns = 0
        self._drive = subprocess.Popen(
            [mil_program.find(None, PROGRAM), file, "--virtual-time", "--lockstep", *words],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            encoding="utf-8",
            errors="replace",
        )

    def now_ns(self) -> int:
        return self._now_ns

    def wait_until(self, due_ns: int) -> None:
        self._put(_time(due_ns))
        while (line := self._drive.stdout.readline()).count(" ") == 2:
            self.deliver(_frame(line))
        if not line:
            self._refuse()
        self._now_ns = max(due_ns, self._now_ns)

    def send(self, frame: can.Message) -> None:
        identifier = f"{frame.arbitration_id:08X}" if frame.is_extended_id else f"{frame.arbitration_id:03X}"
        self._put(f"{_time(self._now_ns)} vcu {identifier}#{bytes(frame.data).hex().upper()}")

    def shutdown(self) -> None:
        """Shuts the drive down; `report` is what it says at its end."""
        said, _ = self._leave()
        self.report = "".join(line for line in said.splitlines(True) if not line.startswith("("))

    def _put(self, line: str) -> None:
        try:
            self._drive.stdin.write(line + "\n")
            self._drive.stdin.flush()
        except OSError:
            self._refuse()

    def _leave(self) -> tuple[str, str]:
        """What is left of its output, and its errors."""
        try:
            return self._drive.communicate(timeout=LEAVE_S)
        except subprocess.TimeoutExpired:
            self._drive.kill()
            raise EndedError(f"{PROGRAM} did not shut down within {LEAVE_S:g} s.") from None

    def _refuse(self) -> None:
        _, errors = self._leave()
        said = clean_reason(errors, PROGRAM) or "it says nothing"
        raise EndedError(f"{PROGRAM} has ended with status {self._drive.returncode}: {said}")


def _time(t_ns: int) -> str:
    return f"({t_ns // 10**9}.{t_ns % 10**9:09})"


def _frame(line: str) -> can.Message:
    """Of a line as `candump -l` writes it; the drive sends classic frames of 11 bits."""
    time, _, text = line.split()
    identifier, _, data = text.partition("#")
    return can.Message(
        timestamp=float(time.strip("()")),
        arbitration_id=int(identifier, 16),
        is_extended_id=False,
        data=bytes.fromhex(data),
    )
