"""The bus and the clock of a drive in virtual time, which goes on as far as it is asked to."""

import contextlib
import subprocess
import threading
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

import can

from . import mil_program, printed_configuration
from .errors import EndedError, UserError
from .printed_configuration import ECU as PROGRAM
from .sweep_point import clean_reason

STATUSES = (0, 3)  # of a run to its end, whose drive may be in FAULT there
REFUSED = 2
LEAVE_S = 60.0  # in which the drive has shut down, real time


def identifier_offset(file: Path, words: Sequence[str]) -> int:
    """The drive's, by its configuration; a refused configuration is a UserError."""
    tree = printed_configuration.tables_of(mil_program.find(None, PROGRAM), file, words, "the drive")
    drives = tree["drive"] if isinstance(tree["drive"], list) else [tree]
    if len(drives) > 1:
        raise UserError(f"{file} has {len(drives)} drives; identifier_offset says which one is commanded.")
    return int(drives[0]["can"]["identifier_offset"])


class LockstepBus:
    """A bus and its clock in one: `sextant-ecu --virtual-time --lockstep` on the other end of two pipes. `deliver` gets
    each frame of the drive while the time passes in which it was sent."""

    def __init__(self, file: Path, words: Iterable[str]) -> None:
        self.deliver: Callable[[can.Message], None] = lambda frame: None
        self.report = ""
        self._now_ns = 0
        self._is_over = False
        self._drive = subprocess.Popen(
            [mil_program.find(None, PROGRAM), file, "--virtual-time", "--lockstep", *words],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            encoding="utf-8",
            errors="replace",
            start_new_session=True,  # Ctrl-C is for this program, which then shuts the drive down
        )

    def now_ns(self) -> int:
        return self._now_ns

    def wait_until(self, due_ns: int) -> None:
        self._put(_time(due_ns))
        while (line := self._drive.stdout.readline()).startswith("("):
            if "#" not in line:
                self._now_ns = max(due_ns, self._now_ns)
                return
            self.deliver(_frame(line))
        self._end(line)

    def send(self, frame: can.Message) -> None:
        identifier = f"{frame.arbitration_id:08X}" if frame.is_extended_id else f"{frame.arbitration_id:03X}"
        self._put(f"{_time(self._now_ns)} vcu {identifier}#{bytes(frame.data).hex().upper()}")

    def shutdown(self) -> None:
        """Shuts the drive down; `report` is what it says at its end."""
        if self._is_over:
            return
        problem = self._leave("")
        if self._drive.returncode not in STATUSES:
            raise EndedError(problem)

    def _put(self, line: str) -> None:
        if self._is_over:
            raise EndedError(f"{PROGRAM} has ended; a new vehicle control unit starts it again.")
        try:
            self._drive.stdin.write(line + "\n")
            self._drive.stdin.flush()
        except OSError:
            self._end("")

    def _end(self, line: str) -> None:
        """The drive has ended by itself; line: the first one of its report, if that was read."""
        problem = self._leave(line)
        raise UserError(problem) if self._drive.returncode == REFUSED else EndedError(problem)

    def _leave(self, line: str) -> str:
        """Waits for its end and keeps its report; how it ended, in a sentence."""
        self._is_over = True
        killer = threading.Timer(LEAVE_S, self._drive.kill)
        killer.start()
        with contextlib.suppress(OSError):
            self._drive.stdin.close()
        said, errors = self._drive.stdout.read(), self._drive.stderr.read()  # what is buffered too
        self._drive.wait()
        killer.cancel()
        lines = (line + said).splitlines(keepends=True)
        self.report = "".join(one for one in lines if not one.startswith("("))
        reason = clean_reason(errors, PROGRAM) or "it has said nothing on its standard error"
        return f"{PROGRAM} has ended with status {self._drive.returncode}: {reason}"


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
