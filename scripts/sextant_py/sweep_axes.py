"""Axes of a sweep: a key, or several keys that move together, over lists of values or ranges."""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from .sweep_reader import RANGE_KEYS, Settings, SweepReader, shown, toml_value

COUPLED = "coupled"


@dataclass(frozen=True)
class Range:
    low: float
    high: float
    log: bool

    def at(self, share: float) -> float:
        """The ends are exact at shares 0 and 1."""
        if share in (0.0, 1.0):
            return float(self.high if share else self.low)
        if self.log:
            return math.exp(math.log(self.low) + share * (math.log(self.high) - math.log(self.low)))
        return self.low + share * (self.high - self.low)


@dataclass(frozen=True)
class Axis:
    """One share of the axis gives each of its keys a value. Lists of values are of one length."""

    columns: dict[str, list | Range]
    log_keys: frozenset[str]

    def rows(self) -> list[Settings]:
        """The settings of an axis of lists alone."""
        return [dict(zip(self.columns, row, strict=True)) for row in zip(*self.columns.values(), strict=True)]

    def __len__(self) -> int:
        return len(next(iter(self.columns.values())))

    def at(self, share: float) -> Settings:
        """share: from 0 to below 1."""
        return {
            key: column.at(share) if isinstance(column, Range) else column[int(share * len(column))]
            for key, column in self.columns.items()
        }


def keys_of(axes: Iterable[Axis]) -> list[str]:
    return [key for axis in axes for key in axis.columns]


class AxesReader:
    """Reads axes of a grid, whose ranges have a count of values, or of a sample, whose ranges have none."""

    def __init__(self, read: SweepReader, is_grid: bool) -> None:
        self._read = read
        self._keys = RANGE_KEYS if is_grid else RANGE_KEYS - {"count"}

    def _column(self, spec: Any, path: str, is_alone: bool) -> tuple[list | Range, bool]:
        """The values or the range of a key, and whether its scale is logarithmic."""
        read = self._read
        if isinstance(spec, list):
            return (read.choices if is_alone else read.values)(spec, path), False
        if not isinstance(spec, dict):
            known = ", ".join(key for key in ("from", "to", "count", "scale") if key in self._keys)
            raise read.refuse(path, f"expected a list of values or {{ {known} }}, got {shown(spec)}.")
        read.known(spec, f"{path}.", self._keys)
        span = Range(*read.span(spec, path))
        if "count" not in self._keys:
            return span, span.log
        count = read.count(spec.get("count"), path, '"count"', 2)
        return [span.at(k / (count - 1)) for k in range(count)], span.log

    def _axis(self, specs: dict[str, Any], where: str) -> Axis:
        columns, log_keys = {}, set()
        for path, spec in specs.items():
            key = path.removeprefix(f"{where}.")
            columns[key], is_log = self._column(spec, path, len(specs) == 1)
            if is_log:
                log_keys.add(key)
        return Axis(columns, frozenset(log_keys))

    def single(self, table: Settings, where: str) -> Iterator[Axis]:
        """An axis for each key of a table."""
        for path, spec in self._read.leaves(table, where).items():
            yield self._axis({path: spec}, where)

    def coupled(self, tree: Settings) -> Iterator[Axis]:
        """An axis for each [[coupled]]."""
        read, tables = self._read, tree.get(COUPLED, [])
        tables = [tables] if isinstance(tables, dict) else tables
        if not isinstance(tables, list) or not all(isinstance(table, dict) for table in tables):
            raise read.refuse(COUPLED, "expected [[coupled]] with a list of values or a range for each key.")
        for table in tables:
            specs = read.leaves(table, COUPLED)
            if len(specs) < 2:
                where = next(iter(specs), COUPLED)
                raise read.refuse(where, f"expected two or more keys that move together, got {len(specs)}.")
            axis = self._axis(specs, COUPLED)
            self._check_rows(axis)
            yield axis

    def _check_rows(self, axis: Axis) -> None:
        lists = {key: column for key, column in axis.columns.items() if isinstance(column, list)}
        first = next(iter(lists), "")
        for key, column in lists.items():
            if len(column) != len(lists[first]):
                expected = f"expected as many values as {first} has, {len(lists[first])}, got {len(column)}"
                raise self._read.refuse(f"{COUPLED}.{key}", f"{expected}.")
        rows = [toml_value(row) for row in zip(*lists.values(), strict=True)]
        if len(lists) == len(axis.columns) and len(set(rows)) < len(rows):
            raise self._read.refuse(f"{COUPLED}.{first}", "the same values are there twice, in every key.")
