"""A network between plant and drive that loses, delays and swaps datagrams, by a seed: datagram_relay.py --help.

It begins as a sound one. SIGUSR1 makes it lossy, the next SIGUSR1 sound again, so that both sides are there to count
what it does. SIGUSR2 cuts the way from the drive to the plant, and that alone; the next mends it. SIGTERM ends it with
its counts.
"""

import argparse
import heapq
import json
import os
import random
import select
import signal
import socket
import sys
import time

PRIORITY = 15  # below plant and drive, above all else
RECEIVE_BUFFER = 4_000_000  # bytes: what came while it stood still is not lost
SO_RCVBUFFORCE = 33
WAIT_S = 0.0005


def address(text: str) -> tuple[str, int]:
    host, _, port = text.rpartition(":")
    return host, int(port)


class Way:
    """From one side to the other."""

    def __init__(self, arguments: argparse.Namespace, seed: int, out: socket.socket, target: tuple[str, int]) -> None:
        self._random = random.Random(seed)
        self._arguments = arguments
        self._out = out
        self._target = target
        self._waiting: list[tuple[float, int, bytes]] = []
        self.is_lossy = False
        self.is_cut = False
        self._passed = 0  # the newest datagram that has been sent on, by its number
        self.counts = {"came": 0, "dropped": 0, "delayed": 0, "overtaken": 0, "unsent": 0}

    def take(self, datagram: bytes, now: float) -> None:
        self.counts["came"] += 1
        if self.is_cut:
            self.counts["dropped"] += 1
        elif not self.is_lossy:
            self._send(self.counts["came"], datagram)
        elif self._random.random() < self._arguments.loss:
            self.counts["dropped"] += 1
        elif self._random.random() < self._arguments.delayed:
            self.counts["delayed"] += 1
            heapq.heappush(self._waiting, (now + self._arguments.delay_ms * 1e-3, self.counts["came"], datagram))
        else:
            self._send(self.counts["came"], datagram)

    def send_due(self, now: float) -> None:
        while self._waiting and self._waiting[0][0] <= now:
            self._send(*heapq.heappop(self._waiting)[1:])

    def _send(self, number: int, datagram: bytes) -> None:
        self.counts["overtaken"] += number < self._passed
        self._passed = max(self._passed, number)
        try:
            self._out.sendto(datagram, self._target)
        except OSError:  # a wire that is cut, a side that is not there
            self.counts["unsent"] += 1


def listening(at: str) -> socket.socket:
    found = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        found.setsockopt(socket.SOL_SOCKET, SO_RCVBUFFORCE, RECEIVE_BUFFER)
    except PermissionError:
        found.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER)
    found.bind(address(at))
    return found


def ask_for_priority() -> None:
    try:
        os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(PRIORITY))
    except PermissionError:
        print("datagram_relay: no right to real-time scheduling here", file=sys.stderr)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--drive-side", required=True, help="own address:port that the drive has as its peer")
    parser.add_argument("--drive", required=True, help="address:port at which the drive listens")
    parser.add_argument("--plant-side", required=True)
    parser.add_argument("--plant", required=True)
    parser.add_argument("--loss", type=float, default=0.0, help="share of datagrams that are dropped")
    parser.add_argument("--delayed", type=float, default=0.0, help="share of datagrams that are delayed")
    parser.add_argument("--delay-ms", type=float, default=2.0)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    ask_for_priority()
    to_drive = listening(arguments.drive_side)
    to_plant = listening(arguments.plant_side)
    ways = {
        to_plant: Way(arguments, arguments.seed, to_drive, address(arguments.drive)),
        to_drive: Way(arguments, arguments.seed + 1, to_plant, address(arguments.plant)),
    }
    ended = []
    signal.signal(signal.SIGTERM, lambda *_: ended.append(True))

    def change(*_: object) -> None:
        for way in ways.values():
            way.is_lossy = not way.is_lossy

    def cut_or_mend(*_: object) -> None:
        ways[to_drive].is_cut = not ways[to_drive].is_cut

    signal.signal(signal.SIGUSR1, change)
    signal.signal(signal.SIGUSR2, cut_or_mend)
    print("ready", flush=True)
    while not ended:
        ready, _, _ = select.select(list(ways), [], [], WAIT_S)
        for one in ready:
            ways[one].take(one.recv(2048), time.monotonic())
        for way in ways.values():
            way.send_due(time.monotonic())
    print(json.dumps({"measurements": ways[to_plant].counts, "commands": ways[to_drive].counts}))


if __name__ == "__main__":
    sys.exit(main())
