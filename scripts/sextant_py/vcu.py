"""The vehicle control unit: plays a torque profile to a drive over CAN.

It sends disable frames until the drive reports that it is ready, enables it, plays the profile on an absolute schedule
with counter and CRC, listens to what the drive reports, and ends with disable frames, on Ctrl-C as well.
"""

import argparse
import json
import sys
import threading
import time
from dataclasses import dataclass, field
from pathlib import Path

import can
import cantools

from . import bus as can_bus
from . import e2e, profile
from .contract import Contract
from .errors import UserError, run
from .tracking import Tracking

COMMAND = "VCU_TorqueCommand"
STATUS = "MCU_TorqueStatus"
IDENTIFICATION = "MCU_Identification"
STANDING_STATES = ("READY",)
RUNNING_STATES = ("MAGNETISING", "TORQUE", "DERATED")
FOLLOWING_STATES = ("TORQUE", "DERATED")  # in which the torque answers to the request
STATUS_TIMEOUT_S = 0.5
DISABLE_FRAMES = 10
LOG_FIELDS = ("t_ns", "torque_nm", "enable", "counter")

EXAMPLES = """examples:
  scripts/vcu --profile configs/profiles/demo.csv
  scripts/vcu --can socketcan:vcan0 --profile configs/profiles/demo.csv --log out/commands.json
  scripts/vcu --profile configs/profiles/demo.csv --no-handshake   # the drive must stay locked out
"""


@dataclass
class Reports:
    """What the drive has reported, kept up by a thread of its own."""

    bus: can.BusABC
    contract: Contract
    latest: dict[str, dict] = field(default_factory=dict)
    refused: int = 0
    _periods_without_status: int = 0
    _checkers: dict[str, e2e.Checker] = field(default_factory=dict)
    _stop: threading.Event = field(default_factory=threading.Event)
    _thread: threading.Thread | None = None

    def start(self) -> None:
        self._thread = threading.Thread(target=self._receive, name="reports", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        self._stop.set()
        if self._thread:
            self._thread.join(1.0)

    def _receive(self) -> None:
        while not self._stop.is_set():
            try:
                frame = can_bus.receive(self.bus, 0.1)
            except (can.CanError, OSError):
                time.sleep(0.1)
                continue
            if frame is not None:
                self.accept(frame)

    def accept(self, frame: can.Message) -> None:
        decoded = self.contract.decode(frame)
        if decoded is None or decoded[0] == COMMAND:
            return
        name, signals = decoded
        data_id = self.contract.data_id(name)
        if data_id is not None:
            checker = self._checkers.setdefault(name, e2e.Checker(data_id))
            if checker.check(bytes(frame.data)) is e2e.Result.ERROR:
                self.refused += 1
                return
        self.latest[name] = signals
        if name == STATUS:
            self._periods_without_status = 0

    def state(self) -> str | None:
        status = self.latest.get(STATUS)
        return str(status["DriveState"]) if status else None

    def ready(self) -> bool:
        status = self.latest.get(STATUS)
        return bool(status) and not status["Lockout"] and self.state() in STANDING_STATES

    def timed_out(self, period_s: float) -> bool:
        """Whether no status has come for STATUS_TIMEOUT_S; called once a period. Counted in periods in which this
        program ran: time in which the machine stood still does not count."""
        self._periods_without_status += 1
        return STATUS not in self.latest or self._periods_without_status * period_s > STATUS_TIMEOUT_S

    def other_contract(self) -> str | None:
        """What is wrong where the drive has said that its frames mean something else; None otherwise."""
        said = self.latest.get(IDENTIFICATION)
        if said is None or said["ContractMajor"] == self.contract.version()[0]:
            return None
        theirs = f"{said['ContractMajor']}.{said['ContractMinor']}"
        ours = ".".join(map(str, self.contract.version()))
        return f"the drive speaks version {theirs} of the CAN contract, this program {ours}."

    def first_fault(self) -> str:
        return str(self.latest.get("MCU_Faults", {}).get("FirstFault", "no reason reported"))


class Commander:
    """Sends commands on an absolute schedule and, unless told otherwise, remembers them."""

    def __init__(
        self, bus: can.BusABC, contract: Contract, period_s: float, torque_limit_nm: float, keeps_log: bool = True
    ) -> None:
        self._bus = bus
        self._contract = contract
        self.period_s = period_s
        self._period_ns = round(period_s * 1e9)
        self._torque_limit_nm = torque_limit_nm
        self._keeps_log = keeps_log
        self._counter = 0
        self._next_ns = time.monotonic_ns()
        self.sent: list[tuple[int, float, bool, int]] = []
        self.missed = 0
        self.unsent = 0

    def wait(self) -> int:
        """Sleeps until the next frame is due and returns when that was [ns]; whole periods missed are skipped."""
        self._next_ns += self._period_ns
        late_ns = time.monotonic_ns() - self._next_ns
        if late_ns > self._period_ns:
            missed = late_ns // self._period_ns
            self.missed += missed
            self._next_ns += missed * self._period_ns
        time.sleep(max(self._next_ns - time.monotonic_ns(), 0) / 1e9)
        return self._next_ns

    def send(self, torque_nm: float, enable: bool, fault_reset: bool = False) -> None:
        signals = {"TorqueRequest": torque_nm, "TorqueLimit": self._torque_limit_nm}
        signals |= {"Enable": int(enable), "FaultReset": int(fault_reset)}
        frame = self._contract.encode(COMMAND, signals, self._counter)
        try:
            self._bus.send(frame)
        except (can.CanError, OSError):
            self.unsent += 1
        else:
            if self._keeps_log:
                self.sent.append((time.monotonic_ns(), torque_nm, enable, self._counter))
        self._counter = (self._counter + 1) % e2e.COUNTER_COUNT


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
    """What the drive reports, for a person."""
    status, motion = reports.latest.get(STATUS), reports.latest.get("MCU_Motion")
    parts = [str(reports.state() or "no status")]
    if status:
        parts.append(f"torque {status['TorqueEstimated']:+7.2f} N·m")
    if motion:
        parts.append(f"speed {motion['Speed']:+7.1f} rpm")
    return ", ".join(parts)


def shake_hands(commander: Commander, reports: Reports, progress: Progress, timeout_s: float, reset: bool) -> None:
    """Sends disable frames until the drive is ready for an enable."""
    deadline = time.monotonic() + timeout_s
    while not reports.ready():
        timed_out = reports.timed_out(commander.period_s)
        if time.monotonic() > deadline:
            _refuse_handshake(reports, timeout_s, timed_out)
        if other := reports.other_contract():
            raise UserError(other)
        in_fault = reports.state() == "FAULT"
        if in_fault and not reset:
            raise UserError(f"the drive is in FAULT ({reports.first_fault()}); --reset-faults asks it to clear them.")
        commander.wait()
        commander.send(0.0, False, fault_reset=in_fault)
        progress.show(f"disable: waiting for the drive ({describe(reports)})")
    progress.say(f"the drive is ready ({describe(reports)})")


def _refuse_handshake(reports: Reports, timeout_s: float, timed_out: bool) -> None:
    if reports.refused and not reports.latest.get(STATUS):
        raise UserError(f"{reports.refused} status frames came, but none with a valid CRC and data ID.")
    if timed_out:
        raise UserError(
            f"no status frame from a drive with the identifier offset {reports.contract.identifier_offset} within"
            f" {timeout_s:g} s; is sextant-ecu running on this bus, and is --identifier-offset its"
            " can.identifier_offset?"
        )
    lockout = reports.latest[STATUS]["Lockout"]
    raise UserError(
        f"the drive did not become ready within {timeout_s:g} s: it reports {reports.state()}"
        f"{' and lockout' if lockout else ''}."
    )


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
    commander: Commander, reports: Reports, torque: profile.Profile, progress: Progress, tracking: Tracking, watch: bool
) -> tuple[int, str | None]:
    """Plays the profile. Returns when it began [ns] and, where it had to end early, why."""
    start_ns = commander.wait()
    due_ns = start_ns
    was_running = False
    while (time_s := (due_ns - start_ns) / 1e9) <= torque.duration_s:
        torque_nm, enable = torque.at(time_s)
        commander.send(torque_nm, enable)
        off = compare(tracking, reports, time_s, torque_nm, enable)
        progress.show(f"{time_s:6.2f} s  request {torque_nm:+7.2f} N·m  drive: {describe(reports)}{off}")
        if watch:
            if other := reports.other_contract():
                return start_ns, other
            was_running = was_running or reports.state() in RUNNING_STATES
            if reports.timed_out(commander.period_s):
                return start_ns, f"the drive's status frames timed out {time_s:.2f} s into the profile."
            if was_running and reports.state() == "FAULT":
                return start_ns, f"the drive went to FAULT ({reports.first_fault()}) {time_s:.2f} s into the profile."
        due_ns = commander.wait()
    if watch and not was_running and any(point.enable for point in torque.points):
        return start_ns, f"the drive never produced torque; it reports {reports.state()}."
    return start_ns, None


def disable(commander: Commander) -> None:
    for _ in range(DISABLE_FRAMES):
        commander.wait()
        commander.send(0.0, False)


def write_log(
    path: Path, address: can_bus.Address, start_ns: int | None, period_s: float, commander: Commander
) -> None:
    """Commands with the monotonic time at which each left [ns]."""
    commands = [dict(zip(LOG_FIELDS, row, strict=True)) for row in commander.sent]
    log = {
        "bus": str(address),
        "period_ms": period_s * 1e3,
        "profile_start_ns": start_ns,
        "missed_periods": commander.missed,
        "unsent_frames": commander.unsent,
        "commands": commands,
    }
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(log, indent=1) + "\n", encoding="utf-8")
    except OSError as error:
        raise UserError(f"the log {path} cannot be written: {error.strerror}.") from None


def parse_arguments(arguments: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="vcu",
        description="Plays a torque profile to a drive over CAN, as a vehicle control unit does.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
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


def main(arguments: list[str]) -> int:
    options = parse_arguments(arguments)
    offset = options.identifier_offset
    contract = Contract(identifier_offset=can_bus.default_identifier_offset() if offset is None else offset)
    torque = profile.load(options.profile, options.interpolation)
    smallest_nm, largest_nm = contract.limits(COMMAND, "TorqueRequest")
    if not all(smallest_nm <= point.torque_nm <= largest_nm for point in torque.points):
        raise UserError(
            f"the profile {options.profile} leaves the contract's range of torque,"
            f" {smallest_nm:g} to {largest_nm:g} N·m."
        )
    if not 1 <= options.rate <= 1000:
        raise UserError("--rate must be between 1 and 1000 Hz.")
    limit_nm = options.torque_limit if options.torque_limit is not None else contract.limits(COMMAND, "TorqueLimit")[1]
    address = can_bus.parse(options.can or can_bus.default_address())
    progress = Progress(options.quiet)
    bus = can_bus.open_bus(address)
    reports = Reports(bus, contract)
    commander = Commander(bus, contract, 1.0 / options.rate, limit_nm)
    tracking = Tracking()
    start_ns, failure = None, None
    reports.start()
    try:
        progress.say(f"playing {options.profile} ({torque.duration_s:g} s) on {address}")
        if not options.no_handshake:
            shake_hands(commander, reports, progress, options.timeout, options.reset_faults)
        start_ns, failure = play(commander, reports, torque, progress, tracking, watch=not options.no_handshake)
    except cantools.database.EncodeError as error:
        raise UserError(f"a command does not fit the contract: {error}.") from None
    finally:
        disable_and_close(commander, reports, bus)
        if options.log:
            write_log(options.log, address, start_ns, 1.0 / options.rate, commander)
    if failure:
        raise UserError(failure)
    if deviation := tracking.sentence():
        print(f"vcu: {deviation}.", file=sys.stderr)
    progress.say(f"played; {len(commander.sent)} frames sent, {commander.missed} periods missed ({describe(reports)})")
    return 0


def disable_and_close(commander: Commander, reports: Reports, bus: can.BusABC) -> None:
    try:
        if commander.sent:
            disable(commander)
    finally:
        reports.stop()
        bus.shutdown()


if __name__ == "__main__":
    run("vcu", main)
