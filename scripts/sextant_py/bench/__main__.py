"""The benchmarks beside their targets: runs the stages, prints the figures, keeps them and writes the page.

A stage of your own is one more `Stage` in STAGES: a function that takes a `Lab` and returns `Figure`s."""

import argparse
import os
import sys
import time
from pathlib import Path

from sextant_py.errors import UserError, run
from sextant_py.paths import ROOT

from .figure import MISSED, NOT_MEASURED, Figure
from .lab import Lab, Stage
from .live import LIVE_STAGE
from .peers import PEERS_STAGE
from .results import PAGE, StageResult, Stages, read, terminal, write, write_page
from .speed import (
    CONTROL_STAGE,
    GROWTH_STAGE,
    INSTRUCTIONS_STAGE,
    LOOP_STAGE,
    PLANT_STAGE,
    PRECISION_STAGE,
    SCENARIOS_STAGE,
    TELEMETRY_STAGE,
)

OUT = ROOT / "out" / "bench.json"
STAGES = (
    *(CONTROL_STAGE, PLANT_STAGE, PRECISION_STAGE, LOOP_STAGE, PEERS_STAGE, TELEMETRY_STAGE, GROWTH_STAGE),
    *(LIVE_STAGE, INSTRUCTIONS_STAGE, SCENARIOS_STAGE),
)


def chosen(text: str | None) -> list[Stage]:
    """The stages of `--only a,b`, in their order; all without it."""
    known = [stage.name for stage in STAGES]
    names = known if text is None else text.split(",")
    for name in names:
        if name not in known:
            raise UserError(f'there is no stage "{name}"; the stages are {", ".join(known)}.')
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
    parser.add_argument("--out", type=Path, default=OUT)
    parser.add_argument("--add", type=Path, action="append", default=[])
    parser.add_argument("--page", type=Path, default=PAGE)
    parser.add_argument("--write-page", action="store_true")
    parser.add_argument("--judge", action="store_true")
    parser.add_argument("--report", action="store_true")
    parser.add_argument("--list", action="store_true")
    return parser.parse_args(argv)


def main(argv: list[str]) -> int:
    arguments = parse_arguments(argv)
    if arguments.list:
        for stage in STAGES:
            print(f"{stage.name:<14} {stage.title} (about {stage.seconds:.0f} s)")
        return 0
    wanted = [] if arguments.report else chosen(arguments.only)
    now: Stages = {}
    for file in arguments.add:
        now |= read(file)
    # A part of the stages is added to what the file holds; a run of all of them starts anew.
    whole = arguments.only is None and not arguments.report
    stages = {} if whole or not arguments.out.exists() else read(arguments.out)
    lab = Lab(out=arguments.out.parent / "bench")
    for stage in wanted:
        now[stage.name] = measure(stage, lab)
        write(arguments.out, stages | now)  # what is measured is not lost with a later stage
    stages |= now
    if not stages:
        raise UserError(f"{arguments.out} holds no figures yet; run scripts/bench.")
    order = [stage.name for stage in STAGES]
    stages = {name: stages[name] for name in sorted(stages, key=lambda n: order.index(n) if n in order else len(order))}
    write(arguments.out, stages)
    shown = stages if arguments.report else {name: stages[name] for name in stages if name in now}
    print(terminal(shown))
    if arguments.write_page:
        write_page(arguments.page, stages, lab.out)
    figures = [figure for stage in shown.values() for figure in stage.figures]
    for verdict in (NOT_MEASURED, MISSED):
        for figure in figures:
            if figure.verdict == verdict:
                print(f"bench: {verdict}: {figure.measure}{f': {figure.note}' if figure.note else ''}")
    return 1 if arguments.judge and any(figure.verdict == MISSED for figure in figures) else 0


if __name__ == "__main__":
    run("bench", main)
