"""Waits for a trigger on the drive's waveform and writes the control periods around it to a file."""

import argparse
import signal
import sys
import time
from pathlib import Path

import numpy as np

from ..errors import EndedError, UserError
from ..program_arguments import parser_of, positive_seconds
from ..recording import formats
from ..recording.live import LiveDrive
from ..recording.topics import STATE, WAVEFORM
from . import files, quantities
from .capture import Capture
from .scope import MODES, Scope, Settings
from .trigger_text import FORMS

POLL_S = 0.02
TIMEOUT_S = 5.0  # without a row, after which the reason is reported
MOST_STATES = 1000
OUT = f"file in the format of its suffix: {', '.join(formats.SUFFIXES)} (default: capture.h5)"

EXAMPLES = """examples:
  scope --out capture.h5                                 the next fault, 20 ms before to 50 ms after
  scope --trigger 'rise current_a 30 1' --after 5        the current rises through 30 A, hysteresis 1 A
  scope --trigger 'state TORQUE' --mode normal --count 3 three captures: capture_001.h5 …
  scope --trigger 'step 5' --before 5 --after 20 --out step.mcap
"""


def forms() -> str:
    width = max(map(len, FORMS))
    return "triggers:\n" + "\n".join(f"  {form:<{width}}  {what}" for form, what in FORMS.items())


def parse_arguments(arguments: list[str]) -> argparse.Namespace:
    parser = parser_of(
        "scope",
        "Waits for a trigger on the waveform of a drive (every control period, by DDS) and writes the"
        " control periods before and after it to a file. An existing file is replaced.",
        f"{forms()}\n\n{EXAMPLES}",
    )
    parser.add_argument("--trigger", default="fault", metavar="TEXT", help="what to wait for (default: fault)")
    parser.add_argument("--out", type=Path, default=Path("capture.h5"), metavar="FILE", help=OUT)
    parser.add_argument("--mode", choices=MODES, default="single", help="default: single")
    parser.add_argument("--count", type=int, metavar="N", help="captures, then end (default: 1 with single)")
    parser.add_argument("--before", type=float, default=20.0, metavar="MS", help="before the trigger (default: 20)")
    parser.add_argument("--after", type=float, default=50.0, metavar="MS", help="after the trigger (default: 50)")
    parser.add_argument("--hold-off", type=float, default=0.0, metavar="MS", help="between triggers (default: 0)")
    parser.add_argument("--auto-after", type=float, default=500.0, metavar="MS", help="mode auto (default: 500)")
    timeout = "end without a trigger after so long, status 1"
    parser.add_argument("--timeout", type=positive_seconds, metavar="S", help=timeout)
    parser.add_argument("--domain", type=int, default=0, help="DDS domain (default: 0)")
    parser.add_argument("--drive", type=int, metavar="ID", help="drive (default: the first one received)")
    parser.add_argument("--list", action="store_true", help="list the signals that a trigger can evaluate, and end")
    return parser.parse_args(arguments)


def settings_of(options: argparse.Namespace) -> Settings:
    times = (options.before, options.after, options.hold_off, options.auto_after)
    settings = Settings(options.trigger, options.mode, *(value * 1e-3 for value in times))
    settings.check()
    formats.check(options.out)
    if options.count is not None and options.count < 1:
        raise UserError("--count must be 1 or more.")
    return settings


class Watch:
    def __init__(self, options: argparse.Namespace) -> None:
        self._scope = Scope(settings_of(options))
        self._count = options.count or (1 if options.mode == "single" else None)
        self._several = self._count != 1
        self._out = options.out
        self._live = LiveDrive(options.domain, options.drive, waveform=True, can=None)
        self._states: list[np.ndarray] = []
        self._received_s = time.monotonic()
        self.rows = 0
        self.written = 0

    @property
    def done(self) -> bool:
        return self._count is not None and self.written >= self._count

    def poll(self) -> None:
        for group, rows in self._live.poll():
            if group.name == STATE:
                self._states = [*self._states[-MOST_STATES:], rows]
            elif group.name == WAVEFORM:
                self._take(rows)
        self._report_timeout()

    def _take(self, rows: np.ndarray) -> None:
        if not self.rows:
            print(f"scope: drive {self._live.drive_id}, waiting for: {self._scope.settings.trigger}", flush=True)
        self.rows += len(rows)
        self._received_s = time.monotonic()
        for capture in self._scope.take(rows):
            if not self.done:
                self._write(capture)
            if self._scope.state == "stopped" and not self.done:
                self._scope.arm()

    def _write(self, capture: Capture) -> None:
        path = files.numbered(self._out, self.written + 1, self._several)
        states = np.concatenate(self._states) if self._states else None
        files.write(path, capture, self._live.drive_id, states)
        self.written += 1
        times = capture.times_s * 1e3
        missing = f", {capture.periods_missing} missing" if capture.periods_missing else ""
        print(
            f"{path}: {len(capture.rows)} control periods{missing}, {abs(times[0]):.3f} ms before to {times[-1]:.3f} ms"
            f" after the trigger ({capture.trigger})",
            flush=True,
        )

    def _report_timeout(self) -> None:
        if time.monotonic() - self._received_s < TIMEOUT_S:
            return
        self._received_s = time.monotonic()
        print(f"scope: no waveform for {TIMEOUT_S:g} s: {self.reason()}", file=sys.stderr, flush=True)

    def reason(self) -> str:
        """Why no waveform comes, in a sentence."""
        if self.rows:
            return f"drive {self._live.drive_id} sends none any more; is it still running?"
        nothing = f"no waveform of drive {self._live.drive_id} arrived in domain {self._live.node.domain}."
        return " ".join(self._live.problems()) or nothing

    def close(self) -> None:
        self._live.close()


def print_signals() -> None:
    for name, (unit, text) in quantities.known().items():
        print(f"  {name:<22} {unit:<6} {text}")


def main(arguments: list[str]) -> int:
    options = parse_arguments(arguments)
    if options.list:
        print_signals()
        return 0
    watch = Watch(options)
    stopped: list[int] = []
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda *_: stopped.append(1))
    end_s = time.monotonic() + (options.timeout or float("inf"))
    try:
        while not watch.done and not stopped and time.monotonic() < end_s:
            watch.poll()
            time.sleep(POLL_S)
    finally:
        watch.close()
    if not watch.written:
        why = "ended before the trigger" if stopped else f"no trigger within {options.timeout:g} s"
        reason = "" if watch.rows else f" {watch.reason()}"
        raise EndedError(f"{why} ({options.trigger}): nothing was written.{reason}")
    return 0
