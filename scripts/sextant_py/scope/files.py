"""Captures as files, in every format of a recording."""

import os
from pathlib import Path

import numpy as np

from ..errors import UserError
from ..recording.formats import open_sink
from ..recording.model import TRIGGER
from ..recording.topics import STATE, WAVEFORM, group_of
from .capture import Capture


def numbered(path: Path, number: int, several: bool) -> Path:
    """capture.h5, or capture_001.h5 where there can be several."""
    return path.with_name(f"{path.stem}_{number:03}{path.suffix}") if several else path


def write(path: Path, capture: Capture, drive_id: int | None, states: np.ndarray | None = None) -> None:
    """The waveform of the capture and, where given, the changes of the drive's state within it."""
    metadata = {"trigger": capture.trigger, TRIGGER: capture.trigger_ns, "drive_id": drive_id}
    blocks = {WAVEFORM: capture.rows}
    if states is not None and len(states):
        times = states["t_ns"].astype(np.int64)
        within = (times >= int(capture.rows["t_ns"][0])) & (times <= int(capture.rows["t_ns"][-1]))
        blocks[STATE] = states[within]
    try:
        sink = open_sink(path, metadata)
        for name in blocks:
            sink.add(group_of(name))
        for name, rows in blocks.items():
            sink.append(name, rows)
        sink.close({**metadata, "rows": dict(sink.kept)})
    except OSError as error:
        reason = os.strerror(error.errno) if error.errno else error
        raise UserError(f"the capture {path} cannot be written: {reason}.") from None
