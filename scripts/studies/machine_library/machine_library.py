"""Measures the shipped drive on every published machine of configs/machines, and writes docs/machine_library.md."""

import argparse
import time
from pathlib import Path

from sextant_py import mil_program
from sextant_py.control_methods import METHODS
from sextant_py.errors import run
from sextant_py.paths import OUT, ROOT
from sextant_py.program_arguments import add_runs, from_one, parser_of

from studies import json_file
from studies.command import chosen, made, words
from studies.parallel import progress_of

from . import faults, page, random_points, scenarios
from . import honest as machine_library_honest
from .points import PERIODS_US, POINTS_A_CELL, Cell, Point, cells, chosen_machines, points, quick_points
from .results import Outcome, Results, outcome
from .run import Lab, Record

PROGRAM = "machine_library"
DOCS = ROOT / "docs"
RESULTS = Path(__file__).with_name("results.json")
EXAMPLES = """examples:
  scripts/machine_library                                   all machines, then docs/machine_library.md
  scripts/machine_library --quick                           a few points of each machine, printed
  scripts/machine_library --machines krause_50hp,ong_20hp --methods foc --periods 100
  scripts/machine_library --points 10                       more speeds in each cell, printed
  scripts/machine_library --parts reversals,starts,sags     full torque reversed, starts through standstill, sags
  scripts/machine_library --random 50 --seed 7              machines at random, 0.25 to 200 kW, 48 to 690 V, printed
  scripts/machine_library --honest --methods foc,dtc        dead time, drops, saturation and real sensors, identified
  scripts/machine_library --from scripts/studies/machine_library/results.json  no runs: picture and page again

Nothing is set but machine, link, method, control period and sensors: the drive is the shipped one. A point is right,
derated (less torque, and the drive says so), refused in a sentence, tripped, or wrong. Exit status: 0 when no healthy
point, reversal or start tripped or was wrong, 1 when one was, 130 when interrupted."""
PARTS = ("points", "faults", *scenarios.NAMES)
FLAGS, LISTS, NUMBERS = ("honest", "quick"), ("machines", "methods", "periods", "parts"), ("random", "points")


def parse_arguments(arguments: list[str]) -> argparse.Namespace:
    parser = parser_of(
        PROGRAM, "Measures the shipped drive on every published machine, method and control period.", EXAMPLES
    )
    parser.add_argument("--quick", action="store_true", help="a few points of each machine, printed; no page")
    parser.add_argument("--machines", type=words, metavar="A,B", help="these alone, printed; no page (default: all)")
    parser.add_argument(
        "--random", type=from_one, metavar="N", help="so many machines made at random, by the seed; no page"
    )
    parser.add_argument(
        "--honest", action="store_true", help="on a plant with the errors of a real one, identified, printed; no page"
    )
    parser.add_argument("--methods", type=words, metavar="A,B", help="these alone, printed; no page (default: all)")
    parser.add_argument("--periods", type=words, metavar="US,US", help="these alone, printed; no page (default: all)")
    parser.add_argument(
        "--points", type=from_one, metavar="N", help=f"of each cell (default: {POINTS_A_CELL}); no page"
    )
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="of points and random machines (default: 1)")
    parser.add_argument("--parts", type=words, metavar="A,B", help=f"of {', '.join(PARTS)}: these alone; no page")
    parser.add_argument("--from", dest="source", type=Path, metavar="FILE", help="no runs: the page from these results")
    parser.add_argument("--out", type=Path, metavar="DIR", help="results, picture and page (default: docs)")
    add_runs(parser)
    options = parser.parse_args(arguments)
    if options.random and options.machines:
        parser.error("--random: the machines are made at random; leave --machines out")
    if options.honest and (options.parts or options.random):
        parser.error("--honest: has the points of the published machines alone, no --parts and no --random")
    options.is_of_page = not any(getattr(options, name) for name in (*FLAGS, *LISTS, *NUMBERS))
    return options


def command_of(options: argparse.Namespace) -> str:
    """That makes the same results."""
    given = {f"--{name}": getattr(options, name) for name in (*FLAGS, *LISTS, *NUMBERS)}
    given["--seed"] = options.seed if options.seed != 1 else None
    found = [f"scripts/{PROGRAM}"]
    for option, value in given.items():
        if value:
            words = [] if value is True else [",".join(value) if isinstance(value, list) else str(value)]
            found += [option, *words]
    return " ".join(found)


def outcomes(lab: Lab, plan: list[Point], records: list[Record]) -> list[Outcome]:
    return [
        outcome(record, point, lab.machines[point.cell.machine], lab.configuration(point))
        for record, point in zip(records, plan, strict=True)
    ]


def measure_points(lab: Lab, plan: list[Point], jobs: int) -> list[Outcome]:
    lab.configure(plan, jobs)
    return outcomes(lab, plan, lab.run([(p, {}) for p in plan], jobs, progress_of(len(plan), "healthy", PROGRAM)))


def measure_honest(lab: Lab, plan: list[Point], jobs: int) -> list[Outcome]:
    lab.configure(plan, jobs)
    settings, refused = machine_library_honest.settings_of(lab, plan, lab.directory, jobs)
    keys = [(p.cell.machine, p.cell.period_us) for p in plan]
    ready = [(p, settings[key]) for p, key in zip(plan, keys, strict=True) if key in settings]
    found = iter(lab.run(ready, jobs, progress_of(len(ready), "honest", PROGRAM)))
    records = [
        next(found) if key in settings else {"key": point.key, "refusal": refused.get(key, lab.configuration(point))}
        for point, key in zip(plan, keys, strict=True)
    ]
    return outcomes(lab, plan, records)


def measure_scenario(lab: Lab, name: str, options: argparse.Namespace, methods: list[str]) -> list[dict]:
    periods = [int(p) for p in options.periods or scenarios.PERIODS_US]
    cases = scenarios.cases(name, lab.machines, methods, periods)
    if options.quick:
        cases = scenarios.spread(cases, scenarios.QUICK_CASES)
    return scenarios.measure(lab, cases, options.jobs, progress_of(len(cases), name, PROGRAM))


def planned(of: list[Cell], options: argparse.Namespace) -> list[Point]:
    every = points(of, options.seed, options.points or POINTS_A_CELL)
    return quick_points(every, options.seed) if options.quick else every


def measure(options: argparse.Namespace) -> Results:
    work = made(OUT / PROGRAM)
    parts = chosen("--parts", options.parts, list(PARTS))
    machines = (
        random_points.drawn(options.random, options.seed, work / "machines")
        if options.random
        else chosen_machines(options.machines)
    )
    methods = chosen("--methods", options.methods, list(METHODS))
    periods = [int(p) for p in chosen("--periods", options.periods, [str(p) for p in PERIODS_US])]
    lab = Lab(mil_program.find(options.mil), machines, work)
    rows = [
        {"id": m.id, "name": m.name, "power_w": m.power_w, "voltage": m.voltage, "poles": m.poles} for m in machines
    ]
    results = Results("", "", options.seed, command_of(options), rows, [])
    if options.honest:
        of_honest = [int(p) for p in options.periods or machine_library_honest.PERIODS_US]
        plan = planned(cells(machines, methods, of_honest, machine_library_honest.SENSORS), options)
        results.outcomes = measure_honest(lab, plan, options.jobs)
        parts = []
    if "points" in parts:
        plan = planned(cells(machines, methods, periods), options)
        results.outcomes = measure_points(lab, plan, options.jobs)
    if "faults" in parts:
        cases = faults.cases(lab.machines, methods, options.quick)
        results.faults = faults.measure(lab, cases, options.jobs, progress_of(len(cases), "faults", PROGRAM))
    for name in scenarios.NAMES:
        if name in parts:
            results.scenarios += measure_scenario(lab, name, options, methods)
    results.version, results.commit = lab.version, lab.commit
    return results


def main(arguments: list[str]) -> int:
    options = parse_arguments(arguments)
    began = time.monotonic()
    results = json_file.read(options.source, Results, PROGRAM) if options.source else measure(options)
    print(page.text(results))
    directory = made(options.out or (DOCS if options.is_of_page else OUT / PROGRAM))
    if not options.source:
        print(f"{PROGRAM}: {(time.monotonic() - began) / 60:.3g} minutes")
        file = RESULTS if directory == DOCS else directory / "machine_library.json"
        json_file.write(file, results)
        print(file)
    if options.source or options.is_of_page:
        print(*page.write(results, directory), sep="\n")
    return 1 if results.not_right or scenarios.not_right(results.scenarios) else 0


if __name__ == "__main__":
    run(PROGRAM, main)
