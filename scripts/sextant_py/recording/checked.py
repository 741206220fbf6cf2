"""What every format has to hold, whoever wrote the file: a time axis whose times are instants. In a file that no
recorder wrote, time never goes back; two rows of one time are a step."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import UserError
from .model import BLOCK_ROWS, MAIN, TIMES, Group, Source

LATEST_NS = 2**63 - 1  # of a time, as recordings count it


class CheckedSource:
    """A source each of whose times is a number, and of 64 bits in nanoseconds."""

    def __init__(self, path: Path, source: Source) -> None:
        self._path, self._source = path, source
        for group in source.groups.values():
            if not set(TIMES) & set(group.dtype.names or ()):
                raise UserError(
                    f"{path}: the group {group.name} has no time axis; it needs a signal {' or '.join(TIMES)}."
                )

    def __getattr__(self, name: str) -> Any:
        return getattr(self._source, name)

    def blocks(self, name: str, rows: int = BLOCK_ROWS) -> Iterator[np.ndarray]:
        at, first, last = 0, None, None
        group = self._source.groups[name]
        for block in self._source.blocks(name, rows):
            self._check(group, block, at)
            if "program" not in self._source.metadata:
                self._check_order(group, block, at, last)
            if len(block):
                first = block[group.time][0] if first is None else first
                last = block[group.time][-1]
            at += len(block)
            yield block
        if name == MAIN and at > 1 and "program" not in self._source.metadata:
            self._check_progress(group, at, first, last)

    def _check_progress(self, group: Group, rows: int, first: Any, last: Any) -> None:
        """Of times that do not go back."""
        if first == last:
            raise UserError(f"{self._path}: {group.time} stands still at {first:g} in all {rows} rows; it is no time.")

    def _check(self, group: Group, block: np.ndarray, at: int) -> None:
        times = block[group.time]
        if times.dtype.kind == "i":
            return
        limit = LATEST_NS / TIMES[group.time]
        # A limit of floating point lies above LATEST_NS; NaN compares as neither.
        good = times <= LATEST_NS if times.dtype.kind == "u" else np.abs(times) < limit
        if not good.all():
            row = int(np.argmin(good))
            expected = f"expected a number from {-limit:.3g} to {limit:.3g}"
            where = f"{self._path}, row {at + row + 1} of {group.name}"
            raise UserError(f"{where}: {group.time} is {times[row]:g}: {expected}.")

    def _check_order(self, group: Group, block: np.ndarray, at: int, last: Any) -> None:
        """last: the time before the block; None: it is the first."""
        times = block[group.time]
        back = np.flatnonzero(times[1:] < times[:-1]) + 1
        if last is not None and len(times) and times[0] < last:
            back = np.array([0])
        if len(back):
            row = int(back[0])
            where = f"{self._path}, row {at + row + 1} of {group.name}"
            before = times[row - 1] if row else last
            raise UserError(f"{where}: {group.time} goes back from {before:g} to {times[row]:g}; a file has one run.")
