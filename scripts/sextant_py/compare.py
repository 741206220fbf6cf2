"""Compares two runs of sextant-mil metric by metric, each within its tolerance."""

import argparse
import sys
from pathlib import Path

from . import comparison_report as report
from .comparison import OUT, Tolerances, compare, runs_of
from .errors import UserError, run

REFUSED = 2

EXAMPLES = """examples:
  scripts/compare out/before out/after
  scripts/compare out/before out/after --tolerance torque_ripple_pp_nm=5% --tolerance torque_bias_nm=0.1
  scripts/compare out/before out/after --tolerances limits.toml --junit out/compare.xml
  scripts/compare out/before out/after --markdown >>"$GITHUB_STEP_SUMMARY"

A and B are a result directory, a summary.json, or a directory of result directories, whose scenarios are matched by
name. A tolerance is a share of A's value (5%), an amount in the metric's unit (0.1) or "ignore". Near zero a share is
of a hundredth of the largest metric of that unit. Faults are compared by order and time. A file has
  default = "1%"
  [metrics]
  torque_ripple_pp_nm = "5%"
  torque_bias_nm = 0.1
Without one: 1% of A's value; 1e-3 for fault_s, a fault's time; energy_unaccounted 1e-4; wall_s and realtime_factor,
which depend on the machine, are ignored. Exit status: 0 when all values agree, 1 when one is out of tolerance, 2 when
an argument or a file is wrong."""


def parse_arguments(arguments: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="compare",
        description="Compares two runs metric by metric, each within its tolerance.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("first", type=Path, metavar="A", help="the run that counts as right")
    parser.add_argument("second", type=Path, metavar="B", help="the run that is compared with it")
    parser.add_argument(
        "--tolerance",
        action="append",
        default=[],
        metavar="NAME=T",
        help="of a metric, or of all others by the name default",
    )
    parser.add_argument("--tolerances", type=Path, metavar="FILE.toml", help="tolerances from a file")
    form = parser.add_mutually_exclusive_group()
    form.add_argument("--markdown", action="store_true", help="print tables as GitHub shows them")
    form.add_argument("--json", action="store_true", help="print JSON")
    parser.add_argument("--junit", type=Path, metavar="FILE", help="also write a JUnit file")
    return parser.parse_args(arguments)


def perform(options: argparse.Namespace) -> int:
    tolerances = Tolerances()
    if options.tolerances:
        tolerances.read(options.tolerances)
    for setting in options.tolerance:
        tolerances.add(setting)
    rows = compare(runs_of(options.first), runs_of(options.second), tolerances)
    if options.json:
        print(report.as_json(rows))
    elif options.markdown:
        print(report.markdown(rows), end="")
    else:
        report.print_table(rows)
    if options.junit:
        report.write_junit(rows, options.junit)
    return int(any(row.result == OUT for row in rows))


def main(arguments: list[str]) -> int:
    try:
        return perform(parse_arguments(arguments))
    except UserError as error:
        print(f"compare: {error}", file=sys.stderr)
        return REFUSED


if __name__ == "__main__":
    run("compare", main)
