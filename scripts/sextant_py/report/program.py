"""Makes one page for people from the results of runs, sweeps and recordings."""

import argparse
from pathlib import Path

from ..errors import UserError
from ..program_arguments import add_span, parser_of
from . import page
from .inputs import KINDS, runs_of
from .model import Settings

EXAMPLES = f"""examples:
  scripts/report out/constant_torque                        a run of sextant-mil, to report.html
  scripts/report out --out out/report.html                  every result directory in out
  scripts/report run.mcap out/junit.xml timing.json         a live recording, what was checked, the control thread
  scripts/report out/sweeps/hysteresis_band --title "Hysteresis bands"
  scripts/report capture.h5 --signal torque --signal 'i_?_a' --from -0.01 --to 0.02

RUN is {KINDS}.
The page needs no network and prints. It has verdicts, limits, faults with their times, plots, versions and what of the
configuration differs from the defaults, for which sextant-mil is asked (SEXTANT_BIN names its directory); without it
the whole configuration is shown. Exit status: 0 when the page is written, 1 when it cannot be, 2 when an argument or
a result is wrong."""


def parse_arguments(arguments: list[str]) -> argparse.Namespace:
    parser = parser_of("report", __doc__, EXAMPLES)
    parser.add_argument("runs", nargs="+", type=Path, metavar="RUN", help="results; see below")
    parser.add_argument(
        "--out", type=Path, default=Path("report.html"), metavar="FILE", help="page to write (default: report.html)"
    )
    parser.add_argument("--title", help="heading (default: Report, and the name of a single result)")
    parser.add_argument(
        "--signal", action="append", default=[], metavar="NAME", help="to draw, as scripts/plot names signals"
    )
    add_span(parser)
    parser.add_argument("--mil", type=Path, metavar="FILE", help="sextant-mil that knows the defaults")
    return parser.parse_args(arguments)


def main(arguments: list[str]) -> int:
    options = parse_arguments(arguments)
    settings = Settings(tuple(options.signal), (options.begin_s, options.end_s), options.mil)
    if options.out.suffix.lower() not in (".html", ".htm"):
        raise UserError(f"--out {options.out}: the page is HTML, so its name must end in .html.")
    if options.mil:
        _ = settings.program  # a wrong one is refused, while none at all only leaves the defaults unknown
    runs = [run for path in options.runs for run in runs_of(path, settings)]
    title = options.title or (f"Report: {runs[0].name}" if len(runs) == 1 else "Report")
    page.write(runs, title, options.out)
    print(options.out)
    return 0
