"""Plays a recording: its telemetry over DDS and its CAN frames over a bus, at the times at which they were recorded."""

import argparse
import sys
import time
from pathlib import Path
from typing import Any

import can
import numpy as np
from cyclonedds.pub import DataWriter
from cyclonedds.topic import Topic

from . import bus as can_bus
from . import dds, telemetry_types
from .errors import EndedError, UserError, run
from .program_arguments import parser_of
from .recording import formats, topics
from .recording.can_frames import CAN, frame_of
from .recording.model import MAIN, Source
from .recording.progress import Progress
from .recording.timeline import Item, begin_ns, items
from .recording.topics import TOPICS, WAVEFORM

STREAMS = (MAIN, WAVEFORM, CAN)  # groups that begin with the recording; the others hold what was latched before
POLL_S = 0.01
EXAMPLES = """examples:
  playback run.h5                                        then scripts/monitor in another terminal
  playback run.mcap --speed 0.1 --loop --domain 5
  playback run.mcap --can socketcan:vcan0                the frames as well; candump vcan0 shows them

A played command is a command: no live drive may be on the bus of --can or use the drive's id in the domain.
"""


class Player:
    def __init__(self, source: Source, domain: int, drive_id: int | None, bus: can.BusABC | None) -> None:
        self._source = source
        self._drive_id = drive_id
        self._bus = bus
        self.node = dds.Node(domain)
        self.names = [name for name in source.groups if name in TOPICS or (name == CAN and bus is not None)]
        self._types = {name: telemetry_types.struct(topics.struct_of(name)) for name in self.names if name != CAN}
        self._writers = {name: self._writer(name) for name in self._types}
        self.played = dict.fromkeys(self.names, 0)
        self._spans: dict[str, tuple[int, int]] = {}  # first and last sequence number of the first pass
        self._last_ns = 0

    def _writer(self, name: str) -> DataWriter:
        participant = self.node.participant
        quality = dds.streaming_qos(1) if name in (MAIN, WAVEFORM) else dds.latched_qos()
        return DataWriter(participant, Topic(participant, TOPICS[name], self._types[name]), quality)

    def wait_for_readers(self, seconds: float) -> None:
        """Returns when each topic has a reader, or after that time."""
        end_s = time.monotonic() + seconds
        while time.monotonic() < end_s and not all(w.get_matched_subscriptions() for w in self._writers.values()):
            time.sleep(POLL_S)

    def play(self, speed: float, number: int, progress: Progress) -> None:
        """One pass, the first has the number 0. Later ones go on with times and sequence numbers."""
        filled = [name for name in self.names if self._source.rows(name)]
        first_ns = begin_ns(self._source, [name for name in filled if name in STREAMS] or filled)
        shift_ns = number * (self._last_ns - first_ns + 1_000_000)
        begin_s = time.monotonic()
        for item in items(self._source, self.names):
            due_s = begin_s + (item.t_ns - first_ns) / 1e9 / speed
            if (wait_s := due_s - time.monotonic()) > 0:
                time.sleep(wait_s)
            self._publish(item, number, shift_ns)
            progress.show(f"{max(item.t_ns - first_ns, 0) / 1e9:.1f} s played")
            self._last_ns = max(self._last_ns, item.t_ns)

    def _publish(self, item: Item, number: int, shift_ns: int) -> None:
        self.played[item.group] += 1
        if item.group == CAN:
            self._bus.send(frame_of(item.rows))
            return
        sample = topics.sample_of(item.group, item.rows, self._types[item.group])
        self._writers[item.group].write(self._moved(sample, item.group, number, shift_ns))

    def _moved(self, sample: Any, name: str, number: int, shift_ns: int) -> Any:
        """As the recording has it in the first pass; later passes go on where it ended."""
        if self._drive_id is not None:
            sample.drive_id = self._drive_id
        if number == 0:
            first, last = self._spans.get(name, (sample.sequence, sample.sequence))
            self._spans[name] = min(first, sample.sequence), max(last, sample.sequence)
        first, last = self._spans[name]
        sample.sequence += number * (last - first + 1)
        sample.t_ns += shift_ns
        return sample


def parse_arguments(arguments: list[str]) -> argparse.Namespace:
    parser = parser_of(
        "playback",
        "Plays a recording over DDS, for monitor, dashboard and record, and with --can its frames over a CAN bus.",
        EXAMPLES,
    )
    parser.add_argument("file", type=Path, metavar="FILE", help=f"recording ({', '.join(formats.SUFFIXES)})")
    parser.add_argument("--domain", type=int, default=0, help="DDS domain (default: 0)")
    parser.add_argument("--drive", type=int, metavar="ID", help="publish as this drive (default: the recorded id)")
    parser.add_argument("--speed", type=float, default=1.0, help="times as fast as recorded (default: 1)")
    parser.add_argument("--loop", action="store_true", help="begin again at the end, until Ctrl-C")
    parser.add_argument("--can", metavar="ADDRESS", help=f"send the CAN frames on this bus: {can_bus.ADDRESS_FORMS}")
    parser.add_argument(
        "--wait", type=float, default=2.0, metavar="S", help="wait so long for readers of all topics (default: 2)"
    )
    return parser.parse_args(arguments)


def check(source: Source, options: argparse.Namespace) -> None:
    if not options.speed > 0 or not np.isfinite(options.speed):
        raise UserError("--speed must be a number above 0.")
    if not options.wait >= 0:
        raise UserError("--wait must be a number from 0.")
    if options.can and CAN not in source.groups:
        raise UserError(f"{options.file} holds no CAN frames; scripts/record --can records them.")
    if not any(name in TOPICS for name in source.groups) and not options.can:
        raise UserError(f"{options.file} holds no telemetry; it has {', '.join(source.groups)}.")
    played = [name for name in source.groups if name in TOPICS or (name == CAN and options.can)]
    if not any(source.rows(name) for name in played):
        reason = source.cut or f"{options.file} has no rows of {', '.join(played)}"
        raise UserError(f"{reason}; nothing can be played.")


def main(arguments: list[str]) -> int:
    options = parse_arguments(arguments)
    source = formats.open_source(options.file)
    check(source, options)
    if source.unverified:
        print(f"playback: {source.unverified}", file=sys.stderr)
    bus = can_bus.open_bus(can_bus.parse(options.can)) if options.can else None
    progress = Progress()
    try:
        player = Player(source, options.domain, options.drive, bus)
        player.wait_for_readers(options.wait)
        number = 0
        while number == 0 or options.loop:
            player.play(options.speed, number, progress)
            number += 1
    except can.CanError as error:
        raise EndedError(f"a frame cannot be sent on {options.can}: {error}.") from None
    finally:
        progress.end()
        if bus:
            bus.shutdown()
    print(f"{options.file}: {', '.join(f'{count} of {name}' for name, count in player.played.items())} played")
    if source.cut:
        raise EndedError(f"{source.cut}. They were played.")
    return 0


if __name__ == "__main__":
    run("playback", main)
