"""The list of telemetry signals: configs/interfaces/telemetry.idl, read as cmake/SextantTelemetry.cmake reads it."""

import re
from dataclasses import dataclass
from functools import cache

from .errors import UserError
from .paths import IDL

# The word for a statistic, by the part of a member's name that says it.
_STATISTICS = {
    "mean": "mean",
    "min": "minimum",
    "max": "maximum",
    "p50": "median",
    "p99": "99 % quantile",
    "p99_9": "99.9 % quantile",
    "p99_99": "99.99 % quantile",
}
_STATISTIC = re.compile(rf"(.*)_({'|'.join(_STATISTICS)})_([a-z]+)")
_MEMBER = re.compile(r"^    (@key )?([A-Za-z0-9<>, ]+) _?([a-z][a-z0-9_]*);(?: *// \[([^]]+)\] (.+))?$", re.MULTILINE)

_ENUMERATOR = re.compile(r"[A-Z][A-Z0-9_]*")


@dataclass(frozen=True)
class Signal:
    """A member of a topic."""

    name: str
    type: str  # as the contract names it
    unit: str  # "1" for a pure number
    text: str
    is_key: bool


@cache
def _contract() -> str:
    try:
        return IDL.read_text(encoding="utf-8")
    except OSError as error:
        raise UserError(f"the telemetry contract {IDL} cannot be read: {error.strerror}.") from None


def _body(pattern: str, text: str, what: str) -> str:
    found = re.search(pattern, text, re.DOTALL | re.MULTILINE)
    if found is None:
        raise UserError(f"the telemetry contract {IDL} has no {what}.")
    return found[1]


@cache
def signals(struct: str) -> tuple[Signal, ...]:
    """The members of a struct, in order. A statistic without comment has unit and text of the one before it."""
    found: list[Signal] = []
    first: dict[tuple[str, str], tuple[str, str, str]] = {}
    body = _body(rf"^  struct {struct} {{\n(.*?)\n  }};", _contract(), f"struct {struct}")
    for key, kind, name, unit, text in _MEMBER.findall(body):
        if statistic := _STATISTIC.fullmatch(name):
            word, quantity = _STATISTICS[statistic[2]], (statistic[1], statistic[3])
            first.setdefault(quantity, (word, unit, text))
            if not text:
                of_first, unit, text = first[quantity]
                text = text.replace(f"{of_first} over", f"{word} over")
        found.append(Signal(name, kind, unit, text, bool(key)))
    return tuple(found)


@cache
def rejections() -> dict[str, str]:
    """The members of RealTimeStatistics that count rejected command frames, each with its cause."""
    return {
        signal.name: signal.text.partition(": ")[2]
        for signal in signals("RealTimeStatistics")
        if signal.name.startswith("rejected_")
    }


@cache
def enumerators(enumeration: str) -> tuple[str, ...]:
    """The names of an enumeration, by value."""
    code = re.sub(r"//[^\n]*", "", _contract())
    body = _body(rf"enum {enumeration} {{([^}}]*)}}", code, f"enum {enumeration}")
    names = tuple(name.strip() for name in body.split(","))
    for name in names:
        if not _ENUMERATOR.fullmatch(name):
            raise UserError(f'{IDL}: {enumeration} has "{name}", which is not an enumerator: its form is "NAME,".')
    return names


@cache
def enumerations() -> tuple[str, ...]:
    return tuple(re.findall(r"^  enum (\w+)", _contract(), re.MULTILINE))


@cache
def structs() -> tuple[str, ...]:
    """The topics' types, in order."""
    return tuple(re.findall(r"^  struct (\w+) {", _contract(), re.MULTILINE))
