"""Compares two runs of sextant-mil metric by metric, each within its tolerance."""

import argparse
import math
import sys
from pathlib import Path

from . import comparison_report as report
from .comparison import OUT, Row, Tolerances, compare, runs_of, shift_s
from .errors import UserError, run
from .program_arguments import finite_seconds, parser_of

EXAMPLES = """examples:
  scripts/compare out/before out/after
  scripts/compare out/before out/after --tolerance torque_ripple_pp_nm=5% --tolerance torque_bias_nm=0.1
  scripts/compare out/before out/after --tolerances limits.toml --junit out/compare.xml
  scripts/compare out/before out/after --markdown >>"$GITHUB_STEP_SUMMARY"
  scripts/compare mil/trace.h5 live.mcap --align 'rise torque_nm 20' --tolerance torque_mean_nm=2 --signal torque
  scripts/compare monday.h5 tuesday.h5 --align trigger       two captures of scripts/scope

A and B are a result directory, a summary.json, or a directory of result directories, whose scenarios are matched by
name. A tolerance is a share of A's value (5%), an amount in the metric's unit (0.1) or "ignore". Near zero a share is
of a hundredth of the largest metric of that unit. Faults are compared by order and time. A file has
  default = "1%"
  [metrics]
  torque_ripple_pp_nm = "5%"
  torque_bias_nm = 0.1
Without one: 1% of A's value; 1e-3 for fault_s, a fault's time; energy_unaccounted 1e-4; wall_s and realtime_factor,
which depend on the machine, are ignored.

With --align A and B are traces or recordings in any format, or result directories with a trace. Their times count from
the instant at which TRIGGER is first fulfilled; a trigger is what scripts/scope --help lists, of the waveform where the
file has it, else of the telemetry (torque_nm is torque_mean_nm); "trigger" alone is that of a capture. Compared are
state, quantities and faults with their times, over the time that both have; --signal names others. The instant is
known to a row, so a value of B agrees with any that A passes within that time. A share is of the largest magnitude of
the signal in A, so near zero too.

Exit status: 0 when all values agree, 1 when one is out of tolerance, 2 when
an argument or a file is wrong."""


def parse_arguments(arguments: list[str]) -> argparse.Namespace:
    parser = parser_of("compare", "Compares two runs metric by metric, each within its tolerance.", EXAMPLES)
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
    parser.add_argument("--align", metavar="TRIGGER", help="compare signals over time, both counted from this trigger")
    parser.add_argument(
        "--signal", action="append", default=[], metavar="NAME", help="with --align: to compare, as of scripts/plot"
    )
    begin, end = "begin of what is compared, from the trigger [s]", "end of it [s]"
    parser.add_argument("--from", dest="begin_s", type=finite_seconds, default=-math.inf, metavar="S", help=begin)
    parser.add_argument("--to", dest="end_s", type=finite_seconds, default=math.inf, metavar="S", help=end)
    form = parser.add_mutually_exclusive_group()
    form.add_argument("--markdown", action="store_true", help="print tables as GitHub shows them")
    form.add_argument("--json", action="store_true", help="print JSON")
    parser.add_argument("--junit", type=Path, metavar="FILE", help="also write a JUnit file")
    return parser.parse_args(arguments)


def rows_of(options: argparse.Namespace, tolerances: Tolerances) -> list[Row]:
    if options.align is None:
        if options.signal or (options.begin_s, options.end_s) != (-math.inf, math.inf):
            raise UserError("--signal, --from and --to are for --align, which compares signals over time.")
        return compare(runs_of(options.first), runs_of(options.second), tolerances)
    from . import aligned_comparison

    wish = aligned_comparison.Wish(options.align, tuple(options.signal), options.begin_s, options.end_s)
    return aligned_comparison.compare((options.first, options.second), wish, tolerances)


def perform(options: argparse.Namespace) -> int:
    tolerances = Tolerances()
    if options.tolerances:
        tolerances.read(options.tolerances)
    for setting in options.tolerance:
        tolerances.add(setting)
    rows = rows_of(options, tolerances)
    if options.json:
        print(report.as_json(rows))
    elif options.markdown:
        print(report.markdown(rows), end="")
    else:
        report.print_table(rows)
    if options.align is None and (shift := shift_s(rows, tolerances)):
        said = f"every fault of B comes {abs(shift):.3g} s {'later' if shift > 0 else 'earlier'} than in A"
        print(f"compare: {said}: --align TRIGGER compares from a common instant.", file=sys.stderr)
    if options.junit:
        report.write_junit(rows, options.junit)
    return int(any(row.result == OUT for row in rows))


def main(arguments: list[str]) -> int:
    return perform(parse_arguments(arguments))


if __name__ == "__main__":
    run("compare", main)
