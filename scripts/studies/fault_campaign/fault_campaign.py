"""Provokes every fault of the drive over seeds and operating points, drives hours without one, and writes the page."""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path
from types import ModuleType

from sextant_py import mil_program
from sextant_py.errors import UserError, run
from sextant_py.paths import OUT, ROOT
from sextant_py.program_arguments import add_runs, from_one, parser_of

from studies import json_file
from studies.command import made
from studies.page import put_into
from studies.parallel import as_finished, in_order
from studies.plant_faults import injections_table

from . import false_trips, honest, library
from . import file as fault_campaign_file
from .page import fault_table, trip_list, write

PROGRAM = ROOT / "build" / "release" / "tests" / "bench" / "sextant_fault_campaign"
PAGE = ROOT / "docs" / "fault_campaign.md"
EXAMPLES = """examples:
  scripts/fault_campaign                          100 seeds and three hours, then the tables of docs/fault_campaign.md
  scripts/fault_campaign --quick                  3 seeds and a few minutes, printed
  scripts/fault_campaign --seeds 1000 --hours 0   the faults alone, printed
  scripts/fault_campaign my.toml                  any drive: the faults of plant and sensors in sextant-mil, printed
  scripts/fault_campaign my.toml --methods all    the same with every control method
  scripts/fault_campaign --library                the same on four machines of the library at two control periods, then
                                                  the tables of the library in docs/fault_campaign.md
  scripts/fault_campaign --honest                 the drive of configs/ecu_honest.toml, told what identify finds,
                                                  then its tables in docs/fault_campaign.md

Exit status: 0 when no fault was missed or late and nothing tripped without one, 1 otherwise, 130 when interrupted."""


def parse_arguments(arguments: list[str]) -> argparse.Namespace:
    parser = parser_of(
        "fault_campaign", "Provokes every fault of the drive in virtual time, and drives hours without one.", EXAMPLES
    )
    parser.add_argument("file", nargs="?", type=Path, metavar="FILE", help="of sextant-ecu or sextant-mil; no page")
    parser.add_argument("--methods", metavar="A,B", help="of FILE: these, or all (default: the one of the file)")
    parser.add_argument("--library", action="store_true", help="on machines of the library, with every method")
    parser.add_argument("--honest", action="store_true", help="on a plant with the errors of a real one, identified")
    parser.add_argument("--quick", action="store_true", help="a few seeds and minutes, no page")
    parser.add_argument(
        "--seeds", type=from_one, metavar="N", help="of each injection (default: 100; --library, --honest: 1)"
    )
    parser.add_argument("--hours", type=float, metavar="H", help="simulated hours of each driving (default: 1)")
    add_runs(parser)
    options = parser.parse_args(arguments)
    if options.hours is not None and options.hours < 0:
        parser.error(f"--hours: expected a number from 0, got {options.hours:g}")
    if options.methods and not options.file:
        parser.error("--methods: the methods are those of a FILE, and none is given")
    if options.file and options.library:
        parser.error("--library: the machines are those of the library, and FILE names another drive")
    if options.honest and (options.file or options.library):
        parser.error("--honest: the drive is that of configs/ecu_honest.toml; leave FILE and --library out")
    options.is_of_page = not (options.quick or options.file) and options.seeds is None and options.hours is None
    options.seeds = options.seeds or default_seeds(options)
    options.hours = options.hours if options.hours is not None else (0.02 if options.quick else 1.0)
    return options


def default_seeds(options: argparse.Namespace) -> int:
    if options.library:
        return 1 if options.quick else library.SEEDS
    if options.honest:
        return 1 if options.quick else honest.SEEDS
    return 1 if options.quick and options.file else 3 if options.quick else 100


def output_of(*words: object) -> str:
    """Of the program of the injections."""
    try:
        done = subprocess.run([str(PROGRAM), *map(str, words)], capture_output=True, text=True, check=False)
    except FileNotFoundError:
        raise UserError(f"{PROGRAM} is not built yet; scripts/fault_campaign does it.") from None
    if done.returncode:
        raise UserError(f"{PROGRAM.name} {' '.join(map(str, words))} failed: {done.stderr.strip()[-300:]}")
    return done.stdout


def provoke(options: argparse.Namespace) -> list[dict]:
    """What each injection has shown, in the order of the list."""
    mil_program.build(PROGRAM.name, "-DSEXTANT_BUILD_BENCHMARKS=ON")

    def inject(number: int) -> dict:
        one = json.loads(output_of(number, options.seeds))
        bad = one["missed"] or one["late"] or one["trips_inside"]
        print(
            f"{one['name']:32} {one['fault']:22} {one['runs']:5} runs, {one['missed']} missed, "
            f"worst {one['reaction_ms']:8.3f} of {one['bound_ms']:g} ms, just inside {one['trips_inside']} trips",
            f"  {one['worst']}" if bad else "",
            flush=True,
        )
        return one

    return in_order(inject, range(len(output_of().splitlines())), options.jobs)


def drive(options: argparse.Namespace) -> list[false_trips.Hours]:
    hours: dict[str, false_trips.Hours] = {}
    with tempfile.TemporaryDirectory(prefix="sextant-trips-") as name:
        lab = false_trips.Lab(options.mil, Path(name))
        plan = false_trips.drives(options.hours)
        for done, (_, (one, summary)) in enumerate(as_finished(lab.run, plan, options.jobs), start=1):
            false_trips.add(hours, one, summary)
            if summary["faults"] or done % 50 == 0 or done == len(plan):
                trips = f": {hours[one.kind].cases[-1]}" if summary["faults"] else ""
                print(f"{done} of {len(plan)} runs, {one.kind}{trips}", flush=True)
    return [hours[kind] for kind in false_trips.KINDS if kind in hours]


def of_a_file(options: argparse.Namespace) -> int:
    """The campaign of the drive of a file."""
    work = made(OUT / "fault_campaign")
    campaign = fault_campaign_file.Campaign(options.file, options.mil, work)
    for key in campaign.drive.left_out:
        print(f"fault_campaign: {key} is left out: no scenario has it", file=sys.stderr)
    methods = fault_campaign_file.chosen_methods(options.methods, campaign.method)
    plan = fault_campaign_file.cases(methods, options.seeds, campaign.sensors)
    found = campaign.run_all(plan, options.jobs, options.file.name)
    hours = campaign.hours(methods, options.hours, options.jobs) if options.hours > 0 else []
    print(injections_table(found, ("name", "method")), trip_list(hours), sep="\n\n")
    return verdict(keep(options, fault_campaign_file.Found(found, hours), work / f"{options.file.stem}.json"))


def of_a_study(options: argparse.Namespace, study: ModuleType, name: str, subject: str) -> int:
    """The campaign on the machines of a library, or on a plant with the errors of a real one."""
    work = made(OUT / "fault_campaign")
    found = study.measure(options.seeds, options.hours, options.jobs, options.mil, work)
    print(study.tables(found))
    keep(options, found, work / f"{name}.json")
    if options.is_of_page:
        put_into(PAGE, study.blocks(found, options.seeds))
        print(f"fault_campaign: {PAGE.relative_to(ROOT)} has the tables of {subject}")
    return verdict(found)


def keep(options: argparse.Namespace, found: fault_campaign_file.Found, file: Path) -> fault_campaign_file.Found:
    json_file.write(file, {"seeds": options.seeds} | vars(found))
    print(file)
    return found


def verdict(found: fault_campaign_file.Found) -> int:
    """The exit status."""
    bad, trips = fault_campaign_file.wrong(found.runs), sum(sum(one.faults.values()) for one in found.hours)
    for one in bad[:10]:
        print(f"fault_campaign: {one['case']}: {one['kind']}: {one['seen']}", file=sys.stderr)
    if bad or trips:
        print(f"fault_campaign: {len(bad)} runs are not right, {trips} false trips", file=sys.stderr)
    return 1 if bad or trips else 0


def main(arguments: list[str]) -> int:
    options = parse_arguments(arguments)
    options.mil = mil_program.find(options.mil)
    if options.file:
        return of_a_file(options)
    if options.library:
        return of_a_study(options, library, "library", "the library")
    if options.honest:
        return of_a_study(options, honest, "honest", "the honest plant")
    faults = provoke(options)
    hours = drive(options) if options.hours > 0 else []
    print(fault_table(faults), trip_list(hours), sep="\n\n")
    json_file.write(OUT / "fault_campaign.json", {"seeds": options.seeds, "faults": faults, "hours": hours})
    if options.is_of_page:
        write(PAGE, options.seeds, faults, hours)
        print(f"fault_campaign: {PAGE.relative_to(ROOT)} has the tables")
    missed = sum(one["missed"] + one["late"] + one["trips_inside"] for one in faults)
    trips = sum(sum(one.faults.values()) for one in hours)
    if missed or trips:
        print(f"fault_campaign: {missed} missed, late or early faults, {trips} false trips", file=sys.stderr)
    return 1 if missed or trips else 0


if __name__ == "__main__":
    run("fault_campaign", main)
