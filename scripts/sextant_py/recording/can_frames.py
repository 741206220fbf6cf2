"""CAN frames as groups of a recording: all as they are, and the signals of those that the DBC has."""

import threading
import time
from collections import deque

import can
import numpy as np

from .. import bus as can_bus
from ..contract import Contract
from ..errors import UserError
from .model import Column, Group

CAN = "can"
LARGEST_DATA = 64  # bytes, of CAN FD
RECEIVE_BUFFER = 4_000_000  # bytes, asked of the kernel
_TIME = Column("t_ns", "<i8", "ns", "when the frame was received, on the monotonic clock of this machine")
FRAMES = Group(
    CAN,
    (
        _TIME,
        Column("id", "<u4", "1", "identifier"),
        Column("is_extended", "|u1", "1", "29-bit identifier"),
        Column("is_remote", "|u1", "1", "remote frame"),
        Column("is_error", "|u1", "1", "error frame"),
        Column("is_fd", "|u1", "1", "CAN FD"),
        Column("length", "|u1", "1", "bytes of data"),
        Column("data", f"|S{2 * LARGEST_DATA}", "1", "bytes of data, hexadecimal"),
    ),
    "CAN frames as received",
)


def wall_minus_monotonic_ns() -> int:
    """The offset of the wall clock from the monotonic clock, from the quickest of some readings."""

    def reading() -> tuple[int, int]:
        before = time.monotonic_ns()
        wall = time.time_ns()
        after = time.monotonic_ns()
        return after - before, wall - (before + after) // 2

    return min(reading() for _ in range(5))[1]


def row_of(frame: can.Message, t_ns: int) -> tuple:
    flags = (frame.is_extended_id, frame.is_remote_frame, frame.is_error_frame, frame.is_fd)
    return (t_ns, frame.arbitration_id, *flags, len(frame.data), bytes(frame.data).hex().encode())


def frame_of(row: np.void) -> can.Message:
    return can.Message(
        arbitration_id=int(row["id"]),
        is_extended_id=bool(row["is_extended"]),
        is_remote_frame=bool(row["is_remote"]),
        is_error_frame=bool(row["is_error"]),
        is_fd=bool(row["is_fd"]),
        dlc=int(row["length"]),
        data=b"" if row["is_remote"] else bytes.fromhex(row["data"].decode()),
    )


def group_of(contract: Contract, name: str) -> Group:
    """The signals of a message, as physical values."""
    message = contract.message(name)
    columns = [_TIME]
    for signal in message.signals:
        choices = ", ".join(f"{value} {text}" for value, text in (signal.choices or {}).items())
        text = (signal.comment or signal.name) + (f" ({choices})" if choices else "")
        columns.append(Column(signal.name, "<f8", signal.unit or "1", text))
    return Group(f"{CAN}/{name}", tuple(columns), message.comment or f"signals of {name}")


class CanReader:
    """Receives the frames of a bus in a thread of its own."""

    def __init__(self, address: str, identifier_offset: int) -> None:
        self._contract = Contract(identifier_offset=identifier_offset)
        self._groups: dict[str, Group] = {}
        self._frames: deque[tuple[int, can.Message]] = deque()
        self._stop = threading.Event()
        self.failure: str | None = None
        self._address = address
        self._bus = can_bus.open_bus(can_bus.parse(address))
        can_bus.widen(self._bus, RECEIVE_BUFFER)
        self._thread = threading.Thread(target=self._receive, daemon=True)
        self._thread.start()

    def _receive(self) -> None:
        try:
            while not self._stop.is_set():
                if (frame := can_bus.receive(self._bus, 0.1)) is not None:
                    self._frames.append((round(frame.timestamp * 1e9), frame))
        except (can.CanError, OSError) as error:
            self.failure = f"the CAN bus {self._address} can no longer be read: {error}."

    def poll(self) -> list[tuple[Group, np.ndarray]]:
        """The frames that have come since the last call. Their times are the kernel's, of the wall clock."""
        if self.failure and not self._frames:
            raise UserError(self.failure)
        offset_ns = wall_minus_monotonic_ns()
        frames = [self._frames.popleft() for _ in range(len(self._frames))]
        if not frames:
            return []
        rows = np.array([row_of(frame, wall_ns - offset_ns) for wall_ns, frame in frames], FRAMES.dtype)
        signals: dict[str, list[tuple]] = {}
        for t_ns, (_, frame) in zip(rows["t_ns"], frames, strict=True):
            if (found := self._contract.decode_numbers(frame)) is not None:
                signals.setdefault(found[0], []).append((t_ns, *found[1]))
        return [(FRAMES, rows), *(self._block(name, values) for name, values in signals.items())]

    def _block(self, name: str, values: list[tuple]) -> tuple[Group, np.ndarray]:
        group = self._groups.setdefault(name, group_of(self._contract, name))
        return group, np.array(values, group.dtype)

    def close(self) -> None:
        self._stop.set()
        self._thread.join()
        self._bus.shutdown()
