"""Python types of configs/interfaces/telemetry.idl, read from the file itself."""

import re

from cyclonedds.idl import make_idl_enum, make_idl_struct, types
from cyclonedds.idl.annotations import final

from .paths import IDL

_TEXT = re.sub(r"//.*", "", IDL.read_text())
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


def _body(kind: str, name: str) -> str:
    return re.search(rf"{kind}\s+{name}\s*{{(.*?)}}", _TEXT, re.DOTALL).group(1)


for _name in re.findall(r"enum\s+(\w+)", _TEXT):
    _values = {name.strip(): value for value, name in enumerate(_body("enum", _name).split(","))}
    _TYPES[_name] = make_idl_enum(_name, f"sextant.{_name}", _values)
    _ZEROS[_TYPES[_name]] = _TYPES[_name](0)
DriveStateKind = _TYPES["DriveStateKind"]


def enum(name: str) -> type:
    """The enumeration as the contract has it."""
    return _TYPES[name]


def fields(name: str) -> dict[str, type]:
    declarations = [line.replace("@key", "").split() for line in _body("struct", name).split(";")]
    return {words[-1].removeprefix("_"): _TYPES[" ".join(words[:-1])] for words in declarations if words}


def struct(name: str, without: tuple[str, ...] = ()) -> type:
    """The struct as the contract has it, or without some of its fields."""
    members = {key: kind for key, kind in fields(name).items() if key not in without}
    return final(make_idl_struct(name, f"sextant.{name}", members, field_annotations={"drive_id": {"key": True}}))


def sample(kind: type, **values: object) -> object:
    """A sample whose fields are zero but for the values given."""
    zeros = {name: _ZEROS.get(field, 0) for name, field in kind.__annotations__.items()}
    return kind(**{**zeros, **values})
