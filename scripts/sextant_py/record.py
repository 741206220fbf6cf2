"""Records DriveTelemetry of one drive, every sample, to HDF5 or CSV; signals are named as in the telemetry contract."""

import argparse
import csv
import enum
import io
import os
import signal
import time
from pathlib import Path
from types import TracebackType
from typing import Any, Protocol, Self

import h5py
import numpy as np

from .append_file import AppendFile
from .dds import Telemetry
from .errors import UserError, run
from .telemetry_contract import signals

DEPTH = 5000
POLL_S = 0.05


class Sink(Protocol):
    """A file that takes rows of values. OSError: the rows found no room; what was appended before stays readable."""

    def append(self, rows: list[list[Any]]) -> None: ...

    def close(self) -> None: ...


class CsvSink:
    """One line a sample."""

    def __init__(self, path: Path, names: list[str]) -> None:
        self._file = AppendFile(path)
        try:
            self.append([names])
        except OSError:
            self._file.close()
            raise

    def append(self, rows: list[list[Any]]) -> None:
        text = io.StringIO(newline="")
        csv.writer(text).writerows(rows)
        self._file.append(text.getvalue())

    def close(self) -> None:
        self._file.close()


class Hdf5Sink:
    """One dataset a signal, with unit and description, in the root group: the layout of a trace.

    HDF5 loses the whole file, and crashes at exit, where its own writes find no room. So the room is taken first, for
    more than the rows can need: every chunk they touch and its index.
    """

    CHUNK_ROWS = 4096
    VALUE_BYTES = 8
    INDEX_BYTES = 16_384

    def __init__(self, path: Path, names: list[str], first: list[Any]) -> None:
        # Space that was given up is not used again: what one flush left behind stays whole during the next.
        self._file = h5py.File(path, "w", fs_strategy="none")
        self._datasets: list[h5py.Dataset] = []
        try:
            self._reserve(len(names), 0)
            for name, value in zip(names, first, strict=True):
                self._datasets.append(self._create(name, value))
            self._file.flush()
        except OSError:
            self._file.close()
            raise

    def _create(self, name: str, value: Any) -> h5py.Dataset:
        kind = np.float64 if isinstance(value, float) else np.int64
        dataset = self._file.create_dataset(name, (0,), kind, maxshape=(None,), chunks=(self.CHUNK_ROWS,))
        for known in signals("DriveTelemetry"):
            if known.name == name:
                dataset.attrs["unit"], dataset.attrs["description"] = known.unit, known.text
        return dataset

    def _reserve(self, columns: int, rows: int) -> None:
        bytes_a_column = (rows + 2 * self.CHUNK_ROWS) * self.VALUE_BYTES + self.INDEX_BYTES
        os.posix_fallocate(self._file.id.get_vfd_handle(), self._file.id.get_filesize(), columns * bytes_a_column)

    def append(self, rows: list[list[Any]]) -> None:
        self._reserve(len(self._datasets), len(rows))
        for dataset, column in zip(self._datasets, zip(*rows, strict=True), strict=True):
            dataset.resize(dataset.shape[0] + len(rows), axis=0)
            dataset[-len(rows) :] = column
        self._file.flush()

    def close(self) -> None:
        self._file.close()


def row_of(sample: Any, names: list[str]) -> list[Any]:
    values = (getattr(sample, name) for name in names)
    return [value.value if isinstance(value, enum.Enum) else value for value in values]


class Recorder:
    """Takes samples until it is told to stop."""

    def __init__(self, path: Path, domain: int = 0, drive_id: int | None = None) -> None:
        self._path = path
        self._drive_id = drive_id
        self._sink: Sink | None = None
        self._names: list[str] = []
        self.telemetry = Telemetry(domain, DEPTH)
        self.count = 0

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if self._sink:
            self._sink.close()

    def poll(self) -> None:
        samples = self.telemetry.poll()
        if self._drive_id is None and samples:
            self._drive_id = samples[0].drive_id
        samples = [sample for sample in samples if sample.drive_id == self._drive_id]
        if not samples:
            return
        rows = [row_of(sample, self._names or list(sample.__annotations__)) for sample in samples]
        try:
            if self._sink is None:
                self._open(samples[0], rows[0])
            self._sink.append(rows)
        except OSError as error:
            kept = f"; its first {self.count} samples are kept" if self.count else ""
            reason = os.strerror(error.errno) if error.errno else error
            raise UserError(f"the recording {self._path} cannot be written: {reason}{kept}.") from None
        self.count += len(samples)

    def _open(self, sample: Any, row: list[Any]) -> None:
        self._names = list(sample.__annotations__)
        self._path.parent.mkdir(parents=True, exist_ok=True)
        if self._path.suffix == ".csv":
            self._sink = CsvSink(self._path, self._names)
        else:
            self._sink = Hdf5Sink(self._path, self._names, row)

    def lost(self) -> int:
        drive = self.telemetry.drives.get(self._drive_id)
        return drive.lost if drive else 0


def parse_arguments(arguments: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="record", description="Records the telemetry of one drive until Ctrl-C, SIGTERM or the end of --duration."
    )
    parser.add_argument("file", type=Path, metavar="FILE", help="recording to write, .h5 or .csv")
    parser.add_argument("--domain", type=int, default=0, help="DDS domain (default: 0)")
    parser.add_argument("--drive", type=int, metavar="ID", help="drive to record (default: the first one received)")
    parser.add_argument("--duration", type=float, metavar="S", help="end after so long")
    return parser.parse_args(arguments)


def main(arguments: list[str]) -> int:
    options = parse_arguments(arguments)
    if options.file.suffix not in (".h5", ".csv"):
        raise UserError(f"the recording {options.file} must be a .h5 or .csv file.")
    stopped = False

    def stop(_number: int, _frame: object) -> None:
        nonlocal stopped
        stopped = True

    signal.signal(signal.SIGTERM, stop)
    signal.signal(signal.SIGINT, stop)
    end_s = time.monotonic() + (options.duration or float("inf"))
    with Recorder(options.file, options.domain, options.drive) as recorder:
        while not stopped and time.monotonic() < end_s:
            recorder.poll()
            time.sleep(POLL_S)
        recorder.poll()
        if not recorder.count:
            raise UserError(" ".join(recorder.telemetry.problems()) or "no sample of that drive arrived.")
        print(f"{options.file}: {recorder.count} samples, {recorder.lost()} lost on the way")
    return 0


if __name__ == "__main__":
    run("record", main)
