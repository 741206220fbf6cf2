"""The list of telemetry signals: configs/interfaces/telemetry.json, which `sextant-telemetry --describe` writes."""

import json
from dataclasses import dataclass
from functools import cache
from typing import Any

from .errors import UserError
from .paths import TELEMETRY


@dataclass(frozen=True)
class Signal:
    """A member of a topic."""

    name: str
    type: str  # as configs/interfaces/telemetry.idl names it
    unit: str  # "1" for a pure number
    text: str
    is_key: bool


@cache
def _contract() -> dict[str, Any]:
    try:
        return json.loads(TELEMETRY.read_text(encoding="utf-8"))
    except OSError as error:
        raise UserError(f"the telemetry contract {TELEMETRY} cannot be read: {error.strerror}.") from None
    except ValueError as error:
        raise UserError(f"the telemetry contract {TELEMETRY} is no JSON: {error}.") from None


def _part(kind: str, name: str, what: str) -> list:
    found = _contract()[kind].get(name)
    if found is None:
        raise UserError(f"the telemetry contract {TELEMETRY} has no {what} {name}.")
    return found


@cache
def signals(struct: str) -> tuple[Signal, ...]:
    """The members of a topic's type, in order."""
    return tuple(
        Signal(one["name"], one["type"], one["unit"], one["text"], one.get("key", False))
        for one in _part("topics", struct, "struct")
    )


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
    return tuple(_part("enumerations", enumeration, "enumeration"))


@cache
def enumerations() -> tuple[str, ...]:
    return tuple(_contract()["enumerations"])


@cache
def structs() -> tuple[str, ...]:
    """The topics' types, in order."""
    return tuple(_contract()["topics"])
