"""The vehicle control unit: plays a torque profile to a drive over CAN.

It sends disable frames until the drive reports that it is ready, enables it, plays the profile on an absolute schedule
with counter and CRC, listens to what the drive reports, and ends with disable frames, on Ctrl-C as well.
"""

import argparse
import json
import sys
import time
from pathlib import Path

import cantools

from . import profile
from .commander import COMMAND
from .contract import Contract
from .control_unit import Vcu
from .errors import EndedError, UserError, run
from .program_arguments import parser_of
from .reports import FOLLOWING_STATES, RUNNING_STATES, STATUS, Reports
from .tracking import Tracking

LOG_FIELDS = ("t_ns", "torque_nm", "enable", "counter")

EXAMPLES = """examples:
  scripts/vcu --profile configs/profiles/demo.csv
  scripts/vcu --can socketcan:vcan0 --profile configs/profiles/demo.csv --log out/commands.json
  scripts/vcu --profile configs/profiles/demo.csv --no-handshake   # the drive must stay locked out
"""


class Progress:
    """One line that renews itself on a terminal, a line a second elsewhere."""

    def __init__(self, quiet: bool) -> None:
        self._quiet = quiet
        self._terminal = sys.stdout.isatty()
        self._due_s = 0.0
        self._open = False

    def show(self, text: str) -> None:
        now = time.monotonic()
        if self._quiet or now < self._due_s:
            return
        self._due_s = now + (0.1 if self._terminal else 1.0)
        if self._terminal:
            print(f"\r\033[K{text}", end="", flush=True)
            self._open = True
        else:
            print(text, flush=True)

    def say(self, text: str) -> None:
        if self._quiet:
            return
        print(("\n" if self._open else "") + text, flush=True)
        self._open = False


def describe(reports: Reports) -> str:
    status, motion = reports.latest.get(STATUS), reports.latest.get("MCU_Motion")
    parts = [str(reports.state() or "no status")]
    if status:
        parts.append(f"torque {status['TorqueEstimated']:+7.2f} N·m")
    if motion:
        parts.append(f"speed {motion['Speed']:+7.1f} rpm")
    return ", ".join(parts)


def compare(tracking: Tracking, reports: Reports, time_s: float, torque_nm: float, enable: bool) -> str:
    """Adds estimated and requested torque to the tracking; the warning to show, empty without one."""
    status = reports.latest.get(STATUS)
    if status is None or not enable or reports.state() not in FOLLOWING_STATES:
        tracking.pause()
        return ""
    tracking.add(time_s, torque_nm, float(status["TorqueEstimated"]))
    off_nm = tracking.deviation_nm
    return f"  NOT FOLLOWING: {off_nm:+.1f} N·m beside the request" if off_nm else ""


def play(
    vcu: Vcu, torque: profile.Profile, progress: Progress, tracking: Tracking, watch: bool
) -> tuple[int, str | None]:
    """Plays the profile. Returns when it began [ns] and, where it had to end early, why."""
    reports = vcu.reports
    start_ns = vcu.wait()
    due_ns = start_ns
    was_running = False
    while (time_s := (due_ns - start_ns) / 1e9) <= torque.duration_s:
        torque_nm, enable = torque.at(time_s)
        vcu.send(torque_nm, enable)
        off = compare(tracking, reports, time_s, torque_nm, enable)
        progress.show(f"{time_s:6.2f} s  request {torque_nm:+7.2f} N·m  drive: {describe(reports)}{off}")
        if watch:
            if other := reports.other_contract():
                return start_ns, other
            was_running = was_running or vcu.state in RUNNING_STATES
            if not vcu.is_there:
                return start_ns, f"the drive's status frames timed out {time_s:.2f} s into the profile."
            if was_running and vcu.state == "FAULT":
                return start_ns, f"the drive went to FAULT ({reports.first_fault()}) {time_s:.2f} s into the profile."
        due_ns = vcu.wait()
    if watch and not was_running and any(point.enable for point in torque.points):
        return start_ns, f"the drive never produced torque; it reports {vcu.state}."
    return start_ns, None


def write_log(path: Path, start_ns: int | None, vcu: Vcu) -> None:
    """Commands with the monotonic time at which each left [ns]."""
    commands = [dict(zip(LOG_FIELDS, row, strict=True)) for row in vcu.sent]
    log = {
        "bus": vcu.address,
        "period_ms": vcu.period_s * 1e3,
        "profile_start_ns": start_ns,
        "missed_periods": vcu.missed,
        "unsent_frames": vcu.unsent,
        "commands": commands,
    }
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(log, indent=1) + "\n", encoding="utf-8")
    except OSError as error:
        raise UserError(f"the log {path} cannot be written: {error.strerror}.") from None


def parse_arguments(arguments: list[str]) -> argparse.Namespace:
    parser = parser_of("vcu", "Plays a torque profile to a drive over CAN, as a vehicle control unit does.", EXAMPLES)
    parser.add_argument("--can", metavar="BUS", help="default: the bus that configs/ecu.toml names")
    offset = "the drive's can.identifier_offset; default: that of configs/ecu.toml"
    parser.add_argument("--identifier-offset", type=int, metavar="N", help=offset)
    parser.add_argument("--profile", required=True, metavar="FILE", help="torque profile, .csv or .toml")
    parser.add_argument("--interpolation", choices=profile.INTERPOLATIONS, help="instead of the profile's own")
    parser.add_argument("--rate", type=float, default=100.0, metavar="HZ", help="frames a second (default: 100)")
    parser.add_argument("--torque-limit", type=float, metavar="NM", help="limit sent with each command")
    parser.add_argument("--timeout", type=float, default=10.0, metavar="S", help="wait for the drive (default: 10)")
    parser.add_argument("--reset-faults", action="store_true", help="ask a drive in FAULT to clear its faults")
    parser.add_argument("--no-handshake", action="store_true", help="enable from the first frame, whatever comes back")
    parser.add_argument("--log", type=Path, metavar="FILE", help="write the commands sent, with times, as JSON")
    parser.add_argument("--quiet", action="store_true", help="print nothing but errors")
    return parser.parse_args(arguments)


def shake_hands(vcu: Vcu, progress: Progress, timeout_s: float, reset: bool) -> None:
    """Disable frames until the drive is ready for an enable."""

    def show() -> None:
        progress.show(f"disable: waiting for the drive ({describe(vcu.reports)})")

    vcu.make_ready(timeout_s, reset, show)
    progress.say(f"the drive is ready ({describe(vcu.reports)})")


def load(options: argparse.Namespace) -> profile.Profile:
    """The profile, within the contract's range of torque."""
    torque = profile.load(options.profile, options.interpolation)
    smallest_nm, largest_nm = Contract().limits(COMMAND, "TorqueRequest")
    if not all(smallest_nm <= point.torque_nm <= largest_nm for point in torque.points):
        raise UserError(
            f"the profile {options.profile} leaves the contract's range of torque,"
            f" {smallest_nm:g} to {largest_nm:g} N·m."
        )
    if not 1 <= options.rate <= 1000:
        raise UserError("--rate must be between 1 and 1000 Hz.")
    return torque


def main(arguments: list[str]) -> int:
    options = parse_arguments(arguments)
    torque = load(options)
    progress = Progress(options.quiet)
    vcu = Vcu(
        options.can,
        identifier_offset=options.identifier_offset,
        period_s=1.0 / options.rate,
        torque_limit_nm=options.torque_limit,
        keeps_sent=True,
    )
    tracking = Tracking()
    start_ns, failure = None, None
    try:
        with vcu:
            progress.say(f"playing {options.profile} ({torque.duration_s:g} s) on {vcu.address}")
            if not options.no_handshake:
                shake_hands(vcu, progress, options.timeout, options.reset_faults)
            start_ns, failure = play(vcu, torque, progress, tracking, watch=not options.no_handshake)
    except cantools.database.EncodeError as error:
        raise UserError(f"a command does not fit the contract: {error}.") from None
    finally:
        if options.log:
            write_log(options.log, start_ns, vcu)
    if failure:
        raise EndedError(failure)
    if deviation := tracking.sentence():
        print(f"vcu: {deviation}.", file=sys.stderr)
    progress.say(f"played; {vcu.frames} frames sent, {vcu.missed} periods missed ({describe(vcu.reports)})")
    return 0


if __name__ == "__main__":
    run("vcu", main)
