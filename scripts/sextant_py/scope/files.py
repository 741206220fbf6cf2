"""Captures as files, in every format of a recording."""

from pathlib import Path

import numpy as np

from ..recording.model import TRIGGER
from ..recording.replacing import close_whole, replacing, whole_sink
from ..recording.topics import STATE, WAVEFORM, group_of
from .capture import Capture


def numbered(path: Path, number: int, several: bool) -> Path:
    """capture.h5, or capture_001.h5 where there can be several."""
    return path.with_name(f"{path.stem}_{number:03}{path.suffix}") if several else path


def write(path: Path, capture: Capture, drive_id: int | None, states: np.ndarray | None = None) -> None:
    """The waveform of the capture and, where there are any, the changes of the drive's state within it. An existing
    file is replaced; it stays where the capture cannot be written."""
    metadata = {"trigger": capture.trigger, TRIGGER: capture.trigger_ns, "drive_id": drive_id, "main": WAVEFORM}
    blocks = {WAVEFORM: capture.rows}
    if states is not None and len(within := _within(capture, states)):
        blocks[STATE] = within
    with replacing(path, "the capture ") as place, whole_sink(place, metadata) as sink:
        for name in blocks:
            sink.add(group_of(name))
        for name, block in blocks.items():
            sink.append(name, block)
        close_whole(sink, metadata, {name: len(block) for name, block in blocks.items()})


def _within(capture: Capture, states: np.ndarray) -> np.ndarray:
    """The changes between the first and the last row of the capture."""
    times = states["t_ns"].astype(np.int64)
    return states[(times >= int(capture.rows["t_ns"][0])) & (times <= int(capture.rows["t_ns"][-1]))]
