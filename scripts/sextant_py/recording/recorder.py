"""Records a drive to a file until it is told to stop."""

import os
import time
from pathlib import Path
from types import TracebackType
from typing import Protocol, Self

import numpy as np

from ..errors import UserError
from .can_frames import Gap, wall_minus_monotonic_ns
from .copying import copy
from .formats import AT_THE_END, check, open_sink, open_source
from .losses import LossCounter
from .model import MAIN, Group, Metadata, Sink


class Rows(Protocol):
    """Where rows come from."""

    drive_id: int | None

    def poll(self) -> list[tuple[Group, np.ndarray]]: ...

    def gaps(self) -> list[Gap]: ...

    def close(self) -> None: ...


class Recorder:
    """Writes to the file while rows come, or, in a format that is readable at its end only, to FILE.part.mcap."""

    def __init__(self, path: Path, rows: Rows, about: Metadata) -> None:
        check(path)
        self.path = path
        self.written = path.with_name(f"{path.name}.part.mcap") if path.suffix in AT_THE_END else path
        if self.written != path and self.written.exists():
            raise UserError(f"{self.written} is there, of an earlier run; convert it by scripts/convert, or remove it.")
        self.losses = LossCounter()
        self.rows = rows
        self._about = about
        self._sink: Sink | None = None
        self._seen: set[str] = set()
        self._begin: Metadata = {
            "clock": "t_ns counts on CLOCK_MONOTONIC; drive and recorder share it on one machine",
            "begin_ns": time.monotonic_ns(),
            "wall_minus_monotonic_begin_ns": wall_minus_monotonic_ns(),
        }

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        try:
            if self._sink:
                self._sink.close(self.metadata())
        finally:
            self.rows.close()

    def begin(self) -> Metadata:
        """What is known when the file is opened."""
        return {**self._about, "drive_id": self.rows.drive_id, **self._begin}

    def metadata(self) -> Metadata:
        """What is known at the end. `rows` and `end_ns` show that the file was closed."""
        rows = dict(self._sink.kept) if self._sink else {}
        ended = {"end_ns": time.monotonic_ns(), "wall_minus_monotonic_end_ns": wall_minus_monotonic_ns()}
        gaps = [gap.described() for gap in self.rows.gaps()]
        return {**self.begin(), "rows": rows, "losses": self.losses.described(), "can_gaps": gaps, **ended}

    @property
    def count(self) -> int:
        """Rows of telemetry."""
        return self.losses.of[MAIN].rows if MAIN in self.losses.of else 0

    def poll(self) -> None:
        """Writes what has come."""
        for group, block in self.rows.poll():
            self.losses.take(group.name, block)
            try:
                if self._sink is None:
                    self._sink = open_sink(self.written, self.begin())
                if group.name not in self._seen:
                    self._sink.add(group)
                    self._seen.add(group.name)
                self._sink.append(group.name, block)
            except OSError as error:
                raise UserError(self._full(error)) from None

    def _full(self, error: OSError) -> str:
        reason = os.strerror(error.errno) if error.errno else error
        sink, self._sink = self._sink, None
        if sink:
            sink.close({**self.begin(), "rows": dict(sink.kept)})
        count = sink.kept.get(MAIN, 0) if sink else 0
        kept = f"; its first {count} samples are kept" if count else ""
        kept += f" in {self.written}" if count and self.written != self.path else ""
        return f"the recording {self.path} cannot be written: {reason}{kept}."

    def convert(self, report) -> None:
        """Makes the file of what was recorded beside it, where the format asks for that."""
        if self.written == self.path:
            return
        try:
            copy(open_source(self.written), self.path, None, report)
        except UserError as error:
            raise UserError(f"{error} The recording is kept in {self.written}; scripts/convert converts it.") from None
        self.written.unlink()
