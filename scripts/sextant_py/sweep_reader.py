"""Looks values of a sweep file up and refuses them with file, line and key."""

import json
import re
from collections.abc import Mapping
from pathlib import Path, PurePath
from typing import Any

import numpy as np

from .errors import UserError
from .finite import is_finite

RANGE_KEYS = {"from", "to", "count", "scale"}
SCALES = ("linear", "log")
MAX_POINTS = 1_000_000
_TABLE = re.compile(r"^\s*\[{1,2}([^\[\]]+)\]{1,2}\s*(?:#.*)?$")
_KEY = re.compile(r"""^\s*((?:"[^"]*"|'[^']*'|[\w-]+)(?:\s*\.\s*(?:"[^"]*"|'[^']*'|[\w-]+))*)\s*=""")

Settings = dict[str, Any]


def toml_value(value: Any) -> str:
    """A value as TOML writes it, on one line."""
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str | PurePath):
        return json.dumps(str(value), ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(toml_value, value)) + "]"
    return repr(value)


def flat(tree: dict, prefix: str = "") -> Settings:
    """Dotted keys of nested tables."""
    found: Settings = {}
    for key, value in tree.items():
        if isinstance(value, dict):
            found |= flat(value, f"{prefix}{key}.")
        else:
            found[prefix + key] = value
    return found


def set_words(settings: Mapping[str, Any]) -> list[str]:
    """Keys and values as options of the programs."""
    return [word for key, value in settings.items() for word in ("--set", f"{key}={toml_value(value)}")]


def shown(value: Any) -> str:
    """A value as a sentence shows it."""
    if isinstance(value, dict) or value is None:
        return "nothing" if value is None else "a table"
    return f'"{value}"' if isinstance(value, str) else toml_value(value)


def _plain(key: str) -> str:
    return re.sub(r"""["'\s]""", "", key)


def line_of(text: str, key: str) -> int | None:
    """The line that sets a dotted key, or a table in which it lies; tomllib does not tell."""
    table, nearest = "", None
    for number, line in enumerate(text.splitlines(), 1):
        if heading := _TABLE.match(line):
            table = found = _plain(heading[1])
        elif entry := _KEY.match(line):
            found = f"{table}.{_plain(entry[1])}" if table else _plain(entry[1])
        else:
            continue
        if found == key:
            return number
        if key.startswith(found + "."):
            nearest = number
    return nearest


def refusal(file: Path, text: str, key: str, message: str, name: str | None = None) -> UserError:
    """A sentence about a key of the file, with its line; name: the key as people know it."""
    line = line_of(text, key)
    return UserError(f"{file}:{f'{line}:' if line else ''} {name or key}: {message}")


class SweepReader:
    """Looks values up and refuses them with file, line and key."""

    def __init__(self, file: Path, text: str) -> None:
        self.file, self.text = file, text

    def refuse(self, key: str, message: str) -> UserError:
        return refusal(self.file, self.text, key, message)

    def known(self, table: Settings, prefix: str, names: set[str]) -> None:
        for name in table:
            if name not in names:
                raise self.refuse(f"{prefix}{name}", f"unknown key; known here are {', '.join(sorted(names))}.")

    def table(self, tree: Settings, key: str) -> Settings:
        value = tree.get(key.rpartition(".")[2], {})
        if not isinstance(value, dict):
            raise self.refuse(key, f"expected a table, got {shown(value)}.")
        return value

    def text_at(self, tree: Settings, key: str, default: str | None = None) -> str:
        value = tree.get(key, default)
        if value is None:
            raise UserError(f"{self.file}: {key}: this key is missing; it is a text.")
        if not isinstance(value, str) or not value.strip():
            raise self.refuse(key, f"expected a text, got {shown(value)}.")
        return value

    def number(self, value: Any, key: str, what: str) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float) or not is_finite(value):
            raise self.refuse(key, f"expected {what}, got {shown(value)}.")
        return value

    def count(self, value: Any, key: str, what: str, smallest: int) -> int:
        if isinstance(value, bool) or not isinstance(value, int) or not smallest <= value <= MAX_POINTS:
            expected = f"expected {what}, a whole number from {smallest} to {MAX_POINTS}"
            raise self.refuse(key, f"{expected}, got {shown(value)}.")
        return value

    def names(self, value: Any, key: str) -> list[str]:
        if not isinstance(value, list) or not all(isinstance(name, str) for name in value):
            raise self.refuse(key, f"expected a list of names, got {shown(value)}.")
        if len(set(value)) < len(value):
            raise self.refuse(key, "a name is there twice.")
        return value

    def setting(self, value: Any, key: str) -> Any:
        """A value that sextant-mil can be given."""
        if isinstance(value, list):
            return [self.setting(item, key) for item in value]
        if isinstance(value, bool | str):
            return value
        return self.number(value, key, "a finite number, a text, true or false, or a list of them")

    def leaves(self, table: Settings, prefix: str) -> dict[str, Any]:
        """Dotted keys, written with or without quotes, to what each is given."""
        found: dict[str, Any] = {}
        for name, value in table.items():
            key = f"{prefix}.{name}"
            inside = isinstance(value, dict) and not RANGE_KEYS & value.keys()
            for path, leaf in (self.leaves(value, key) if inside else {key: value}).items():
                if path in found:
                    raise self.refuse(path, "this key is there twice, with quotes and without.")
                found[path] = leaf
        return found

    def values(self, value: list, key: str) -> list[Any]:
        if not value:
            raise self.refuse(key, "expected at least one value, got an empty list.")
        return [self.setting(item, key) for item in value]

    def choices(self, value: list, key: str) -> list[Any]:
        """Values each of which is there once."""
        values = self.values(value, key)
        if len({toml_value(item) for item in values}) < len(values):
            raise self.refuse(key, "a value is there twice.")
        return values

    def span(self, spec: Settings, key: str) -> tuple[float, float, bool]:
        """from, to and whether the scale is logarithmic."""
        scale = spec.get("scale", "linear")
        if scale not in SCALES:
            raise self.refuse(key, f'scale: expected "linear" or "log", got {shown(scale)}.')
        ends = []
        for end in ("from", "to"):
            if end not in spec:
                raise self.refuse(key, f'"{end}" is missing.')
            ends.append(self.number(spec[end], key, f'a finite number for "{end}"'))
        if not ends[0] < ends[1]:
            raise self.refuse(key, f"expected from < to, got {ends[0]} and {ends[1]}.")
        if scale == "log" and ends[0] <= 0:
            raise self.refuse(key, f'expected "from" above 0 on a log scale, got {ends[0]}.')
        return ends[0], ends[1], scale == "log"
