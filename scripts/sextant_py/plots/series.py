"""Signals of a trace or a recording, each with its time axis."""

import difflib
import re
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import cached_property
from pathlib import Path

import numpy as np

from .. import signal_file
from ..errors import UserError
from ..recording.model import MAIN, Column
from ..recording.value_texts import value_texts
from ..signal_file import GroupRows

# How names of signals end, by unit.
SUFFIXES = {"N·m": "_nm", "Wb": "_wb", "rad/s": "_rad_s", "A": "_a", "V": "_v", "W": "_w", "J": "_j", "rad": "_rad"}
TRACE = "trace"  # file of every run of sextant-mil
STATISTIC = re.compile(r"(.*)_(mean|min|max)_(.+)")


@dataclass(frozen=True)
class Series:
    """A signal; its samples are read when they are first needed."""

    name: str
    column: Column
    rows: GroupRows

    @property
    def unit(self) -> str:
        return self.column.unit

    @property
    def text(self) -> str:
        return self.column.text

    @property
    def time_s(self) -> np.ndarray:
        return self.rows.time_s

    @property
    def values(self) -> np.ndarray:
        return self.rows.values(self.column.name)

    @property
    def quantity(self) -> str:
        """The name without the part that says which statistic over an interval it is."""
        found = STATISTIC.fullmatch(self.name)
        return f"{found[1]}_{found[3]}" if found else self.name

    @property
    def stem(self) -> str:
        """The quantity without its unit."""
        return self.quantity.removesuffix(SUFFIXES.get(self.unit, ""))

    @cached_property
    def value_texts(self) -> dict[int, str]:
        """The names of an enumeration's values; empty where values are numbers."""
        return value_texts(self.rows.group.name, self.column.name) if self.is_discrete else {}

    @property
    def is_discrete(self) -> bool:
        return np.dtype(self.column.kind).kind in "biu"


@dataclass(frozen=True)
class SeriesFile:
    path: Path
    label: str  # that tells it from the other files
    series: dict[str, Series]
    main: set[str]  # names of those on the time axis of the telemetry
    cut: str | None  # what a truncated file has lost, in a sentence
    trigger: str | None = None  # of a capture
    has_telemetry: bool = False

    def find(self, wanted: str) -> list[Series]:
        """The signals that a name stands for: its own, of a pattern, of a quantity, or of a group that is not named."""
        if wanted in self.series:
            return [self.series[wanted]]
        every = self.series.values()
        for matches in (
            lambda series: fnmatchcase(series.name, wanted),
            lambda series: wanted in (series.quantity, series.stem),
            lambda series: series.name.rpartition("/")[2] == wanted,
            lambda series: wanted in (series.quantity.rpartition("/")[2], series.stem.rpartition("/")[2]),
        ):
            if found := [series for series in every if matches(series)]:
                return found
        raise UserError(f'{self.path} has no signal "{wanted}"; {self._hint(wanted)}.')

    def _hint(self, wanted: str) -> str:
        names = [*self.series, *(series.stem for series in self.series.values())]
        near = difflib.get_close_matches(wanted, dict.fromkeys(names), 3, 0.5)
        near = near or [name for name in self.series if wanted.lower() in name.lower()][:3]
        return f"the nearest are {', '.join(near)}" if near else "scripts/plot --list shows its signals"


def labels(paths: list[Path]) -> list[str]:
    """The shortest ends of the paths that tell them apart. A trace alone has the name of its run's directory."""
    if len(paths) == 1 and paths[0].stem == TRACE:
        return [paths[0].resolve().parent.name]
    for count in range(1, max(len(path.parts) for path in paths) + 1):
        ends = ["/".join(path.parts[-count:]) for path in paths]
        if len(set(ends)) == len(paths):
            break
    common = Path(ends[0]).name
    if all(end.endswith(f"/{common}") for end in ends):
        return [end.removesuffix(f"/{common}") for end in ends]
    return ends


def load(paths: list[Path], begin_s: float | None, end_s: float | None) -> list[SeriesFile]:
    files = []
    for path, label in zip(paths, labels(paths), strict=True):
        found = signal_file.SignalFile(path, begin_s, end_s)
        named = {
            name: Series(name, column, found.groups[group])
            for group in found.filled()
            for name, column in found.columns(group)
            if column.name != "t_ns"
        }
        main = {name for group in found.of_main() for name, _ in found.columns(group)}
        files.append(SeriesFile(path, label, named, main, found.cut, found.trigger, found.main == MAIN))
    return files
