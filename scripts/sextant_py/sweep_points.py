"""A list of points of a sweep: a CSV file with a key in each column and a point in each row."""

import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .csv_heading import cells_of, lines_of, refuse_separators, refuse_twice
from .errors import UserError
from .finite import is_finite
from .sweep_reader import MAX_POINTS, Settings, toml_value

_WORDS = {"true": True, "false": False}


def _number(cell: str) -> int | float | None:
    for kind in (int, float):
        try:
            return kind(cell)
        except ValueError:
            continue
    return None


def _value(cell: str, where: str) -> Any:
    """A cell as sextant-mil takes it: a number, true or false, a list as TOML writes it, or a text."""
    if not cell:
        raise UserError(f"{where}: this cell is empty: each point needs a value of each key.")
    if cell.lower() in _WORDS:
        return _WORDS[cell.lower()]
    if (number := _number(cell)) is not None:
        if not is_finite(number):
            raise UserError(f"{where}: expected a finite number, got {cell}.")
        return number
    if cell[0] in "[\"'":
        try:
            return tomllib.loads(f"value = {cell}")["value"]
        except tomllib.TOMLDecodeError:
            raise UserError(f"{where}: expected a list or a text as TOML writes it, got {cell}.") from None
    return cell


def _check_heading(keys: list[str], where: str) -> None:
    refuse_separators(keys, where)
    for key in keys:
        refuse_twice(key, keys, where)
        if not key:
            raise UserError(f"{where}: a column has no name: name its key or leave it out.")


@dataclass(frozen=True)
class Points:
    keys: list[str]
    line: int  # of the heading
    points: list[Settings]


def load(path: Path) -> Points:
    keys: list[str] = []
    heading = 0
    points: list[Settings] = []
    known: dict[str, int] = {}
    for number, line in enumerate(lines_of(path, "the list of points"), 1):
        where, cells = f"{path}:{number}", cells_of(line)
        if not cells:
            continue
        if not keys:
            keys, heading = cells, number
            _check_heading(keys, where)
            continue
        if len(cells) != len(keys):
            raise UserError(f"{where}: expected {len(keys)} values ({', '.join(keys)}), found {len(cells)}.")
        points.append({key: _value(cell, f"{where}: {key}") for key, cell in zip(keys, cells, strict=True)})
        before = known.setdefault(toml_value(list(points[-1].values())), number)
        if before != number:
            raise UserError(f"{where}: the same point as in line {before}: leave one out.")
        if len(points) > MAX_POINTS:
            raise UserError(f"{where}: more than {MAX_POINTS} points.")
    if not points:
        raise UserError(f"the list of points {path} has no point: expected a heading of keys and a row for each point.")
    return Points(keys, heading, points)
