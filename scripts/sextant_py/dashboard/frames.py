"""Samples of DriveTelemetry, and captures, as binary WebSocket frames.

A frame is four unsigned 32-bit numbers (kind, drive, columns, rows), then one column after another in 64-bit floats;
all little-endian. The page gets the names of the columns before.
"""

import struct
from collections.abc import Sequence
from operator import attrgetter
from typing import Any

import numpy as np

from ..telemetry_contract import enumerations, signals

HEADER = struct.Struct("<4I")
TELEMETRY = 1
CAPTURE = 2  # the second number is that of the capture


def columns() -> tuple[str, ...]:
    """The members of DriveTelemetry that a frame carries: all but the key."""
    return tuple(signal.name for signal in signals("DriveTelemetry") if not signal.is_key)


def _reader() -> attrgetter:
    """Reads a sample's columns; enumerations by value."""
    kinds = {signal.name: signal.type for signal in signals("DriveTelemetry")}
    return attrgetter(*(f"{name}.value" if kinds[name] in enumerations() else name for name in columns()))


class TelemetryFrames:
    """Encodes the samples of one poll."""

    def __init__(self) -> None:
        self._read = _reader()

    def encode(self, drive_id: int, samples: Sequence[Any]) -> bytes:
        table = np.array([self._read(sample) for sample in samples], dtype="<f8")
        return HEADER.pack(TELEMETRY, drive_id, table.shape[1], table.shape[0]) + table.T.tobytes()
