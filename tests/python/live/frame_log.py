"""Raw frames of a bus with their arrival times: by candump on SocketCAN, by python-can on UDP multicast."""

import re
import subprocess
import time
from dataclasses import dataclass, field

import can
from sextant_py import bus


@dataclass(frozen=True)
class RawFrame:
    time_s: float
    frame_id: int
    data: bytes


@dataclass
class FrameLog:
    """Listens for the time of a `with`; then `frames` holds what came."""

    address: str
    frames: list[RawFrame] = field(default_factory=list)
    _candump: subprocess.Popen | None = None
    _notifier: can.Notifier | None = None
    _bus: can.BusABC | None = None

    def __enter__(self) -> "FrameLog":
        parsed = bus.parse(self.address)
        if parsed.interface == "socketcan":
            self._candump = subprocess.Popen(["candump", "-L", parsed.channel], stdout=subprocess.PIPE, text=True)
            time.sleep(0.2)
        else:
            self._bus = bus.open_bus(parsed)
            self._notifier = can.Notifier(self._bus, [self._take], timeout=0.1)
        return self

    def _take(self, message: can.Message) -> None:
        self.frames.append(RawFrame(message.timestamp, message.arbitration_id, bytes(message.data)))

    def __exit__(self, *_: object) -> None:
        if self._candump is not None:
            self._candump.terminate()
            self.frames = parse_candump(self._candump.communicate()[0])
        else:
            self._notifier.stop()
            self._bus.shutdown()


def parse_candump(text: str) -> list[RawFrame]:
    """Frames of candump's log format, "(1700000000.123456) vcan0 123#DEADBEEF"."""
    found = re.findall(r"^\((\d+\.\d+)\) \S+ ([0-9A-F]{3})#([0-9A-F]*)", text, re.MULTILINE)
    return [RawFrame(float(when), int(frame_id, 16), bytes.fromhex(data)) for when, frame_id, data in found]
