"""Runs a scenario at many points of its configuration: a grid, a sample or a list, on all cores or on Dask."""

import argparse
import os
import sys
import time
import uuid
from collections.abc import Iterable, Iterator
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from . import mil_program, sweep_file, sweep_program
from .errors import run
from .paths import OUT
from .sweep_file import Sweep, toml_value
from .sweep_point import EXPECT_FAILED, FAILED, OK, Job
from .sweep_store import SweepStore

REPORT_EVERY_S = 10  # where there is no terminal for a bar [s]

EXAMPLES = """examples:
  scripts/sweep configs/sweeps/hysteresis_band.toml
  scripts/sweep configs/sweeps/machine_parameters.toml --workers 8 --csv
  scripts/sweep configs/sweeps/hysteresis_band.toml --dry-run
  scripts/sweep configs/sweeps/machine_parameters.toml --scheduler tcp://10.0.0.5:8786

The file names a scenario and a grid, a random sample or a list of points:
  scenario = "../scenarios/constant_torque.toml"   # relative to this file
  [set]
  duration_s = 0.5                                 # the same in every point
  [grid]
  "control.dtc.torque_band_upper_nm" = [0.5, 0.918]
  "machine.r_r_ohm" = { from = 0.4, to = 1.6, count = 5, scale = "log" }
  [plot]
  metrics = ["torque_ripple_pp_nm"]
docs/sweeps.md has all of it. Interrupted with Ctrl-C, the same command goes on where it stopped. Exit status: 0 when
every point ran (one whose [expect] does not hold did run, unless --fail-on-expect), 1 when one failed, 130 when
interrupted."""


def parse_arguments(arguments: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="sweep",
        description="Runs a scenario at many points of its configuration and writes one table and plots of them.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("file", type=Path, metavar="SWEEP.toml", help="what is swept")
    parser.add_argument("--out", type=Path, metavar="DIR", help="where everything goes (default: out/sweeps/NAME)")
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--workers", type=int, metavar="N", help="points at a time (default: one for each processor)")
    where.add_argument("--scheduler", metavar="ADDRESS", help="a Dask scheduler that runs already, tcp://HOST:PORT")
    parser.add_argument("--csv", action="store_true", help="write table.csv beside table.parquet")
    parser.add_argument("--plot", action=argparse.BooleanOptionalAction, default=True, help="draw the file's [plot]")
    parser.add_argument("--dry-run", action="store_true", help="print the points and leave")
    parser.add_argument("--restart", action="store_true", help="discard finished points and begin anew")
    parser.add_argument(
        "--fail-on-expect", action="store_true", help="end with 1 where a point's [expect] does not hold, as for a CI"
    )
    parser.add_argument("--retry-failed", action="store_true", help="run failed points once more")
    parser.add_argument("--time-limit", type=float, metavar="S", help="of one point, instead of the file's [s]")
    parser.add_argument("--mil", type=Path, metavar="PATH", help="sextant-mil (default: that of build/release)")
    options = parser.parse_args(arguments)
    if options.workers is not None and options.workers < 1:
        parser.error(f"--workers: expected a number from 1, got {options.workers}")
    if options.time_limit is not None and not options.time_limit > 0:
        parser.error(f"--time-limit: expected a number above 0, got {options.time_limit:g}")
    return options


def about(sweep: Sweep) -> str:
    seed = "" if sweep.seed is None else f", seed {sweep.seed}"
    points = f"{len(sweep.points)} point{'s' * (len(sweep.points) != 1)}"
    return f"{sweep.name}: {sweep.kind} of {points} over {', '.join(sweep.varied)}{seed}"


def print_points(sweep: Sweep) -> None:
    print(about(sweep))
    for key, value in sweep.fixed.items():
        print(f"everywhere {key}={toml_value(value)}")
    for number, point in enumerate(sweep.points):
        print(number, *(f"{key}={toml_value(value)}" for key, value in point.items()))


def make_jobs(sweep: Sweep, store: SweepStore, program: Path, time_limit_s: float | None) -> list[Job]:
    token = uuid.uuid4().hex
    directory = str(sweep.file.resolve().parent)
    return [
        Job(
            k,
            token,
            (*sweep_program.command(program, sweep, sweep.points[k]), "--no-trace"),
            directory,
            time_limit_s or sweep.time_limit_s,
        )
        for k in store.missing()
    ]


def with_bar(records: Iterable[dict], store: SweepStore, total: int) -> Iterator[dict]:
    """Passes the records through; shows on stderr how far they are."""
    console = Console(stderr=True)
    columns = (
        TextColumn("sweep"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[failed]}"),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    )
    shown_s = time.monotonic()
    with Progress(*columns, console=console, disable=not console.is_terminal) as progress:
        task = progress.add_task("", total=total, completed=len(store.records), failed="")
        for record in records:
            yield record
            failed = store.count(FAILED)
            progress.update(task, completed=len(store.records), failed=f"{failed} failed" if failed else "")
            if progress.disable and time.monotonic() - shown_s >= REPORT_EVERY_S:
                shown_s = time.monotonic()
                print(f"sweep: {len(store.records)} of {total} points, {failed} failed", file=sys.stderr, flush=True)


def keep_records(records: Iterator[dict], store: SweepStore, total: int) -> None:
    """Adds each record to the store as its point ends."""
    try:
        for record in with_bar(records, store, total):
            store.add(record)
    finally:
        records.close()


def run_points(sweep: Sweep, store: SweepStore, jobs: list[Job], options: argparse.Namespace) -> None:
    from . import sweep_cluster  # takes a second, which --help and a finished sweep need not wait for

    workers = min(options.workers or len(os.sched_getaffinity(0)), len(jobs))
    connection = (
        sweep_cluster.remote_client(options.scheduler) if options.scheduler else sweep_cluster.local_client(workers)
    )
    with connection as client:
        slots = sweep_cluster.slots(client)
        where = f"scheduler {options.scheduler}" if options.scheduler else "this machine"
        print(f"sweep: {len(jobs)} points to run, {slots} at a time on {where}", flush=True)
        keep_records(sweep_cluster.run_jobs(client, jobs), store, len(sweep.points))


def last_line(store: SweepStore, total: int) -> str:
    counts = f"{store.count(OK)} ok, {store.count(EXPECT_FAILED)} with an [expect] that does not hold"
    failed = [record for record in store.in_order() if record["status"] == FAILED]
    text = f"{len(store.records)} of {total} points ran: {counts}, {len(failed)} failed"
    return f"{text}; the first is point {failed[0]['point']}: {failed[0]['reason']}" if failed else text


def write_results(
    sweep: Sweep, store: SweepStore, scenario: sweep_program.Scenario, options: argparse.Namespace
) -> None:
    from . import sweep_table

    for file in sweep_table.write(sweep_table.build(sweep, store, scenario.metrics()), store.directory, options.csv):
        print(file)
    if options.plot and sweep.plot.metrics:
        from . import sweep_plot

        for file in sweep_plot.write(sweep, store, store.directory, scenario.units()):
            print(file)


def perform(sweep: Sweep, options: argparse.Namespace) -> int:
    program = mil_program.find(options.mil)
    scenario = sweep_program.examine(program, sweep)
    directory = options.out or OUT / "sweeps" / sweep.name
    configuration = sweep_program.contents(scenario, sweep)
    store = SweepStore(directory, sweep, configuration, sweep_program.fingerprint(program))
    total = len(sweep.points)
    try:
        store.open(options.restart, options.retry_failed)
        print(about(sweep))
        if store.records:
            print(f"sweep: {len(store.records)} of {total} points are finished in {directory}")
        if jobs := make_jobs(sweep, store, program, options.time_limit):
            run_points(sweep, store, jobs, options)
        write_results(sweep, store, scenario, options)
    except KeyboardInterrupt:
        kept = f"{len(store.records)} of {total} points are finished and kept in {directory}"
        print(f"sweep: interrupted; {kept}; the same command resumes.", file=sys.stderr)
        raise
    finally:
        store.close()
    failed = store.count(FAILED) > 0 or len(store.missing()) > 0
    failed = failed or (options.fail_on_expect and store.count(EXPECT_FAILED) > 0)
    print(f"sweep: {last_line(store, total)}", flush=True, file=sys.stderr if failed else sys.stdout)
    return 1 if failed else 0


def main(arguments: list[str]) -> int:
    options = parse_arguments(arguments)
    sweep = sweep_file.load(options.file)
    if options.dry_run:
        print_points(sweep)
        return 0
    return perform(sweep, options)


if __name__ == "__main__":
    run("sweep", main)
