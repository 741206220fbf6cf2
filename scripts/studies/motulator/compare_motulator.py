"""Runs Sextant's and motulator's field-oriented control on one machine, and writes docs/motulator.md."""

import argparse
from pathlib import Path

from sextant_py import mil_program
from sextant_py.errors import run
from sextant_py.paths import OUT, ROOT
from sextant_py.program_arguments import add_runs, parser_of

from studies import json_file
from studies.bench import peer_python
from studies.command import made
from studies.parallel import progress_of
from studies.torque_map import drive as torque_map_drive

from . import cases as motulator_cases
from . import page
from .measure import LIMIT_PERCENT, Bench, Results

PROGRAM = "compare_motulator"
DOCS = ROOT / "docs"
RESULTS = Path(__file__).with_name("results.json")
EXAMPLES = """examples:
  scripts/compare_motulator            every operating point, then docs/motulator.md
  scripts/compare_motulator --quick    two operating points, printed
  scripts/compare_motulator --page     no runs: picture and page from results.json

The first run installs motulator from PyPI into .cache/peers-venv (scripts/requirements-peers.txt). Exit status: 0 when
every measured steady state agrees within the limit of the page, 1 when one does not or a run failed, 130 when
interrupted."""


def parse_arguments(arguments: list[str]) -> argparse.Namespace:
    parser = parser_of(PROGRAM, "Runs Sextant's and motulator's field-oriented control on one machine.", EXAMPLES)
    size = parser.add_mutually_exclusive_group()
    size.add_argument("--quick", action="store_true", help="two operating points, printed; no page")
    size.add_argument("--page", action="store_true", help="picture and page from the results that are there")
    add_runs(parser)
    return parser.parse_args(arguments)


def measure(options: argparse.Namespace) -> Results:
    mil = mil_program.find(options.mil)
    work = made(OUT / "motulator")
    drive = torque_map_drive.load("shipped", mil, work)
    plant = motulator_cases.Plant.of(drive)
    bench = Bench(mil, work / "shipped.toml", peer_python.install(), plant)
    cases = motulator_cases.cases(motulator_cases.QUICK_PLAN if options.quick else motulator_cases.PLAN)
    records = bench.run(cases, options.jobs, progress_of(len(cases), "both drives", PROGRAM))
    return Results(drive.version, drive.commit, bench.motulator_version, plant.__dict__, records, bench.curves)


def main(arguments: list[str]) -> int:
    options = parse_arguments(arguments)
    results = json_file.read(RESULTS, Results, PROGRAM) if options.page else measure(options)
    if options.quick:
        print(page.text(results))
    else:
        if not options.page:
            json_file.write(RESULTS, results)
        print(*page.write(results, DOCS), sep="\n")
    apart = results.apart()
    for record, quantity in apart:
        print(f"{record.name}: {quantity} differs by {record.difference(quantity):.2f} %, beyond {LIMIT_PERCENT:g} %")
    return 1 if apart and not options.page else 0


if __name__ == "__main__":
    run(PROGRAM, main)
