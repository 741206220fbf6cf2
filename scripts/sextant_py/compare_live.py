"""The live drive of configs/ecu.toml with CVODE and with the fixed step, in turns: what each misses of its control
periods while it follows the demo's profile."""

import argparse
import json
import os
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console
from rich.table import Table

from . import mil_program, printed_configuration
from .errors import EndedError, run
from .paths import ECU, LOOPBACK, ROOT
from .profile import load
from .program_arguments import parser_of

PROFILE = ROOT / "configs" / "profiles" / "demo.csv"
BUS = "udp_multicast:239.74.163.2:43178"
INTEGRATORS = ("cvode", "fixed")
OWN = "own execution"  # the cause of an overrun that an integrator has
MARGIN_S = 2.0  # for the start and the hand-shake
# A machine that stands still for a moment does not end a run.
PATIENCE = (
    *("command.timeout_ms=3000", "command.lost_ms=10000"),
    *("command.status_timeout_ms=3000", "command.status_lost_ms=10000"),
    *("realtime.watchdog_ms=10000", "dds.domain=101"),
)

EXAMPLES = """examples:
  scripts/compare_live                                    three rounds of ten seconds each
  scripts/compare_live --rounds 10 --set realtime.cpu=1
  scripts/compare_live --config configs/ecu_foc.toml      with field-oriented control
A missed period is one that a wake-up late by a wake period or more has left out. The machine's own pauses do it too:
overruns by the drive's own execution are the integrator's. Needs a multicast route, as scripts/vcu does."""


@dataclass
class Run:
    periods: int
    missed: int
    overruns: int
    own: int  # overruns by the drive's own execution
    execution: dict[str, float]  # percentiles of a wake-up's execution time [ns]


def drive(options: argparse.Namespace, integrator: str) -> Run:
    """The profile once."""
    settings = (f"plant.integrator={integrator}", *PATIENCE, *options.set)
    words = [word for setting in settings for word in ("--set", setting)]
    with tempfile.TemporaryDirectory(prefix="sextant-live-") as name:
        timing = Path(name) / "timing.json"
        seconds = str(load(PROFILE).duration_s + MARGIN_S)
        command = [options.ecu, options.config, "--can", BUS, "--duration", seconds, "--timing-out", timing, *words]
        environment = {**os.environ, "CYCLONEDDS_URI": LOOPBACK.read_text(encoding="utf-8")}
        with subprocess.Popen(
            command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, env=environment
        ) as ecu:
            vehicle = [ROOT / "scripts" / "vcu", "--quiet", "--can", BUS, "--profile", PROFILE]
            played = subprocess.run(vehicle, capture_output=True, text=True)
            said = ecu.communicate()[1]
        if played.returncode or ecu.returncode:
            raise EndedError(f"the run with {integrator} has failed: {(played.stderr or said).strip()}")
        found = json.loads(timing.read_text(encoding="utf-8"))
    own = found["overruns_by_cause"][OWN]
    return Run(found["periods"], found["periods_missed"], found["overruns"], own, found["execution"])


def in_turns(options: argparse.Namespace) -> dict[str, list[Run]]:
    """Each round begins with the other integrator."""
    found: dict[str, list[Run]] = {name: [] for name in INTEGRATORS}
    for number in range(options.rounds):
        for name in INTEGRATORS if number % 2 == 0 else reversed(INTEGRATORS):
            one = drive(options, name)
            found[name].append(one)
            print(f"round {number + 1}, {name}: {one.missed} of {one.periods} periods missed", flush=True)
    return found


def best(runs: list[Run], percentile: str) -> str:
    """Of the run that the machine disturbed least."""
    return f"{min(one.execution[percentile] for one in runs) / 1e3:.0f} µs"


def table_of(found: dict[str, list[Run]]) -> Table:
    table = Table(title="Live control periods while the drive follows the demo's profile", title_justify="left")
    table.add_column("", no_wrap=True)
    for name in found:
        table.add_column(name, justify="right")
    rows = {
        "periods": lambda runs: f"{sum(one.periods for one in runs)}",
        "missed": lambda runs: f"{sum(one.missed for one in runs)} ({', '.join(str(one.missed) for one in runs)})",
        "overruns": lambda runs: f"{sum(one.overruns for one in runs)}",
        "of these by the drive's own execution": lambda runs: f"{sum(one.own for one in runs)}",
        "execution of a wake-up, median": lambda runs: best(runs, "p50_ns"),
        "execution of a wake-up, 99 %": lambda runs: best(runs, "p99_ns"),
    }
    for name, text in rows.items():
        table.add_row(name, *(text(runs) for runs in found.values()))
    return table


def parse_arguments(arguments: list[str]) -> argparse.Namespace:
    parser = parser_of(
        "compare_live",
        "Runs the live drive with CVODE and with the fixed step in turns, following the demo's profile, "
        "and prints the control periods that each has missed.",
        EXAMPLES,
    )
    parser.add_argument("--rounds", type=int, default=3, metavar="N", help="runs of each integrator (default: 3)")
    parser.add_argument("--config", type=Path, default=ECU, metavar="FILE", help="default: configs/ecu.toml")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="of both drives")
    options = parser.parse_args(arguments)
    if options.rounds < 1:
        parser.error(f"--rounds: expected a number from 1, got {options.rounds}")
    return options


def main(arguments: list[str]) -> int:
    options = parse_arguments(arguments)
    settings = [word for setting in options.set for word in ("--set", setting)]
    options.ecu = mil_program.find(None, "sextant-ecu")
    # Refused before a vehicle waits for the drive.
    printed_configuration.tables_of(options.ecu, options.config, settings, "the drive")
    found = in_turns(options)
    Console().print(table_of(found))
    return 0


if __name__ == "__main__":
    run("compare_live", main)
