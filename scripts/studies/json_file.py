"""Result files in JSON with a record or an array a line, so that two of them can be compared line by line."""

import json
from dataclasses import is_dataclass
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, get_args, get_origin, get_type_hints

from sextant_py.errors import UserError

Content = TypeVar("Content")
_types_of = cache(get_type_hints)


def text(value: Any, levels: int = 2) -> str:
    """The members of the outer `levels` levels have lines of their own. What lies deeper is one line, and so is an
    object or array that holds no other. A dataclass is an object, and keys are words or numbers."""
    return _text(json.loads(json.dumps(value, default=vars)), levels) + "\n"


def _text(value: Any, levels: int) -> str:
    members = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    if levels == 0 or not any(isinstance(member, dict | list) for member in members):
        return json.dumps(value, ensure_ascii=False)
    lines = [_text(member, levels - 1) for member in members]
    if isinstance(value, dict):
        lines = [f"{json.dumps(key, ensure_ascii=False)}: {line}" for key, line in zip(value, lines, strict=True)]
    begin, end = "{}" if isinstance(value, dict) else "[]"
    return begin + "\n" + ",\n".join(lines) + "\n" + end


def write(file: Path, value: Any, levels: int = 2) -> None:
    """With its directory. UserError: it cannot be written."""
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text(value, levels), encoding="utf-8")
    except OSError as error:
        raise UserError(f"{file} cannot be written: {error.strerror}.") from None


def read(file: Path, kind: type[Content], program: str) -> Content:
    """What a program of scripts has written: a dataclass, or tables and lists of them. UserError: it is not there."""
    try:
        return _made(kind, json.loads(file.read_text(encoding="utf-8")))
    except FileNotFoundError:
        raise UserError(f"{file} is missing; scripts/{program} writes it.") from None
    except OSError as error:
        raise UserError(f"{file} cannot be read: {error.strerror}.") from None
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise UserError(f"{file} holds no results of scripts/{program}: {type(error).__name__}: {error}.") from None


def _made(kind: Any, value: Any) -> Any:
    """A value of JSON as that type; what is neither a dataclass nor a list or table of known members stays as it is."""
    if is_dataclass(kind):
        return kind(**{key: _made(_types_of(kind)[key], member) for key, member in value.items()})
    if get_origin(kind) is list:
        return [_made(*get_args(kind), member) for member in value]
    if get_origin(kind) is dict:
        return {key: _made(get_args(kind)[1], member) for key, member in value.items()}
    return value
