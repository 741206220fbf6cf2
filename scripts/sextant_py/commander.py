"""Commands to a drive on an absolute schedule."""

import threading
import time
from typing import Protocol

import can

from . import e2e
from .contract import Contract
from .wrong_frames import COMMAND, WRONG, Wrong


class Bus(Protocol):
    """What takes the frames."""

    def send(self, frame: can.Message) -> None: ...


class Clock:
    """The machine's monotonic clock."""

    def now_ns(self) -> int:
        return time.monotonic_ns()

    def wait_until(self, due_ns: int) -> None:
        time.sleep(max(due_ns - time.monotonic_ns(), 0) / 1e9)


class Commander:
    """Sends commands on an absolute schedule and, unless told otherwise, remembers them. Frames of several threads have
    their counters in the order in which the bus gets them."""

    def __init__(
        self,
        bus: Bus,
        contract: Contract,
        period_s: float,
        torque_limit_nm: float,
        keeps_log: bool = True,
        clock: Clock | None = None,
    ) -> None:
        self._bus = bus
        self._contract = contract
        self._clock = clock or Clock()
        self.period_s = period_s
        self._period_ns = round(period_s * 1e9)
        self._torque_limit_nm = torque_limit_nm
        self._keeps_log = keeps_log
        self._lock = threading.Lock()  # counter and wrong frames
        self._counter = 0
        self._next_ns = self._clock.now_ns()
        self._wrong: tuple[Wrong, int] | None = None  # and for how many frames more
        self.frames = 0  # that the bus has taken
        self.sent: list[tuple[int, float, bool, int]] = []
        self.missed = 0
        self.unsent = 0

    def wait(self) -> int:
        """Sleeps until the next frame is due and returns when that was [ns]; whole periods missed are skipped."""
        self._next_ns += self._period_ns
        late_ns = self._clock.now_ns() - self._next_ns
        if late_ns > self._period_ns:
            missed = late_ns // self._period_ns
            self.missed += missed
            self._next_ns += missed * self._period_ns
        self._clock.wait_until(self._next_ns)
        return self._next_ns

    def spoil(self, kind: str, frames: int = 1) -> None:
        """The next frames, one or more, are wrong, by a kind of WRONG."""
        with self._lock:
            self._wrong = WRONG[kind], frames

    def spoil_none(self) -> None:
        """The next frames are right."""
        with self._lock:
            self._wrong = None

    def send(self, torque_nm: float, enable: bool, fault_reset: bool = False) -> None:
        signals = {"TorqueRequest": torque_nm, "TorqueLimit": self._torque_limit_nm}
        signals |= {"Enable": int(enable), "FaultReset": int(fault_reset)}
        with self._lock:
            wrong = self._next_wrong()
            counter = (self._counter + (wrong.skip if wrong else 0)) % e2e.COUNTER_COUNT
            frame = self._contract.encode(COMMAND, signals, counter)
            if wrong:
                frame = wrong.frame(self._contract, frame, counter)
            if frame is not None:
                self._put(frame, (torque_nm, enable, counter))
            self._counter = (counter + (wrong.advance if wrong else 1)) % e2e.COUNTER_COUNT

    def _next_wrong(self) -> Wrong | None:
        if self._wrong is None:
            return None
        wrong, frames = self._wrong
        self._wrong = (wrong, frames - 1) if frames > 1 else None
        return wrong

    def _put(self, frame: can.Message, sent: tuple[float, bool, int]) -> None:
        try:
            self._bus.send(frame)
        except (can.CanError, OSError):
            self.unsent += 1
            return
        self.frames += 1
        if self._keeps_log:
            self.sent.append((self._clock.now_ns(), *sent))
