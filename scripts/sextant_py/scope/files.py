"""Captures as files, in every format of a recording."""

import errno
import os
import tempfile
from pathlib import Path

import numpy as np

from ..errors import UserError
from ..recording.arrow_table import file_of
from ..recording.formats import open_sink
from ..recording.model import TRIGGER, Metadata, Sink
from ..recording.topics import STATE, WAVEFORM, group_of
from .capture import Capture

FILE_A_GROUP = (".csv", ".parquet")


def numbered(path: Path, number: int, several: bool) -> Path:
    """capture.h5, or capture_001.h5 where there can be several."""
    return path.with_name(f"{path.stem}_{number:03}{path.suffix}") if several else path


def write(path: Path, capture: Capture, drive_id: int | None, states: np.ndarray | None = None) -> None:
    """The waveform of the capture and, where there are any, the changes of the drive's state within it. An existing
    file is replaced; it stays where the capture cannot be written."""
    metadata = {"trigger": capture.trigger, TRIGGER: capture.trigger_ns, "drive_id": drive_id}
    blocks = {WAVEFORM: capture.rows}
    if states is not None and len(within := _within(capture, states)):
        blocks[STATE] = within
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=".capture_", dir=path.parent) as folder:
            _write(Path(folder, path.name), metadata, blocks)
            _replace(path, Path(folder), STATE in blocks)
    except OSError as error:
        reason = os.strerror(error.errno) if error.errno else error
        raise UserError(f"the capture {path} cannot be written: {reason}; nothing of it is kept.") from None


def _within(capture: Capture, states: np.ndarray) -> np.ndarray:
    """The changes between the first and the last row of the capture."""
    times = states["t_ns"].astype(np.int64)
    return states[(times >= int(capture.rows["t_ns"][0])) & (times <= int(capture.rows["t_ns"][-1]))]


def _write(path: Path, metadata: Metadata, blocks: dict[str, np.ndarray]) -> None:
    """OSError where there is no room for all rows."""
    sink = open_sink(path, metadata)
    rows = {name: len(block) for name, block in blocks.items()}
    try:
        for name in blocks:
            sink.add(group_of(name))
        for name, block in blocks.items():
            sink.append(name, block)
    except OSError:
        _abandon(sink, metadata)
        raise
    _close(sink, {**metadata, "rows": rows})
    if sink.kept != rows:  # a sink may give up rows to close its file on a full disk
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def _close(sink: Sink, metadata: Metadata) -> None:
    try:
        sink.close(metadata)
    except OSError:
        if hasattr(sink, "abandon"):
            sink.abandon()
        raise


def _abandon(sink: Sink, metadata: Metadata) -> None:
    """Ends a sink whose files are removed; those that cannot be readable have no end."""
    if hasattr(sink, "abandon"):
        sink.abandon()
    else:
        sink.close(metadata)


def _replace(path: Path, folder: Path, has_states: bool) -> None:
    """Moves the files of the folder beside `path`, without states of an earlier capture."""
    for file in folder.iterdir():
        file.replace(path.with_name(file.name))
    if not has_states and path.suffix in FILE_A_GROUP:
        file_of(path, STATE).unlink(missing_ok=True)
