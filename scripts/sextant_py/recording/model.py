"""What a recording is made of: groups of signals over one clock, read and written in blocks of rows."""

import heapq
import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from ..errors import UserError, reason_of

MAIN = "telemetry"  # the root of an HDF5 file, and the file NAME.csv of several
TRIGGER = "trigger_ns"  # of the metadata: the instant that a capture was triggered at
BEGIN = "begin_ns"  # of a trace's attributes: the instant that the times of its run count from
TIMES = {"t_ns": 1, "t_s": 1_000_000_000}  # names of a time axis, and nanoseconds a unit
BLOCK_ROWS = 8192
Metadata = dict[str, Any]  # what JSON can hold


@dataclass(frozen=True)
class Column:
    name: str
    kind: str  # of numpy: "<f4", "|u1"; "|S64" is text of up to 64 bytes in UTF-8
    unit: str = ""
    text: str = ""

    @property
    def is_text(self) -> bool:
        return np.dtype(self.kind).kind == "S"


@dataclass(frozen=True)
class Group:
    """Signals that have the same times. A block of its rows is a structured array of its dtype."""

    name: str
    columns: tuple[Column, ...]
    text: str = ""
    time_of: str = ""  # the group whose time axis this one shares, where a trace stores it once

    @cached_property
    def dtype(self) -> np.dtype:
        return np.dtype([(column.name, column.kind) for column in self.columns])

    @cached_property
    def time(self) -> str:
        """The name of the time axis."""
        for name in TIMES:
            if name in (self.dtype.names or ()):
                return name
        raise UserError(f"the group {self.name} has no time axis; it needs a signal {' or '.join(TIMES)}.")

    def times_ns(self, block: np.ndarray) -> np.ndarray:
        """The times of the rows [ns]."""
        times = block[self.time]
        return times.astype(np.int64) if self.time == "t_ns" else np.rint(times * TIMES[self.time]).astype(np.int64)

    def described(self) -> dict[str, Any]:
        """As JSON holds it."""
        columns = [[column.name, column.kind, column.unit, column.text] for column in self.columns]
        return {"name": self.name, "text": self.text, "time_of": self.time_of, "signals": columns}

    @classmethod
    def of(cls, described: dict[str, Any]) -> "Group":
        """The group that `described` gives. ValueError, KeyError or TypeError where it is no such description."""
        columns = tuple(Column(*column) for column in described["signals"])
        group = cls(described["name"], columns, described["text"], described["time_of"])
        texts = [group.name, group.text, group.time_of, *(text for c in columns for text in (c.name, c.unit, c.text))]
        if not all(isinstance(text, str) for text in texts):
            raise TypeError("a description that is no text")
        if any(np.dtype(column.kind).kind not in "iufS" for column in columns):
            raise ValueError("a type that no signal has")
        if not group.dtype.names:
            raise ValueError("a group without signals")
        return group


def metadata_of(value: Any) -> Metadata:
    """The metadata of a recording, as JSON had them. ValueError or TypeError where no program of Sextant wrote them."""
    if not isinstance(value, dict) or not all(isinstance(value.get(key, {}), dict) for key in ("attributes", "rows")):
        raise TypeError("metadata of another form")
    if not all(isinstance(count, int) for count in value.get("rows", {}).values()):
        raise TypeError("a number of rows that is none")
    return value


@contextmanager
def of_sextant(path: object, place: str) -> Iterator[None]:
    """Refuses a description in a place where Sextant's stand that has another form: it was read whole, so that the file
    is not damaged."""
    try:
        yield
    except (ValueError, KeyError, TypeError, AttributeError):
        raise UserError(
            f"{path} was not written by Sextant, or was changed: {place} is not what its programs write there."
        ) from None


def begin_of_run(metadata: Metadata, first: np.ndarray) -> int | None:
    """The instant at which the run of a trace began [ns], by its attributes; None: it is no trace. `first`: the first
    row of its telemetry.

    A row has the time of its end, and the first one is not complete: without the attribute (traces of earlier versions,
    replays) the run began with the first of the row's control periods.
    """
    attributes = {k: v for k, v in metadata.get("attributes", {}).items() if k == "mode" or isinstance(v, int | float)}
    if BEGIN in attributes:
        return int(attributes[BEGIN])
    names = first.dtype.names or ()
    if "control_period_ns" in attributes and {"t_ns", "periods"} <= set(names):
        return int(first["t_ns"][0]) - (int(first["periods"][0]) - 1) * int(attributes["control_period_ns"])
    return 0 if attributes.get("mode") == "event_exact" else None


class Sink(Protocol):
    """A file that is written block by block. OSError: there was no room; what `kept` counts stays readable."""

    kept: dict[str, int]

    def add(self, group: Group) -> None: ...

    def append(self, name: str, block: np.ndarray) -> None: ...

    def close(self, metadata: Metadata) -> None: ...


class Source(Protocol):
    """A file that is read block by block, or the several `paths` of a recording. `cut` says in a sentence what a file
    lacks that was truncated or not closed, `unverified` that it has no checksums. UserError: what it holds is
    damaged."""

    metadata: Metadata
    groups: dict[str, Group]
    cut: str | None
    unverified: str | None
    paths: list[Path]

    def rows(self, name: str) -> int: ...

    def blocks(self, name: str, rows: int = BLOCK_ROWS) -> Iterator[np.ndarray]: ...


def merged(source: Source, names: list[str] | None = None) -> Iterator[tuple[Group, np.ndarray]]:
    """The blocks of all groups, the one that begins first before the others."""
    waiting: list[tuple[int, int, Group, np.ndarray, Iterator[np.ndarray]]] = []

    def put(order: int, group: Group, blocks: Iterator[np.ndarray]) -> None:
        for block in blocks:
            if len(block):
                heapq.heappush(waiting, (int(group.times_ns(block[:1])[0]), order, group, block, blocks))
                return

    for order, name in enumerate(source.groups if names is None else names):
        put(order, source.groups[name], source.blocks(name))
    while waiting:
        _, order, group, block, blocks = heapq.heappop(waiting)
        yield group, block
        put(order, group, blocks)


def unreadable(path: object, error: Exception, what: str) -> UserError:
    """Why a library could not read a file: what the system refuses (a permission, descriptors, room) is no damage of
    the file, of which `what` is said otherwise."""
    if isinstance(error, OSError) and error.errno:
        other = error.filename is not None and str(error.filename) != str(path)
        return UserError(f"{path} cannot be read: {reason_of(error) if other else os.strerror(error.errno)}.")
    return UserError(f"{path} {what}: {' '.join(str(error).split()).rstrip('.')}.")


@contextmanager
def damage(path: Path, *errors: type[Exception]) -> Iterator[None]:
    """Turns what a library raises at a damaged file into a sentence."""
    try:
        yield
    except errors as error:
        raise unreadable(path, error, "is damaged and cannot be read") from None


def missing_rows(metadata: Metadata, kept: dict[str, int]) -> dict[str, int]:
    """Rows by group that the file had when it was closed and has no more."""
    rows = metadata.get("rows", {})
    return {name: count - kept.get(name, 0) for name, count in rows.items() if count > kept.get(name, 0)}


def cut_sentence(path: object, kept: dict[str, int], lost: str) -> str:
    return f"{path} is truncated: {lost}; {left(kept)}"


def unclosed_sentence(path: object, metadata: Metadata, kept: dict[str, int]) -> str | None:
    """One sentence for a recording that its recorder has not closed: at its end it writes the counts of rows."""
    if metadata.get("program") != "record" or "rows" in metadata:
        return None
    return f"{path} was not closed, so what came last may be missing; {left(kept)}"


def unverified_sentence(path: object) -> str:
    """One sentence for a file of another or an earlier program."""
    return f"{path} has no checksums, so that damage of its values is not noticed"


def left(rows: dict[str, int]) -> str:
    return f"rows that are left: {counted(rows)}"


def counted(rows: dict[str, int]) -> str:
    """The groups that have rows."""
    return ", ".join(f"{count} of {name}" for name, count in rows.items() if count) or "none"
