"""A network between plant and drive that loses, delays and swaps datagrams, by a seed: datagram_relay.py --help.

SIGUSR1 cuts the way from the drive to the plant, and that alone; SIGUSR2 mends it.
"""

import argparse
import heapq
import json
import random
import select
import signal
import socket
import sys
import time


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
        self.is_cut = False
        self.counts = {"came": 0, "dropped": 0, "delayed": 0}

    def take(self, datagram: bytes, now: float) -> None:
        self.counts["came"] += 1
        if self.is_cut or self._random.random() < self._arguments.loss:
            self.counts["dropped"] += 1
        elif self._random.random() < self._arguments.delayed:
            self.counts["delayed"] += 1
            heapq.heappush(self._waiting, (now + self._arguments.delay_ms * 1e-3, self.counts["came"], datagram))
        else:
            self._out.sendto(datagram, self._target)

    def send_due(self, now: float) -> None:
        while self._waiting and self._waiting[0][0] <= now:
            self._out.sendto(heapq.heappop(self._waiting)[2], self._target)


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
    to_drive = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    to_drive.bind(address(arguments.drive_side))
    to_plant = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    to_plant.bind(address(arguments.plant_side))
    ways = {
        to_plant: Way(arguments, arguments.seed, to_drive, address(arguments.drive)),
        to_drive: Way(arguments, arguments.seed + 1, to_plant, address(arguments.plant)),
    }

    def cut(signal_number: int, _: object) -> None:
        ways[to_drive].is_cut = signal_number == signal.SIGUSR1

    signal.signal(signal.SIGUSR1, cut)
    signal.signal(signal.SIGUSR2, cut)
    ended = []
    signal.signal(signal.SIGTERM, lambda *_: ended.append(True))
    print("ready", flush=True)
    while not ended:
        ready, _, _ = select.select(list(ways), [], [], 0.0005)
        for one in ready:
            ways[one].take(one.recv(2048), time.monotonic())
        for way in ways.values():
            way.send_due(time.monotonic())
    print(json.dumps({"measurements": ways[to_plant].counts, "commands": ways[to_drive].counts}))


if __name__ == "__main__":
    sys.exit(main())
