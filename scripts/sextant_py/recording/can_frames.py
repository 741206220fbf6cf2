"""CAN frames as groups of a recording: all as they are, and the signals of those that the DBC has."""

import threading
import time
from collections import deque
from contextlib import suppress
from dataclasses import asdict, dataclass

import can
import numpy as np

from .. import bus as can_bus
from ..contract import Contract
from ..errors import UserError
from .model import Column, Group

CAN = "can"
LARGEST_DATA = 64  # bytes, of CAN FD
REOPEN_S = 0.2  # between two tries to open a bus again
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
        Column("is_fast", "|u1", "1", "CAN FD: data at the higher bit rate (BRS)"),
        Column("is_error_passive", "|u1", "1", "CAN FD: the sender is error passive (ESI)"),
        Column("length", "|u1", "1", "bytes of data; of a remote frame those that it asks for"),
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
    flags += (frame.bitrate_switch, frame.error_state_indicator)
    length = frame.dlc if frame.is_remote_frame else len(frame.data)
    return (t_ns, frame.arbitration_id, *flags, length, bytes(frame.data).hex().encode())


def frame_of(row: np.void) -> can.Message:
    """The frame of a row; those of earlier versions lack what only CAN FD has."""
    names = row.dtype.names
    return can.Message(
        arbitration_id=int(row["id"]),
        is_extended_id=bool(row["is_extended"]),
        is_remote_frame=bool(row["is_remote"]),
        is_error_frame=bool(row["is_error"]),
        is_fd=bool(row["is_fd"]),
        bitrate_switch="is_fast" in names and bool(row["is_fast"]),
        error_state_indicator="is_error_passive" in names and bool(row["is_error_passive"]),
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


@dataclass
class Gap:
    """A time in which the bus could not be read, on the monotonic clock [ns]; end_ns is 0 while it lasts."""

    begin_ns: int
    reason: str
    end_ns: int = 0

    def described(self) -> dict[str, int | str]:
        return asdict(self)


class CanReader:
    """Receives the frames of a bus in a thread of its own. A bus that cannot be read any more, as one whose link goes
    down, is opened again as soon as that is possible; `gaps` has the times between."""

    def __init__(self, address: str, identifier_offset: int) -> None:
        self._contract = Contract(identifier_offset=identifier_offset)
        self._groups: dict[str, Group] = {}
        self._frames: deque[tuple[int, can.Message]] = deque()
        self._stop = threading.Event()
        self.gaps: list[Gap] = []
        self._address = address
        self._bus = self._opened()
        self._thread = threading.Thread(target=self._receive, daemon=True)
        self._thread.start()

    def _opened(self) -> can.BusABC:
        opened = can_bus.open_bus(can_bus.parse(self._address))
        try:
            can_bus.widen(opened, RECEIVE_BUFFER)
        except OSError:
            opened.shutdown()
            raise
        return opened

    def _receive(self) -> None:
        while not self._stop.is_set():
            try:
                if (frame := can_bus.receive(self._bus, 0.1)) is not None:
                    self._frames.append((round(frame.timestamp * 1e9), frame))
            except (can.CanError, OSError, ValueError) as error:  # ValueError: its descriptor is closed
                self._open_again(str(error))

    def _open_again(self, reason: str) -> None:
        gap = Gap(time.monotonic_ns(), reason)
        self.gaps.append(gap)
        self._bus.shutdown()
        while not self._stop.wait(REOPEN_S):
            with suppress(UserError, OSError):
                self._bus = self._opened()
                gap.end_ns = time.monotonic_ns()
                return

    def poll(self) -> list[tuple[Group, np.ndarray]]:
        """The frames that have come since the last call. Their times are the kernel's, of the wall clock."""
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
