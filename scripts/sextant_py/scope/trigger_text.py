"""Triggers as people write them."""

import difflib
import math

from ..errors import UserError
from ..telemetry_contract import enumerators
from . import quantities
from .conditions import Condition, Edge, Level, StateChange, TorqueStep

STATES = "DriveStateKind"
FORMS = {
    "fault": "the drive enters the state FAULT",
    "state": "the drive changes its state",
    "state NAME": f"the drive enters the state: {', '.join(enumerators(STATES))}",
    "step SIZE": "the torque reference changes by SIZE [N·m] or more within 1 ms",
    "rise SIGNAL LEVEL [HYSTERESIS]": "the signal rises through the level",
    "fall SIGNAL LEVEL [HYSTERESIS]": "the signal falls through the level",
    "edge SIGNAL LEVEL [HYSTERESIS]": "the signal passes the level",
    "above SIGNAL LEVEL": "the signal is above the level",
    "below SIGNAL LEVEL": "the signal is below the level",
}


def _refuse(text: str, why: str) -> UserError:
    return UserError(f'the trigger "{text}" {why}; a trigger is one of: {"; ".join(FORMS)}.')


def _number(text: str, word: str) -> float:
    try:
        number = float(word)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise _refuse(text, f'has "{word}" where a number is expected')
    return number


def _state(text: str, name: str) -> int:
    names = enumerators(STATES)
    if name.upper() in names:
        return names.index(name.upper())
    near = difflib.get_close_matches(name.upper(), names, 1, 0.0)[0]
    raise UserError(f'the trigger "{text}" names no state of the drive; the nearest is {near}.')


def parse(text: str) -> Condition:
    """The condition of a text such as "rise i_a_a 30". UserError: one sentence."""
    word, *rest = text.replace("=", " ").split() or [""]
    if word == "fault" and not rest:
        return StateChange(enumerators(STATES).index("FAULT"))
    if word == "state" and len(rest) < 2:
        return StateChange(_state(text, rest[0]) if rest else None)
    if word == "step" and len(rest) == 1:
        size = _number(text, rest[0])
        if not size > 0.0:
            raise _refuse(text, "has a size that is not above zero")
        return TorqueStep(size)
    if word in ("rise", "fall", "edge") and len(rest) in (2, 3):
        level, *hysteresis = (_number(text, value) for value in rest[1:])
        if hysteresis and hysteresis[0] < 0.0:
            raise _refuse(text, "has a hysteresis below zero")
        signal = quantities.check(rest[0])
        return Edge(signal, level, word != "fall", word != "rise", hysteresis[0] if hysteresis else 0.0)
    if word in ("above", "below") and len(rest) == 2:
        return Level(quantities.check(rest[0]), _number(text, rest[1]), word == "above")
    raise _refuse(text, "is not known" if word else "is empty")
