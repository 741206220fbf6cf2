"""What every format has to hold, whoever wrote the file: a time axis whose times are instants."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import UserError
from .model import BLOCK_ROWS, TIMES, Group, Source

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
        at = 0
        for block in self._source.blocks(name, rows):
            self._check(self._source.groups[name], block, at)
            at += len(block)
            yield block

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
