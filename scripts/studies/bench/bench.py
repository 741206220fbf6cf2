"""The benchmarks beside their targets: runs the stages, prints the figures, keeps them and writes the page.

A stage of your own is one more `Stage` in STAGES: a function that takes a `Lab` and returns `Figure`s."""

import argparse
import os
import sys
import time
from pathlib import Path

from sextant_py import errors
from sextant_py.errors import UserError
from sextant_py.paths import ROOT

from studies import command
from studies.origin import Origin

from .figure import MISSED, NOT_MEASURED, Figure
from .lab import Lab, Stage
from .live import LIVE_STAGE
from .peers import PEERS_STAGE
from .results import PAGE, PLOTS, Run, StageResult, read, terminal, write, write_page
from .speed import (
    CONTROL_STAGE,
    GROWTH_STAGE,
    INSTRUCTIONS_STAGE,
    LOOP_STAGE,
    METHODS_STAGE,
    PLANT_STAGE,
    PRECISION_STAGE,
    SCENARIOS_STAGE,
    TELEMETRY_STAGE,
)

OUT = ROOT / "out" / "bench.json"
OUT_OF_SOME = ROOT / "out" / "bench_some.json"  # of a run with --only
STAGES = (
    *(CONTROL_STAGE, PLANT_STAGE, PRECISION_STAGE, LOOP_STAGE, METHODS_STAGE, PEERS_STAGE, TELEMETRY_STAGE),
    *(GROWTH_STAGE, LIVE_STAGE, INSTRUCTIONS_STAGE, SCENARIOS_STAGE),
)


def chosen(text: str | None) -> list[Stage]:
    """The stages of `--only a,b`, in their order; all without it."""
    names = command.chosen("--only", text and text.split(","), [stage.name for stage in STAGES])
    return [stage for stage in STAGES if stage.name in names]


def measure(stage: Stage, lab: Lab) -> StageResult:
    print(f"{stage.name}: {stage.title} (about {stage.seconds:.0f} s)", file=sys.stderr, flush=True)
    lab.begin(stage)
    began, load = time.monotonic(), os.getloadavg()[0]
    try:
        figures = stage.run(lab)
    except Exception as error:  # whatever it is, the other stages still count
        figures = [Figure(f"stage {stage.name}").failed(error)]
    seconds = round(time.monotonic() - began, 1)
    return StageResult(stage.title, figures, seconds, round(load, 2), lab.distributions)


def parse_arguments(argv: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="bench", description=__doc__)
    parser.add_argument("--only")
    parser.add_argument("--out", type=Path)
    parser.add_argument("--page", type=Path, default=PAGE)
    parser.add_argument("--write-page", action="store_true")
    parser.add_argument("--judge", action="store_true")
    parser.add_argument("--report", action="store_true")
    parser.add_argument("--list", action="store_true")
    arguments = parser.parse_args(argv)
    arguments.out = arguments.out or (OUT_OF_SOME if arguments.only else OUT)
    return arguments


def measure_all(stages: list[Stage], lab: Lab, out: Path) -> Run:
    run = Run(Origin.now())
    for plot in PLOTS.values():
        (lab.out / plot).unlink(missing_ok=True)  # a picture is of the same run
    for stage in stages:
        run.stages[stage.name] = measure(stage, lab)
        write(out, run)  # what is measured is not lost with a later stage
    return run


def refuse_part(run: Run, file: Path) -> None:
    """The page is of one whole run."""
    if missing := [stage.name for stage in STAGES if stage.name not in run.stages]:
        raise UserError(f"the page takes a whole run, and {file} has no {', '.join(missing)}; run scripts/bench.")


def judge(run: Run) -> bool:
    """Names what is missed or was not measured; whether nothing is missed."""
    figures = [figure for stage in run.stages.values() for figure in stage.figures]
    for verdict in (NOT_MEASURED, MISSED):
        for figure in figures:
            if figure.verdict == verdict:
                print(f"bench: {verdict}: {figure.measure}{f': {figure.note}' if figure.note else ''}")
    return all(figure.verdict != MISSED for figure in figures)


def main(argv: list[str]) -> int:
    arguments = parse_arguments(argv)
    if arguments.list:
        for stage in STAGES:
            print(f"{stage.name:<14} {stage.title} (about {stage.seconds:.0f} s)")
        return 0
    stages = chosen(arguments.only)
    if arguments.write_page and len(stages) < len(STAGES):
        raise UserError("the page takes a whole run; leave --only or --write-page out.")
    lab = Lab(out=arguments.out.with_suffix(""))
    run = read(arguments.out) if arguments.report else measure_all(stages, lab, arguments.out)
    print(f"{run.origin.text}\n\n{terminal(run.stages)}")
    if arguments.write_page:
        refuse_part(run, arguments.out)
        write_page(arguments.page, run, lab.out)
    is_good = judge(run)
    return 1 if arguments.judge and not is_good else 0


if __name__ == "__main__":
    errors.run("bench", main)
