"""Raw frames of a bus in their order: by candump on SocketCAN, by python-can on UDP multicast."""

import os
import re
import socket
import subprocess
import time
from dataclasses import dataclass
from pathlib import Path

import can
from sextant_py import bus

RECEIVE_BUFFER = "4000000"  # bytes
SO_RCVBUFFORCE = 33
STARTING_S = 60.0  # at most, of candump


@dataclass(frozen=True)
class RawFrame:
    frame_id: int
    data: bytes


class FrameLog:
    """Listens for the time of a `with`."""

    def __init__(self, address: str, folder: Path) -> None:
        self._address = bus.parse(address)
        self._file = folder / "candump.log"
        self._candump: subprocess.Popen | None = None
        self._notifier: can.Notifier | None = None
        self._bus: can.BusABC | None = None
        self._frames: list[RawFrame] = []

    def __enter__(self) -> "FrameLog":
        self._frames = []
        if self._address.interface == "socketcan":
            with self._file.open("wb") as out:
                self._candump = subprocess.Popen(
                    ["candump", "-L", "-r", RECEIVE_BUFFER, self._address.channel], stdout=out
                )
            self._wait_for_a_frame()
        else:
            self._bus = bus.open_bus(self._address)
            widen(self._bus)
            self._notifier = can.Notifier(self._bus, [self._take], timeout=0.1)
        return self

    def _wait_for_a_frame(self) -> None:
        """A guest takes its time to start a program; a drive sends every few milliseconds."""
        deadline_s = time.monotonic() + STARTING_S
        while self._file.stat().st_size == 0 and time.monotonic() < deadline_s:
            time.sleep(0.01)

    def _take(self, message: can.Message) -> None:
        self._frames.append(RawFrame(message.arbitration_id, bytes(message.data)))

    def _stop(self) -> None:
        if self._candump is not None:
            self._candump.terminate()
            self._candump.wait()
            self._frames = parse_candump(self._file.read_text(encoding="ascii"))
            self._candump = None
        if self._notifier is not None:
            self._notifier.stop()
            self._bus.shutdown()
            self._notifier = None

    def frames(self) -> list[RawFrame]:
        """Stops listening; what has come."""
        self._stop()
        return self._frames

    def __exit__(self, *_: object) -> None:
        self._stop()


def widen(opened: can.BusABC) -> None:
    """Room in the kernel for what comes while the listener is kept from running."""
    receiver = socket.socket(fileno=os.dup(opened.fileno()))
    with receiver:
        try:
            receiver.setsockopt(socket.SOL_SOCKET, SO_RCVBUFFORCE, int(RECEIVE_BUFFER))
        except PermissionError:
            receiver.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, int(RECEIVE_BUFFER))


def parse_candump(text: str) -> list[RawFrame]:
    """Frames of candump's log format, "(1700000000.123456) vcan0 123#DEADBEEF"."""
    found = re.findall(r"^\(\d+\.\d+\) \S+ ([0-9A-F]{3})#([0-9A-F]*)", text, re.MULTILINE)
    return [RawFrame(int(frame_id, 16), bytes.fromhex(data)) for frame_id, data in found]
