"""The process that puts the vehicle's frames on the bus: every 10 ms, on an absolute schedule.

It is a process of its own, with the standard library alone, so that nothing a test computes delays a frame. Frames come
ready from vehicle.py, as the bytes that its socket takes. Arguments: descriptor of the control socket, kind of bus,
channel, port. The control socket carries one JSON object a packet:
  {"demand": [15 frames]}   from now on the frame of the counter, every period; null: silence
  {"extra": [15 frames]}    once, right after the next command; answered by {"extra": counter}
  {"end": true}             answered by {"sent": …, "unsent": …, "missed": …, "apart_ms": …}, then the process ends
"""

import gc
import json
import os
import socket
import sys
import time

PERIOD_NS = 10_000_000
COUNTER_COUNT = 15
PRIORITY = 20  # below the drive's control thread, above all else


class MulticastSocket:
    """Not connected: a connected socket sends by the interface of its source address, not by the route of the group."""

    def __init__(self, group: str, port: int) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._group = (group, port)

    def send(self, frame: bytes) -> None:
        self._socket.sendto(frame, self._group)


def open_bus(kind: str, channel: str, port: int) -> socket.socket | MulticastSocket:
    if kind != "socketcan":
        return MulticastSocket(channel, port)
    out = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
    out.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_FD_FRAMES, 1)
    out.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_FILTER, b"")
    out.bind((channel,))
    return out


class Sender:
    def __init__(self, control: socket.socket, out: socket.socket | MulticastSocket) -> None:
        self._control = control
        self._out = out
        self._demand: list[bytes] | None = None
        self._extra: list[bytes] | None = None
        self._counter = 0
        self._last_ns = 0
        self._log = {"sent": 0, "unsent": 0, "missed": 0, "apart_ms": 0.0}

    def run(self) -> None:
        due_ns = time.monotonic_ns()
        while self._obey():
            due_ns += PERIOD_NS
            missed = max(time.monotonic_ns() - due_ns, 0) // PERIOD_NS
            due_ns += missed * PERIOD_NS
            time.sleep(max(due_ns - time.monotonic_ns(), 0) / 1e9)
            if self._demand is not None:
                self._log["missed"] += missed
                self._send(self._demand)

    def _obey(self) -> bool:
        """Takes orders; False once the vehicle has ended, or whoever started it is gone."""
        while True:
            try:
                packet = self._control.recv(65536)
            except BlockingIOError:
                return True
            order = json.loads(packet) if packet else {}
            if not packet or "end" in order:
                if packet:
                    self._control.send(json.dumps(self._log).encode())
                return False
            if "extra" in order:
                self._extra = [bytes.fromhex(frame) for frame in order["extra"]]
            else:
                frames = order["demand"]
                self._demand = None if frames is None else [bytes.fromhex(frame) for frame in frames]
                self._last_ns = 0 if frames is None else self._last_ns

    def _send(self, frames: list[bytes]) -> None:
        counter, self._counter = self._counter, (self._counter + 1) % COUNTER_COUNT
        try:
            self._out.send(frames[counter])
        except OSError:
            self._log["unsent"] += 1
            self._last_ns = 0
            return
        now_ns = time.monotonic_ns()
        if self._last_ns:
            self._log["apart_ms"] = max(self._log["apart_ms"], (now_ns - self._last_ns) * 1e-6)
        self._last_ns = now_ns
        self._log["sent"] += 1
        if self._extra is not None:
            self._out.send(self._extra[counter])
            self._extra = None
            self._control.send(json.dumps({"extra": counter}).encode())


def main() -> None:
    descriptor, kind, channel, port = sys.argv[1:]
    try:
        os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(PRIORITY))
    except PermissionError:
        print("vehicle: no right to real-time scheduling here", file=sys.stderr)
    control = socket.socket(fileno=int(descriptor))
    control.setblocking(False)
    gc.disable()
    Sender(control, open_bus(kind, channel, int(port))).run()


main()
