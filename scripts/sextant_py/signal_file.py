"""Signals of a trace of sextant-mil or of a recording, in any of its file formats, over time in seconds."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np

from .errors import UserError
from .recording.formats import open_source
from .recording.model import MAIN, TRIGGER, Column, Group, Source, begin_of_run


@dataclass
class Signals:
    """Signals over one time axis."""

    time_s: np.ndarray
    values: dict[str, np.ndarray]
    units: dict[str, str] = field(default_factory=dict)
    texts: dict[str, str] = field(default_factory=dict)


@dataclass
class GroupRows:
    """The rows of a group within a span of time; read when they are first needed."""

    path: Path
    source: Source
    group: Group
    zero_ns: int  # time 0
    begin_s: float
    end_s: float

    def _times_s(self, block: np.ndarray) -> np.ndarray:
        if self.group.time == "t_s":
            return block["t_s"] - self.zero_ns / 1e9
        return (self.group.times_ns(block) - self.zero_ns) / 1e9

    @cached_property
    def _read(self) -> tuple[np.ndarray, np.ndarray]:
        """Times [s] and rows."""
        times, rows, ends = [], [], []
        for block in self.source.blocks(self.group.name):
            time_s = self._times_s(block)
            wanted = (time_s >= self.begin_s) & (time_s <= self.end_s)
            times.append(time_s[wanted])
            rows.append(block[wanted])
            ends += [time_s[0], time_s[-1]]
        if not ends:
            raise UserError(f"{self.path} has no samples of {self.group.name}.")
        if not sum(map(len, times)):
            raise UserError(f"{self.path} has no sample in that span; it runs from {min(ends):g} s to {max(ends):g} s.")
        return np.concatenate(times), np.concatenate(rows)

    def blocks(self) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Times [s] and rows of all of the group, block by block, none of which is kept."""
        return ((self._times_s(block), block) for block in self.source.blocks(self.group.name) if len(block))

    @property
    def count(self) -> int:
        """Rows of the group, also those outside of the span."""
        return self.source.rows(self.group.name)

    @property
    def time_s(self) -> np.ndarray:
        return self._read[0]

    def values(self, column: str) -> np.ndarray:
        return self._read[1][column]


class SignalFile:
    """A file with the groups of its signals. The signals of the main group have no prefix, the others `GROUP/`."""

    def __init__(self, path: Path, begin_s: float | None = None, end_s: float | None = None) -> None:
        """The span counts from the trigger of a capture, from the beginning of a trace's run, from the first sample of
        a recording, or as t_s does."""
        source = open_source(path)
        self.path = path
        self.cut = source.cut  # what a truncated file has lost, in a sentence
        filled = [name for name in source.groups if source.rows(name)]
        if not filled:
            reason = source.cut or f"{path} has no samples of {', '.join(source.groups)}"
            raise UserError(f"{reason}.")
        self.main = self._main_of(source, filled)
        self.trigger: str | None = source.metadata.get("trigger") if TRIGGER in source.metadata else None
        begin = -np.inf if begin_s is None else begin_s
        end = np.inf if end_s is None else end_s
        zero_ns = self._zero_ns(source)
        self.groups = {
            name: GroupRows(path, source, group, zero_ns, begin, end) for name, group in source.groups.items()
        }

    @staticmethod
    def _main_of(source: Source, filled: list[str]) -> str:
        """The telemetry, otherwise the group that the file names, otherwise the one of the most rows: the waveform of a
        capture rather than the changes of the drive's state within it."""
        for name in (MAIN, source.metadata.get("main")):
            if name in filled:
                return name
        return max(filled, key=source.rows)

    def _zero_ns(self, source: Source) -> int:
        if TRIGGER in source.metadata:
            return int(source.metadata[TRIGGER])
        group = source.groups[self.main]
        first = next(source.blocks(self.main, 1))
        if group.time == "t_s":
            return 0
        begin_ns = begin_of_run(source.metadata, first)
        return int(group.times_ns(first)[0]) if begin_ns is None else begin_ns

    def of_main(self) -> list[str]:
        """The main group and those that share its time axis."""
        return [name for name in self.filled() if name == self.main or self.groups[name].group.time_of == self.main]

    def filled(self) -> list[str]:
        """The groups that have rows."""
        return [name for name, rows in self.groups.items() if rows.count]

    def columns(self, group: str, with_texts: bool = False) -> Iterator[tuple[str, Column]]:
        """The signals of a group, with their full names and without the time: numbers, with_texts also texts."""
        prefix = "" if group == self.main else f"{group}/"
        columns = [column for column in self.groups[group].group.columns if column.name != "t_s"]
        return ((prefix + column.name, column) for column in columns if with_texts or not column.is_text)

    def signals(self, groups: list[str], with_texts: bool = False) -> Signals:
        """The signals of groups that share a time axis."""
        found = Signals(self.groups[groups[0]].time_s, {})
        for group in groups:
            for name, column in self.columns(group, with_texts):
                if group == groups[0] or column.name != "t_ns":
                    found.values[name] = self.groups[group].values(column.name)
                    found.units[name], found.texts[name] = column.unit, column.text
        return found


def load(path: Path, begin_s: float | None = None, end_s: float | None = None) -> Signals:
    """The signals of the main group and of those that share its time axis."""
    file = SignalFile(path, begin_s, end_s)
    return file.signals(file.of_main())
