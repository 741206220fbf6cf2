"""Triggered capture: the rows before and after the instant at which a condition is fulfilled."""

from collections import deque
from dataclasses import dataclass

import numpy as np

from ..errors import UserError
from .capture import Capture
from .trigger_text import parse

MODES = ("auto", "normal", "single")
MOST_S = 60.0  # of a capture: 2.4 million control periods of 25 µs


@dataclass(frozen=True)
class Settings:
    """As on an oscilloscope. Times in seconds."""

    trigger: str = "fault"
    mode: str = "normal"  # auto: also without the trigger, after auto_s; single: one capture, until armed again
    before_s: float = 0.02
    after_s: float = 0.05
    hold_off_s: float = 0.0  # from one trigger to the next at least
    auto_s: float = 0.5

    def check(self) -> None:
        """UserError: one sentence."""
        if self.mode not in MODES:
            raise UserError(f'the mode "{self.mode}" of the scope is none of {", ".join(MODES)}.')
        for what, value in (("before", self.before_s), ("after", self.after_s), ("hold-off", self.hold_off_s)):
            if not 0.0 <= value <= MOST_S:
                raise UserError(f"the scope's time {what} the trigger must be from 0 to {MOST_S:g} s, not {value:g} s.")
        if not 0.0 < self.auto_s < float("inf"):
            raise UserError(f"the scope's time of mode auto must be above 0 s, not {self.auto_s:g} s.")
        if self.before_s + self.after_s <= 0.0:
            raise UserError(
                "the scope's times before and after the trigger are both zero: there is nothing to capture."
            )
        parse(self.trigger)


class Scope:
    """Takes the rows of the waveform in their order and gives captures."""

    def __init__(self, settings: Settings) -> None:
        settings.check()
        self.settings = settings
        self.captures = 0
        self._blocks: deque[np.ndarray] = deque()
        self.arm()

    def arm(self) -> None:
        """Waits for the trigger, from the next rows on."""
        self._condition = parse(self.settings.trigger)
        self._trigger_ns: int | None = None
        self._reason = self.settings.trigger
        self._ready_ns: int | None = None  # no trigger before; None: from the next row on
        self._stopped = False

    @property
    def state(self) -> str:
        """ "stopped", "triggered" (its rows are still coming) or "waiting"."""
        if self._stopped:
            return "stopped"
        return "waiting" if self._trigger_ns is None else "triggered"

    def take(self, rows: np.ndarray) -> list[Capture]:
        """The captures that these rows complete."""
        if not len(rows):
            return []
        times = rows["t_ns"].astype(np.int64)
        if self._blocks and times[0] < int(self._blocks[-1]["t_ns"][-1]):
            self._restart()  # a drive that has started again on a machine with another clock
        self._blocks.append(rows)
        fulfilled = times[self._condition.hits(rows)]
        if self._ready_ns is None:
            self._ready_ns = int(times[0])
        complete = []
        while not self._stopped and (capture := self._next(fulfilled, int(times[-1]))):
            if len(capture.rows):  # none where mode auto falls in a gap of the waveform
                complete.append(capture)
        self.captures += len(complete)
        self._forget(int(times[-1]))
        return complete

    def _restart(self) -> None:
        self._blocks.clear()
        self.arm()

    def _next(self, fulfilled: np.ndarray, newest_ns: int) -> Capture | None:
        if self._trigger_ns is None:
            self._find_trigger(fulfilled, newest_ns)
        after_ns = round(self.settings.after_s * 1e9)
        if self._trigger_ns is None or newest_ns < self._trigger_ns + after_ns:
            return None
        capture = self._cut(self._trigger_ns, after_ns)
        hold_off_ns = round(self.settings.hold_off_s * 1e9)
        self._ready_ns = self._trigger_ns + max(after_ns, hold_off_ns) + 1
        self._trigger_ns = None
        self._stopped = self.settings.mode == "single"
        return capture

    def _find_trigger(self, fulfilled: np.ndarray, newest_ns: int) -> None:
        found = fulfilled[fulfilled >= self._ready_ns]
        auto_ns = self._ready_ns + round((self.settings.auto_s + self.settings.before_s) * 1e9)
        if len(found):
            self._trigger_ns, self._reason = int(found[0]), self.settings.trigger
        elif self.settings.mode == "auto" and newest_ns >= auto_ns:
            self._trigger_ns, self._reason = auto_ns, f"auto: no {self.settings.trigger}"

    def _cut(self, trigger_ns: int, after_ns: int) -> Capture:
        rows = np.concatenate(self._blocks)
        times = rows["t_ns"].astype(np.int64)
        begin_ns = trigger_ns - round(self.settings.before_s * 1e9)
        kept = (times >= begin_ns) & (times <= trigger_ns + after_ns)
        return Capture(rows[kept], trigger_ns, self._reason)

    def _forget(self, newest_ns: int) -> None:
        """Drops the blocks that no capture can need."""
        earliest_ns = newest_ns if self._trigger_ns is None else self._trigger_ns
        earliest_ns -= round(self.settings.before_s * 1e9)
        while len(self._blocks) > 1 and int(self._blocks[0]["t_ns"][-1]) < earliest_ns:
            self._blocks.popleft()
