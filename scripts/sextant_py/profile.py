"""Torque profiles: what a vehicle asks of the drive, over time.

A CSV file has a heading `time_s,torque_nm` or `time_s,torque_nm,enable`, one point a line, separated by commas; cells
may stand in quotes; empty lines and what follows a # are passed over. `sextant-ecu --virtual-time` reads the same,
but for enable.
Torque is interpolated linearly; two points at one time make a step. A TOML file has the same:

    interpolation = "hold"          # or "linear"
    time_s = [0.0, 1.0, 5.0]
    torque_nm = [0.0, 15.0, 0.0]
    enable = [true, true, false]    # may be left out
"""

import bisect
import math
import tomllib
from dataclasses import dataclass
from pathlib import Path

from .csv_heading import cells_of, lines_of, refuse_separators, refuse_twice
from .errors import UserError

INTERPOLATIONS = ("linear", "hold")
_COLUMNS = ("time_s", "torque_nm", "enable")
_TRUTH = {"1": True, "true": True, "0": False, "false": False}


@dataclass(frozen=True)
class Point:
    """Torque [N·m] and enable from time_s [s] on."""

    time_s: float
    torque_nm: float
    enable: bool = True


class Profile:
    def __init__(self, points: list[Point], interpolation: str = "linear") -> None:
        self.points = points
        self.interpolation = interpolation
        self._times = [point.time_s for point in points]

    @property
    def duration_s(self) -> float:
        return self._times[-1]

    def at(self, time_s: float) -> tuple[float, bool]:
        """Torque [N·m] and enable at a time [s]; at a step, what comes after it."""
        index = max(bisect.bisect_right(self._times, time_s) - 1, 0)
        here = self.points[index]
        if self.interpolation == "hold" or index + 1 == len(self.points) or time_s <= here.time_s:
            return here.torque_nm, here.enable
        after = self.points[index + 1]
        share = (time_s - here.time_s) / (after.time_s - here.time_s)
        return here.torque_nm + share * (after.torque_nm - here.torque_nm), here.enable


Rows = list[tuple[str, Point]]  # with where a point stands in the file


def load(path: Path | str, interpolation: str | None = None) -> Profile:
    """Reads a profile; a bad one is refused with file and line."""
    path = Path(path)
    lines = lines_of(path, "the profile")
    suffix = path.suffix.lower()
    if suffix not in (".csv", ".toml"):
        raise UserError(f"the profile {path} must be a .csv or .toml file.")
    rows, own = _from_toml(path, lines) if suffix == ".toml" else (_from_csv(path, lines), "linear")
    points: list[Point] = []
    for where, point in rows:
        if not points and point.time_s != 0:
            raise UserError(f"{where}: the first point must be at time_s = 0, not {point.time_s:g}.")
        if points and point.time_s < points[-1].time_s:
            raise UserError(f"{where}: time_s goes back from {points[-1].time_s:g} to {point.time_s:g}.")
        points.append(point)
    if len(points) < 2:
        raise UserError(f"the profile {path} needs at least two points.")
    if points[-1].time_s == 0:
        raise UserError(f"{rows[-1][0]}: time_s stands still at 0 in every point.")
    return Profile(points, interpolation or own)


def _number(text: object, where: str, name: str) -> float:
    try:
        value = float(text) if not isinstance(text, bool) else math.nan
    except (TypeError, ValueError, OverflowError):
        value = math.nan
    if not math.isfinite(value):
        raise UserError(f'{where}: {name} must be a finite number, not "{text}".')
    return value


def _check_heading(columns: list[str], where: str) -> None:
    refuse_separators(columns, where)
    if len(columns) > 1 and not columns[0]:
        raise UserError(f"{where}: the first column has no name: name it or leave it out.")
    for column in columns:
        refuse_twice(column, columns, where)
        if column not in _COLUMNS:
            raise UserError(
                f"{where}: unknown column {column}; the heading has time_s, torque_nm and, where needed, enable."
            )
    for column in _COLUMNS[:2]:
        if column not in columns:
            raise UserError(f"{where}: the heading has no column {column}.")


def _from_csv(path: Path, lines: list[str]) -> Rows:
    columns: list[str] = []
    rows: Rows = []
    for number, line in enumerate(lines, start=1):
        where = f"{path}:{number}"
        cells = cells_of(line)
        if not cells:
            continue
        if not columns:
            columns = cells
            _check_heading(columns, where)
            continue
        if len(cells) != len(columns):
            raise UserError(f"{where}: expected {len(columns)} values ({','.join(columns)}), found {len(cells)}.")
        row = dict(zip(columns, cells, strict=True))
        enable = _TRUTH.get(row.get("enable", "1").lower())
        if enable is None:
            raise UserError(f'{where}: enable must be 0 or 1, not "{row["enable"]}".')
        time_s, torque_nm = (_number(row[name], where, name) for name in _COLUMNS[:2])
        rows.append((where, Point(time_s, torque_nm, enable)))
    return rows


def _from_toml(path: Path, lines: list[str]) -> tuple[Rows, str]:
    try:
        table = tomllib.loads("\n".join(lines))
    except tomllib.TOMLDecodeError as error:
        raise UserError(f"the profile {path} is not TOML: {error}.") from None

    def line_of(key: str) -> str:
        numbered = enumerate(lines, 1)
        return f"{path}:{next((n for n, line in numbered if line.split('=')[0].strip() == key), 1)}"

    def refuse(key: str, message: str) -> UserError:
        return UserError(f"{line_of(key)}: {message}")

    for key in table:
        if key not in ("interpolation", "time_s", "torque_nm", "enable"):
            raise refuse(key, f'unknown key "{key}"; known are interpolation, time_s, torque_nm, enable.')
    interpolation = table.get("interpolation", "linear")
    if interpolation not in INTERPOLATIONS:
        raise refuse("interpolation", f'interpolation must be "linear" or "hold", not "{interpolation}".')
    columns = [table.get("time_s"), table.get("torque_nm")]
    for key, column in zip(("time_s", "torque_nm"), columns, strict=True):
        if not isinstance(column, list):
            raise refuse(key, f"{key} must be a list of numbers.")
    columns.append(table.get("enable", [True] * len(columns[0])))
    if not isinstance(columns[2], list) or not all(isinstance(value, bool) for value in columns[2]):
        raise refuse("enable", "enable must be a list of true and false.")
    if len({len(column) for column in columns}) != 1:
        raise refuse("time_s", "time_s, torque_nm and enable must have one length.")
    for key, column in zip(("time_s", "torque_nm"), columns, strict=False):
        column[:] = [_number(value, line_of(key), key) for value in column]
    return [(line_of("time_s"), Point(*row)) for row in zip(*columns, strict=True)], interpolation
