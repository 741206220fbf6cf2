"""Records a drive's telemetry, state, control periods and CAN frames, every one of them, to one file."""

import argparse
import signal
import sys
import time
from pathlib import Path

from . import bus as can_bus
from .errors import EndedError, UserError, run
from .program_arguments import parser_of, positive_seconds
from .recording import formats
from .recording.can_frames import CanReader
from .recording.live import LiveDrive
from .recording.model import MAIN
from .recording.progress import Progress
from .recording.recorder import Recorder
from .recording.topics import TOPICS, WAVEFORM

POLL_S = 0.05
PATIENCE_S = 5.0  # without a sample, after which the reason is reported
EXAMPLES = """examples:
  record run.h5                                     until Ctrl-C; scripts/plot run.h5 draws it
  record run.mcap --waveform --duration 60          also every control period; Foxglove and PlotJuggler open it
  record run.mf4 --can udp_multicast:239.74.163.2   with the frames of the CAN bus; CANape and MDA open it
"""


def parse_arguments(arguments: list[str]) -> argparse.Namespace:
    parser = parser_of(
        "record",
        "Records telemetry, states and statistics of one drive until Ctrl-C, SIGTERM or the end of --duration.",
        EXAMPLES,
    )
    suffixes = ", ".join(formats.SUFFIXES)
    parser.add_argument(
        "file", type=Path, metavar="FILE", help=f"recording to write ({suffixes}); an existing file is replaced"
    )
    parser.add_argument("--waveform", action="store_true", help=f"also every control period ({TOPICS[WAVEFORM]})")
    parser.add_argument("--can", metavar="ADDRESS", help=f"also the frames of a CAN bus: {can_bus.ADDRESS_FORMS}")
    parser.add_argument(
        "--identifier-offset", type=int, metavar="N", help="of the drive on that bus (default: of configs/ecu.toml)"
    )
    parser.add_argument("--domain", type=int, default=0, help="DDS domain (default: 0)")
    parser.add_argument("--drive", type=int, metavar="ID", help="drive to record (default: the first one received)")
    parser.add_argument("--duration", type=positive_seconds, metavar="S", help="end after so long")
    return parser.parse_args(arguments)


def open_recorder(options: argparse.Namespace) -> Recorder:
    formats.check(options.file)
    about, can = {"program": "record", "waveform": options.waveform}, None
    if options.can:
        offset = options.identifier_offset
        offset = can_bus.default_identifier_offset() if offset is None else offset
        about |= {"can": options.can, "identifier_offset": offset}
        can = CanReader(options.can, offset)
    try:
        return Recorder(options.file, LiveDrive(options.domain, options.drive, options.waveform, can), about)
    except UserError:
        if can:
            can.close()
        raise


def reason(recorder: Recorder) -> str:
    """Why no sample has arrived."""
    return " ".join(recorder.rows.problems()) or "no sample of that drive arrived."


def follow(recorder: Recorder, end_s: float) -> None:
    """Records until a signal or the end."""
    stopped = False

    def stop(_number: int, _frame: object) -> None:
        nonlocal stopped
        stopped = True

    signal.signal(signal.SIGTERM, stop)
    signal.signal(signal.SIGINT, stop)
    progress, begin_s, reported, gaps = Progress(), time.monotonic(), False, 0
    while not stopped and time.monotonic() < end_s:
        recorder.poll()
        if not (reported or recorder.count) and time.monotonic() - begin_s > PATIENCE_S:
            reported = True
            progress.end()
            print(f"record: no sample for {PATIENCE_S:g} s: {reason(recorder)}", file=sys.stderr, flush=True)
        for gap in recorder.rows.gaps()[gaps:]:
            gaps += 1
            progress.end()
            print(f"record: the CAN bus cannot be read until it is back: {gap.reason}", file=sys.stderr, flush=True)
        progress.show(f"{time.monotonic() - begin_s:.0f} s, {recorder.count} samples")
        time.sleep(POLL_S)
    recorder.poll()
    progress.end()


def report(recorder: Recorder, options: argparse.Namespace) -> None:
    losses = recorder.losses
    print(f"{options.file}: {recorder.count} samples, {losses.sentence(MAIN)}")
    if WAVEFORM in losses.of:
        print(f"  waveform: {losses.of[WAVEFORM].rows} control periods, {losses.sentence(WAVEFORM)}")
    if options.can:
        frames = losses.of["can"].rows if "can" in losses.of else 0
        lost = sum(of.lost for name, of in losses.of.items() if name.startswith("can/"))
        print(f"  can: {frames} frames, {lost} missing by their counters")
        for gap in recorder.rows.gaps():
            away = f"for {(gap.end_ns - gap.begin_ns) / 1e9:.1f} s" if gap.end_ns else "to the end"
            print(f"  can: the bus could not be read {away}: {gap.reason}")


def main(arguments: list[str]) -> int:
    options = parse_arguments(arguments)
    with open_recorder(options) as recorder:
        follow(recorder, time.monotonic() + (options.duration or float("inf")))
        why = reason(recorder)
        if not recorder.losses.of:
            raise EndedError(why)
    progress = Progress()
    recorder.convert(lambda share: progress.show(f"{options.file}: {share:.0%} written"))
    progress.end()
    report(recorder, options)
    if not recorder.count:
        raise EndedError(why)
    if options.waveform and WAVEFORM not in recorder.losses.of:
        raise EndedError(
            recorder.rows.subscriptions[WAVEFORM].diagnosis() or "no control periods of that drive arrived."
        )
    return 0


if __name__ == "__main__":
    run("record", main)
