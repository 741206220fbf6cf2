"""The configuration of a run as differences from the defaults, which `sextant-mil --print-config` knows."""

import re
import tempfile
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .. import printed_configuration
from ..errors import UserError
from ..sweep_reader import toml_value
from .model import shown

_HEADING = re.compile(r"^\[{1,2}([\w.]+)\]{1,2}$")
_ENTRY = re.compile(r"^(# )?(\w+) =(.*)$")
_ITEM = re.compile(r"^(.+)\[(\d+)\]\.(\w+)$")
_DERIVED, _REQUIRED, _UNSET = "derived from machine and link", "required", "not set"

Configuration = dict[str, Any]  # dotted keys to values; None: not set


@dataclass(frozen=True)
class Key:
    """A key as --print-config describes it."""

    value: Any  # in force; None: not set
    default: str  # in TOML, or one of the words above
    about: str  # meaning, unit and range

    @property
    def fixed_default(self) -> Any:
        """None: not set. Of a required or derived one the word."""
        if self.default in (_DERIVED, _REQUIRED):
            return self.default
        return None if self.default == _UNSET else tomllib.loads(f"key = {self.default}")["key"]


@dataclass(frozen=True)
class Difference:
    key: str
    value: Any
    default: Any  # _REQUIRED, or the value without the key; None: not set
    is_derived: bool
    about: str

    @property
    def default_text(self) -> str:
        if self.default == _REQUIRED:
            return "–"
        text = _UNSET if self.default is None else shown(self.default)
        return f"{text} (derived)" if self.is_derived else text


def _described(table: str, line: str) -> tuple[str, Key] | None:
    """A line of a key. A string may hold what a comment begins with: the value is the shortest part that is TOML."""
    entry = _ENTRY.match(line)
    if not entry:
        return None
    unused, name, rest = entry[1], entry[2], entry[3]
    value = None
    parts = rest.split("  # ")
    for count in range(1, len(parts)):
        text, about = "  # ".join(parts[:count]), "  # ".join(parts[count:])
        try:
            value = None if unused else tomllib.loads(f"key ={text}")["key"]
        except tomllib.TOMLDecodeError:
            continue
        break
    else:
        return None
    meaning, _, default = about.rpartition("; ")
    key = f"{table}.{name}" if table else name
    return key, Key(value, default.removeprefix("default "), meaning)


def read_printed(text: str) -> dict[str, Key]:
    """The keys of what --print-config prints, without those of lists of tables."""
    table, keys, is_list = "", {}, False
    for line in text.splitlines():
        if heading := _HEADING.match(line):
            table, is_list = heading[1], line.startswith("[[")
        elif not is_list and (found := _described(table, line)):
            keys[found[0]] = found[1]
    return keys


def as_toml(configuration: Configuration) -> str:
    """A scenario with these keys; KEY[0].NAME is an item of a list of tables."""
    lines, items = [], {}
    for key, value in configuration.items():
        if value is None:
            continue
        if item := _ITEM.match(key):
            items.setdefault((item[1], int(item[2])), []).append(f"{item[3]} = {toml_value(value)}")
        else:
            lines.append(f"{key} = {toml_value(value)}")
    for (path, _), entries in sorted(items.items()):
        lines += ["", f"[[{path}]]", *entries]
    return "\n".join([*lines, ""])


def print_config(program: Path, configuration: Configuration) -> dict[str, Key]:
    """What the program says of a scenario with these keys. UserError: it refuses them."""
    with tempfile.TemporaryDirectory(prefix="sextant-report-") as directory:
        file = Path(directory) / "scenario.toml"
        file.write_text(as_toml(configuration), encoding="utf-8")
        try:
            return read_printed(printed_configuration.text_of(program, file, what="the configuration"))
        except UserError as error:
            raise UserError(str(error).replace(f"{file}:", "")) from None  # the file is of no interest


def _first_other(configuration: Configuration, printed: dict[str, Key], given: Configuration) -> str | None:
    for key, value in configuration.items():
        if key in printed and key not in given and value is not None and printed[key].value != value:
            return key
    return None


def differences(program: Path, configuration: Configuration) -> list[Difference]:
    """The keys that a scenario has to set for this configuration, in their order.

    Fixed defaults are compared. A derived default depends on machine, link and other keys: the program is asked for
    the configuration that follows from the keys found so far, and the first key in which it still differs is added,
    until none does. One that is switched off, by 0, is among them from the beginning: without it the program may refuse
    the rest. UserError: the program does not take this configuration, as one of another version may not.
    """
    machine = {key: value for key, value in configuration.items() if key.startswith("machine.")}
    known = print_config(program, {"name": "report", "duration_s": 1.0, **machine})
    defaults = {key: described.fixed_default for key, described in known.items()}
    derived = {key for key, default in defaults.items() if default == _DERIVED}
    given = {
        key: value
        for key, value in configuration.items()
        if value is not None
        and (value == 0 != known[key].value if key in derived else value != defaults.get(key, _REQUIRED))
    }
    printed = print_config(program, given)
    while key := _first_other(configuration, printed, given):
        defaults[key] = printed[key].value
        given[key] = configuration[key]
        printed = print_config(program, given)
    return [
        Difference(key, value, defaults.get(key, _REQUIRED), key in derived, known[key].about if key in known else "")
        for key, value in configuration.items()
        if key in given
    ]


def metric_texts(keys: dict[str, Key]) -> dict[str, str]:
    """Meaning and unit of each metric."""
    found = {}
    for key, described in keys.items():
        parts = key.split(".")
        if len(parts) == 3 and parts[0] == "expect":
            found[parts[1]] = described.about.rpartition("; ")[0]
    return found
