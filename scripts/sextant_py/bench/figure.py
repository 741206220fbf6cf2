"""A measured figure, its target and its verdict."""

import math
import sys
import traceback
from dataclasses import asdict, dataclass

from sextant_py.errors import UserError

OK, MISSED, PUBLISHED, NOT_JUDGED = "ok", "MISSED", "published", "NOT JUDGED"


class NotMeasurableError(UserError):
    """Something cannot be measured on this machine, or not in this time. Nothing is known to be wrong."""


@dataclass(frozen=True)
class Figure:
    """What was measured. With neither limit it is published and not judged."""

    measure: str
    value: float | None  # None: it could not be measured; `note` says why
    unit: str = ""
    at_most: float | None = None
    at_least: float | None = None
    command: str = ""
    note: str = ""  # what the reader has to know beside the number, a few words
    text: str = ""  # the figure as printed, where a number alone would say too little
    wanted: str = ""  # the target in words, where its number alone would say too little
    broken: bool = False  # there is no value because something failed; that is a miss
    accepted_at_most: float | None = None  # a miss that is known, up to here
    accepted_because: str = ""

    @property
    def verdict(self) -> str:
        if self.value is None:
            return MISSED if self.broken else NOT_JUDGED
        if self.at_most is None and self.at_least is None:
            return PUBLISHED
        # Written so that a NaN misses.
        low = self.at_least is None or self.value >= self.at_least
        high = self.at_most is None or self.value <= self.at_most
        return OK if low and high else MISSED

    @property
    def is_accepted_miss(self) -> bool:
        """Whether it misses its target no further than is known and accepted."""
        if self.verdict != MISSED or self.value is None or self.accepted_at_most is None:
            return False
        return self.value <= self.accepted_at_most and (self.at_least is None or self.value >= self.at_least)

    @property
    def acceptance(self) -> str:
        """In words; empty where no miss is accepted."""
        if self.verdict != MISSED or self.accepted_at_most is None:
            return ""
        limit = f"{number(self.accepted_at_most)} {self.unit}".strip()
        if self.is_accepted_miss:
            return f"accepted up to {limit}: {self.accepted_because}"
        return f"beyond what is accepted, {limit}"

    @property
    def target(self) -> str:
        if self.wanted:
            return self.wanted
        limits = (("≥", self.at_least), ("≤", self.at_most))
        return " and ".join(
            f"{sign} {number(limit)} {self.unit}".strip() for sign, limit in limits if limit is not None
        )

    @property
    def shown(self) -> str:
        if self.text:
            return self.text
        return "–" if self.value is None else f"{number(self.value)} {self.unit}".strip()

    def to_json(self) -> dict:
        return asdict(self) | {"verdict": self.verdict}

    @staticmethod
    def from_json(data: dict) -> "Figure":
        return Figure(**{key: value for key, value in data.items() if key != "verdict"})


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


def unmeasured(measure: str, why: str, **options) -> Figure:
    return Figure(measure, None, **(options | {"note": why}))


def failed(measure: str, error: Exception | str, **options) -> Figure:
    """A figure that is missing because something failed. It misses, unless it cannot be had here."""
    return unmeasured(measure, sentence(error), **options, broken=not isinstance(error, NotMeasurableError))


def sentence(error: Exception | str) -> str:
    """What went wrong, in a line. An error that nobody expected is named by its kind."""
    if isinstance(error, UserError | str):
        return str(error)
    return " ".join(f"{type(error).__name__}: {error}".split())


def report_unexpected(error: Exception) -> None:
    """Where an error came from, for whoever mends it; a UserError says all by itself."""
    if not isinstance(error, UserError):
        traceback.print_exception(error, file=sys.stderr)
