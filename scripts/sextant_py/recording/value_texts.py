"""The names of a signal's values, by the contracts: states of the drive, causes of derating and other enumerations."""

import re
from functools import cache

from ..contract import Contract
from ..errors import UserError
from ..telemetry_contract import enumerations, enumerators, signals
from .can_frames import CAN
from .topics import TOPICS, struct_of

# How the comment of an octet names its enumeration.
_VALUE = re.compile(r"value: (\w+)( in sextant\.dbc)?")


@cache
def _of_dbc(signal: str) -> dict[int, str]:
    """Of the first message that has the signal."""
    messages = Contract().messages_of_the_drive().values()
    found = (entry.choices for message in messages for entry in message.signals if entry.name == signal)
    return {int(value): str(name) for value, name in (next(found, None) or {}).items()}


def _of_message(group: str, name: str) -> dict[int, str]:
    try:
        choices = Contract().message(group.removeprefix(f"{CAN}/")).get_signal_by_name(name).choices
    except (UserError, KeyError):  # a recording of another contract
        return {}
    return {int(value): str(text) for value, text in (choices or {}).items()}


@cache
def value_texts(group: str, name: str) -> dict[int, str]:
    """Texts by value of a signal of a group; empty where its values are numbers."""
    if group.startswith(f"{CAN}/"):
        return _of_message(group, name)
    found = next((s for s in signals(struct_of(group)) if s.name == name), None) if group in TOPICS else None
    if found is None:
        return {}
    if found.type in enumerations():
        return dict(enumerate(enumerators(found.type)))
    if named := _VALUE.search(found.text):
        return _of_dbc(named[1]) if named[2] else dict(enumerate(enumerators(named[1])))
    return {}
