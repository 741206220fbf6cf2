"""What a report says of a run, whatever file it is from."""

from dataclasses import dataclass, field
from pathlib import Path

GOOD, BAD, NEUTRAL = "good", "bad", "neutral"
MOST_FAULTS = 4  # of the overview


@dataclass(frozen=True)
class Check:
    """A limit, or a test case, and whether it holds."""

    name: str
    limit: str
    value: str
    result: str  # GOOD, BAD, NEUTRAL: not evaluated
    about: str = ""  # a window, or why it does not hold


@dataclass(frozen=True)
class Fault:
    """A fault that latched."""

    name: str
    t_s: float


@dataclass(frozen=True)
class Table:
    """Rows of text under a heading; `wraps` names the columns of words, the others hold numbers."""

    title: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    words: tuple[int, ...] = (0,)
    note: str = ""


@dataclass(frozen=True)
class Picture:
    """The same picture for wide and narrow, light and dark pages, as data URIs; by (is_narrow, is_dark)."""

    title: str
    variants: dict[tuple[bool, bool], str]

    @property
    def plain(self) -> str:
        return self.variants[False, False]


@dataclass
class Run:
    """A result directory, a sweep, a recording, a JUnit file or a timing file."""

    name: str
    kind: str
    path: Path
    verdict: str = ""
    result: str = NEUTRAL
    description: str = ""
    reasons: list[str] = field(default_factory=list)
    checks: list[Check] = field(default_factory=list)
    points: str = ""  # of a sweep: how many passed
    faults: list[Fault] | None = None  # None: the file says nothing of faults
    versions: list[tuple[str, str]] = field(default_factory=list)
    facts: list[tuple[str, str]] = field(default_factory=list)
    tables: list[Table] = field(default_factory=list)
    pictures: list[Picture] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    @property
    def held(self) -> str:
        """How many of the limits hold, or how many points of a sweep passed."""
        if self.points:
            return self.points
        return f"{sum(check.result == GOOD for check in self.checks)} of {len(self.checks)}" if self.checks else "–"

    @property
    def fault_text(self) -> str:
        if self.faults is None:
            return "–"
        texts = [f"{fault.name} at {fault.t_s:.6g} s" for fault in self.faults[:MOST_FAULTS]]
        more = len(self.faults) - len(texts)
        return ", ".join(texts + ([f"{more} more"] if more else [])) or "none"


def shown(value: object) -> str:
    """A value as the tables show it."""
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, list):
        return "[" + ", ".join(map(shown, value)) + "]"
    return str(value)
