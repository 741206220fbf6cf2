"""A figure, its target and its verdict."""

import math
import sys
import traceback
from dataclasses import dataclass, field, replace

from sextant_py.errors import UserError

MET, MISSED, NOT_MEASURED, PUBLISHED = "met", "missed", "not measured", "published"


class NotMeasurableError(UserError):
    """Something cannot be measured on this machine, or not in this time. Nothing is known to be wrong."""


@dataclass(frozen=True)
class Figure:
    """A row of a stage's table, and with a value what was measured. Without a limit it has no target."""

    measure: str
    unit: str = ""
    at_most: float | None = None
    at_least: float | None = None
    value: float | None = None  # None: not measured; NaN: it failed; `note` says why
    note: str = ""  # what the reader has to know beside the number, a few words

    verdict: str = field(default="", compare=False)  # made of the others

    def __post_init__(self) -> None:
        object.__setattr__(self, "verdict", self._verdict())

    def _verdict(self) -> str:
        if self.value is None:
            return NOT_MEASURED
        if self.at_most is None and self.at_least is None and not math.isnan(self.value):
            return PUBLISHED
        # Written so that a NaN misses.
        low = self.value >= (-math.inf if self.at_least is None else self.at_least)
        high = self.value <= (math.inf if self.at_most is None else self.at_most)
        return MET if low and high else MISSED

    @property
    def target(self) -> str:
        limits = (("≥", self.at_least), ("≤", self.at_most))
        return " and ".join(f"{sign} {self.text(limit)}" for sign, limit in limits if limit is not None)

    @property
    def shown(self) -> str:
        return "–" if self.value is None or math.isnan(self.value) else self.text(self.value)

    def text(self, value: float) -> str:
        return f"{number(value)} {self.unit}".strip()

    def of(self, value: float, note: str = "") -> "Figure":
        return replace(self, value=value, note=note)

    def failed(self, error: Exception | str) -> "Figure":
        """Not measured where it cannot be had here; anything else that went wrong is a miss."""
        note = str(error)
        if not isinstance(error, UserError | str):  # one that nobody expected
            traceback.print_exception(error, file=sys.stderr)
            note = " ".join(f"{type(error).__name__}: {error}".split())
        return replace(self, value=None if isinstance(error, NotMeasurableError) else math.nan, note=note)


def number(value: float) -> str:
    """Three digits that count; no exponent where people would not write one."""
    if value == 0 or not math.isfinite(value):
        return f"{value:g}"
    if 1e-3 <= abs(value) < 1000:
        return f"{value:.3g}"
    if 1000 <= abs(value) < 1e6:
        return f"{value:,.0f}".replace(",", " ")
    digits, exponent = f"{value:.2e}".split("e")
    return f"{digits.rstrip('0').rstrip('.')}e{int(exponent)}"


def spread(values: list[float]) -> str:
    return f"{min(values):.3g} to {max(values):.3g} in {len(values)} rounds"
