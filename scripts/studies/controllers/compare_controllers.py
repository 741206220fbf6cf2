"""Measures every control method on one bench, and writes docs/controllers.md."""

import argparse
from pathlib import Path

from sextant_py import mil_program
from sextant_py.errors import run
from sextant_py.paths import OUT, ROOT
from sextant_py.program_arguments import add_runs, parser_of

from studies import json_file
from studies.command import chosen, made, words
from studies.parallel import progress_of
from studies.torque_map import drive as torque_map_drive

from . import cases as controller_cases
from . import cost, page, step
from .measure import Bench, Record, Results, common_period, methods

PROGRAM = "compare_controllers"
DOCS = ROOT / "docs"
RESULTS = Path(__file__).with_name("results.json")
EXAMPLES = """examples:
  scripts/compare_controllers                        every method, then docs/controllers.md
  scripts/compare_controllers --quick                a few points of each, printed
  scripts/compare_controllers --methods dtc,deadbeat --quick
  scripts/compare_controllers --page                 no runs: pictures and page from results.json

Every method runs on the drive of configs/ecu.toml with its estimator, protections and torque monitor, and one period of
actuation delay; only control.controller changes, and in one section the control period. Exit status: 0 when every run
has figures, 1 when one tripped or was refused, 130 when interrupted."""


def parse_arguments(arguments: list[str]) -> argparse.Namespace:
    parser = parser_of(PROGRAM, "Measures every control method on one bench.", EXAMPLES)
    size = parser.add_mutually_exclusive_group()
    size.add_argument("--quick", action="store_true", help="a few points, printed; no page")
    size.add_argument("--page", action="store_true", help="pictures and page from the results that are there")
    parser.add_argument("--methods", type=words, metavar="A,B", help="these alone, printed; no page (default: all)")
    add_runs(parser)
    return parser.parse_args(arguments)


def measure(options: argparse.Namespace) -> Results:
    mil = mil_program.find(options.mil)
    work = made(OUT / "controllers")
    drive = torque_map_drive.load("shipped", mil, work)
    bench = Bench(mil, drive, work, options.jobs)
    names = chosen("--methods", options.methods, methods(mil, bench.scenario))
    records: list[Record] = []

    def run_all(title: str, cases: list) -> None:
        records.extend(bench.run(cases, progress_of(len(cases), title, PROGRAM)))

    run_all("periods", [case for name in names for case in controller_cases.tuning(name)])
    results = Results(drive.version, drive.commit, names, {}, records, cost.step_ns(names))
    results.step = step.measure(mil, bench.scenario)
    results.periods_us = {name: common_period(results.of("tuning", name)) for name in names}
    speeds = controller_cases.QUICK_SPEEDS if options.quick else controller_cases.SPEEDS
    torques = controller_cases.QUICK_TORQUES if options.quick else controller_cases.TORQUES
    for name in names:
        cases = controller_cases.grid("sampling", name, 25, speeds, torques)
        cases += controller_cases.grid("switching", name, results.periods_us[name], speeds, torques)
        cases += controller_cases.starts(name)
        if not options.quick:
            cases += controller_cases.detuned(name, drive) + controller_cases.cycles(name)
            cases += controller_cases.standstill(name) + controller_cases.sensorless(name)
        run_all(name, cases)
    return results


def main(arguments: list[str]) -> int:
    options = parse_arguments(arguments)
    results = json_file.read(RESULTS, Results, PROGRAM) if options.page else measure(options)
    is_of_page = not options.quick and options.methods is None
    if is_of_page:
        if not options.page:
            json_file.write(RESULTS, results)
        print(*page.write(results, DOCS), sep="\n")
    else:
        print(page.text(results))
    failed = [record for record in results.records if record.reason]
    for record in failed:
        print(f"{record.method}, {record.section}, {record.what}: {record.reason}")
    return 1 if failed else 0


if __name__ == "__main__":
    run(PROGRAM, main)
