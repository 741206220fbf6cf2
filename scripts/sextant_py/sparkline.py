"""The course of a value over the last seconds in one line of a terminal."""

import math
from collections import deque

LEVELS = "▁▂▃▄▅▆▇█"
STEP_S = 0.5  # of a column


class Sparkline:
    """The means over steps of STEP_S, the newest on the right; a step without samples is blank."""

    def __init__(self, columns: int = 40, span: float = 1.0) -> None:
        """span: between the lowest and the highest level at least, so that noise does not fill the line."""
        self._columns = columns
        self._span = span
        self._steps: deque[tuple[int, float, int]] = deque()  # number of the step, sum, count

    def add(self, time_s: float, value: float) -> None:
        """A sample. Where the time goes back, the course begins anew: the drive was started again."""
        if not math.isfinite(value):
            return
        step = math.floor(time_s / STEP_S)
        if self._steps and step < self._steps[-1][0]:
            self._steps.clear()
        if self._steps and step == self._steps[-1][0]:
            _, total, count = self._steps.pop()
            self._steps.append((step, total + value, count + 1))
        else:
            self._steps.append((step, value, 1))
        while self._steps[0][0] <= step - self._columns:
            self._steps.popleft()

    @property
    def count(self) -> int:
        return len(self._steps)

    def values(self, columns: int) -> list[float | None]:
        """The means of the last steps, the newest last; None where there is no sample."""
        means = {step: total / count for step, total, count in self._steps}
        newest = self._steps[-1][0] if self._steps else 0
        return [means.get(step) for step in range(newest - columns + 1, newest + 1)]

    def text(self, columns: int) -> tuple[str, float, float]:
        """The line, and its smallest and its largest value. A value that stands still is in the middle."""
        values = self.values(min(columns, self._columns))
        known = [value for value in values if value is not None]
        low, high = (min(known), max(known)) if known else (0.0, 0.0)
        middle, half = (low + high) / 2, max(high - low, self._span) / 2
        return "".join(self._level(value, middle, half) for value in values), low, high

    @staticmethod
    def _level(value: float | None, middle: float, half: float) -> str:
        if value is None:
            return " "
        share = (value - middle + half) / (2 * half)
        return LEVELS[min(int(share * len(LEVELS)), len(LEVELS) - 1)]
