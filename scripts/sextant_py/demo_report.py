"""What was commanded and what was delivered: a table from the VCU's log and a recording of the telemetry."""

import argparse
import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from .dds import contract_fields
from .errors import UserError, run
from .program_arguments import parser_of
from .recording.model import MAIN
from .signal_file import SignalFile
from .tracking import TOLERANCE_NM, TOLERANCE_SHARE, Tracking

STEP_NM = 5.0
SETTLED = 0.95
SETTLING_NS = 50_000_000


@dataclass
class Commands:
    """What the VCU sent. Both clocks are the machine's monotonic one."""

    t_ns: np.ndarray
    torque_nm: np.ndarray
    enable: np.ndarray
    period_ms: float
    missed: int

    def torque_at(self, t_ns: np.ndarray) -> np.ndarray:
        """The torque last sent before a time [N·m]."""
        index = np.clip(np.searchsorted(self.t_ns, t_ns, side="right") - 1, 0, len(self.t_ns) - 1)
        return self.torque_nm[index]

    def span_ns(self) -> tuple[int, int]:
        """First and last enabled command [ns]."""
        enabled = self.t_ns[self.enable]
        if not len(enabled):
            raise UserError("no command was sent with enable set.")
        return int(enabled[0]), int(enabled[-1])


def load_commands(path: Path) -> Commands:
    try:
        log = json.loads(path.read_text(encoding="utf-8"))
        rows = log["commands"]
        return Commands(
            np.array([row["t_ns"] for row in rows], dtype=np.int64),
            np.array([row["torque_nm"] for row in rows], dtype=float),
            np.array([row["enable"] for row in rows], dtype=bool),
            log["period_ms"],
            log["missed_periods"],
        )
    except (OSError, ValueError, KeyError) as error:
        raise UserError(f"the log of commands {path} cannot be read: {error}.") from None


def as_double(values: np.ndarray) -> np.ndarray:
    """Sums of single precision over a long recording would lose digits."""
    return values.astype(float) if values.dtype.kind == "f" else values


def load_recording(path: Path) -> dict[str, np.ndarray]:
    try:
        rows = SignalFile(path).groups[MAIN]
        return {name: as_double(rows.values(name)) for name in contract_fields("DriveTelemetry")}
    except (KeyError, ValueError) as error:
        raise UserError(f"the recording {path} has no telemetry of this contract: {error}.") from None


def response_time_ms(recording: dict[str, np.ndarray]) -> tuple[float, float] | None:
    """Size of the first step of torque [N·m] and the time from its reception to 95 % of it [ms]."""
    requested, mean = recording["torque_requested_nm"], recording["torque_mean_nm"]
    steps = np.flatnonzero(np.abs(np.diff(requested)) >= STEP_NM)
    if not len(steps):
        return None
    first = int(steps[0]) + 1
    before, after = requested[first - 1], requested[first]
    share = (mean[first:] - before) / (after - before)
    reached = np.flatnonzero(share >= SETTLED)
    if not len(reached):
        return None
    elapsed_ns = recording["t_ns"][first + reached[0]] - recording["command_received_ns"][first]
    return float(after - before), float(elapsed_ns) / 1e6


def settled(recording: dict[str, np.ndarray], wanted: np.ndarray) -> np.ndarray:
    """Where the reference has been constant for a while."""
    changes = np.flatnonzero(np.diff(recording["torque_reference_nm"], prepend=np.nan) != 0)
    last_change = changes[np.searchsorted(changes, np.arange(len(wanted)), side="right") - 1]
    quiet = recording["t_ns"] - recording["t_ns"][last_change] > SETTLING_NS
    return wanted & quiet


def energy_kj(recording: dict[str, np.ndarray]) -> tuple[float, float]:
    """Energy taken from and returned to the DC link [kJ]."""
    power, seconds = recording["power_w"], np.diff(recording["t_ns"], prepend=recording["t_ns"][0]) / 1e9
    work = power * seconds / 1e3
    return float(work[work > 0].sum()), float(-work[work < 0].sum())


def followed(commands: Commands, recording: dict[str, np.ndarray], during: np.ndarray) -> str:
    """In how far the drive delivered what was asked of it."""
    tracking = Tracking()
    t_ns = recording["t_ns"][during]
    samples = zip(t_ns / 1e9, commands.torque_at(t_ns), recording["torque_mean_nm"][during], strict=True)
    for time_s, asked_nm, delivered_nm in samples:
        tracking.add(time_s, asked_nm, delivered_nm)
    return tracking.sentence() or f"never by more than {TOLERANCE_NM:g} N·m or {TOLERANCE_SHARE:.0%}"


def rows(commands: Commands, recording: dict[str, np.ndarray], statistics: dict | None) -> list[tuple[str, str]]:
    begin_ns, end_ns = commands.span_ns()
    during = (recording["t_ns"] >= begin_ns) & (recording["t_ns"] <= end_ns)
    if not during.any():
        raise UserError("the recording and the log of commands have no time in common.")
    commanded, mean = commands.torque_at(recording["t_ns"]), recording["torque_mean_nm"]
    error = (mean - commanded)[during]
    sent = f"{len(commands.t_ns)}, one each {commands.period_ms:g} ms, {commands.missed} periods missed"
    table = [
        ("commands sent", sent),
        ("telemetry samples", f"{int(during.sum())} while enabled"),
        ("torque commanded", f"{commanded[during].min():+.1f} … {commanded[during].max():+.1f} N·m"),
        ("torque delivered (1 ms mean)", f"{mean[during].min():+.1f} … {mean[during].max():+.1f} N·m"),
        ("tracking error", f"{error.mean():+.3f} N·m mean, {np.sqrt(np.mean(error**2)):.3f} N·m RMS"),
    ]
    table.append(("torque beside the request", followed(commands, recording, during)))
    quiet = settled(recording, during)
    if quiet.any():
        off = (mean - recording["torque_reference_nm"])[quiet]
        table.append(("  at constant torque", f"{off.mean():+.3f} N·m mean, {off.std():.3f} N·m RMS about it"))
        flux = recording["flux_mean_wb"][quiet]
        table.append(("stator flux", f"{flux.mean():.4f} Wb mean, {flux.min():.4f} … {flux.max():.4f} Wb"))
    response = response_time_ms(recording)
    if response:
        step_nm, time_ms = response
        table.append(("response time", f"{time_ms:.1f} ms from reception to 95 % of a step of {step_nm:+.0f} N·m"))
    speed = recording["speed_rad_s"][during]
    table.append(("speed", f"{speed.min():+.1f} … {speed.max():+.1f} rad/s"))
    taken, returned = energy_kj(recording)
    table.append(("energy at the DC link", f"{taken:.2f} kJ taken, {returned:.2f} kJ returned"))
    if statistics:
        missed = f"{statistics['periods_missed']} of {statistics['periods']}, {statistics['overruns']} late wake-ups"
        table.append(("missed control periods", missed))
    return table


def load_statistics(path: Path | None, drive_id: int) -> dict | None:
    if path is None:
        return None
    try:
        drives = json.loads(path.read_text(encoding="utf-8"))["drives"]
        return next((drive["statistics"] for drive in drives if drive["drive_id"] == drive_id), None)
    except (OSError, ValueError, KeyError) as error:
        raise UserError(f"the statistics {path} cannot be read: {error}.") from None


def parse_arguments(arguments: list[str]) -> argparse.Namespace:
    parser = parser_of(
        "demo_report",
        "Compares commands with a recording.",
        "example:\n  python -m sextant_py.demo_report out/demo/commands_1.json out/demo/recording_1.h5",
    )
    parser.add_argument("commands", type=Path, help="log of scripts/vcu")
    parser.add_argument("recording", type=Path, help="recording of scripts/record, .h5")
    parser.add_argument("--drive", type=int, default=1, metavar="ID", help="drive_id (default: 1)")
    parser.add_argument("--statistics", type=Path, metavar="FILE", help="output of scripts/monitor --json")
    return parser.parse_args(arguments)


def main(arguments: list[str]) -> int:
    options = parse_arguments(arguments)
    commands, recording = load_commands(options.commands), load_recording(options.recording)
    found = rows(commands, recording, load_statistics(options.statistics, options.drive))
    table = Table(title=f"Commanded and delivered, drive {options.drive}", title_justify="left", show_header=False)
    table.add_column(no_wrap=True)
    table.add_column()
    for name, value in found:
        table.add_row(name, value)
    Console().print(table)
    return 0


if __name__ == "__main__":
    run("demo_report", main)
