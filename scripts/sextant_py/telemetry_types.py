"""Python types of configs/interfaces/telemetry.idl, by the list of its signals."""

import re
from typing import get_args, get_origin

from cyclonedds.idl import make_idl_enum, make_idl_struct, types
from cyclonedds.idl.annotations import appendable

from .telemetry_contract import enumerations, enumerators, signals

_TYPES = {
    "unsigned long": types.uint32,
    "unsigned long long": types.uint64,
    "long": types.int32,
    "long long": types.int64,
    "float": types.float32,
    "double": types.float64,
    "octet": types.byte,
    "boolean": bool,
    "string<64>": types.bounded_str[64],
}
_ZEROS = {bool: False, types.bounded_str[64]: ""}
_SEQUENCE = re.compile(r"sequence<([a-z ]+), ([0-9]+)>")

for _name in enumerations():
    _values = {name: value for value, name in enumerate(enumerators(_name))}
    _TYPES[_name] = make_idl_enum(_name, f"sextant.{_name}", _values)
    _ZEROS[_TYPES[_name]] = _TYPES[_name](0)
DriveStateKind = _TYPES["DriveStateKind"]


def enum(name: str) -> type:
    """The enumeration as the contract has it."""
    return _TYPES[name]


def member_type(of_contract: str) -> type:
    if sequence := _SEQUENCE.fullmatch(of_contract):
        return types.sequence[_TYPES[sequence[1]], int(sequence[2])]
    return _TYPES[of_contract]


def fields(name: str) -> dict[str, type]:
    return {signal.name: member_type(signal.type) for signal in signals(name)}


def declared(name: str, members: dict[str, type]) -> type:
    """A struct of the contract's name and kind with such members."""
    return appendable(make_idl_struct(name, f"sextant.{name}", members, field_annotations={"drive_id": {"key": True}}))


def struct(name: str, without: tuple[str, ...] = ()) -> type:
    """The struct as the contract has it, or without some of its fields."""
    return declared(name, {key: kind for key, kind in fields(name).items() if key not in without})


def _zero(field: type) -> object:
    is_plain = get_origin(field) is None or not isinstance(get_args(field)[-1], types.sequence)
    return _ZEROS.get(field, 0) if is_plain else []


def sample(kind: type, **values: object) -> object:
    """A sample whose fields are zero but for the values given."""
    zeros = {name: _zero(field) for name, field in kind.__annotations__.items()}
    return kind(**{**zeros, **values})
