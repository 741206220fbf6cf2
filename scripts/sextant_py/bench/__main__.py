"""Runs the stages, prints the figures beside their targets, keeps them and writes the page."""

import argparse
import os
import shutil
import sys
import time
from collections.abc import Callable
from pathlib import Path

from sextant_py.errors import UserError, run
from sextant_py.paths import ROOT

from .figure import failed, report_unexpected
from .lab import Lab, Stage
from .live import write_latency
from .report import terminal, verdicts, write_page
from .results import Results, StageResult
from .stages import STAGES
from .telemetry import PLOT

PAGE = ROOT / "docs" / "performance.md"
OUT = ROOT / "out" / "bench.json"
NOTHING_KNOWN = 77  # exit status: nothing is known to be missed, and something could not be judged


def chosen(text: str | None, stages: tuple[Stage, ...]) -> list[Stage]:
    """The stages of `--only a,b`, in their order; all without it."""
    names = [stage.name for stage in stages] if text is None else text.split(",")
    known = {stage.name for stage in stages}
    for name in names:
        if name not in known:
            raise UserError(f'there is no stage "{name}"; the stages are {", ".join(s.name for s in stages)}.')
    return [stage for stage in stages if stage.name in names]


def measure(stages: list[Stage], lab: Lab, keep: Callable[[Results], None]) -> Results:
    """Every stage's figures; `keep` gets them stage by stage, so that what is measured is not lost with a later one."""
    results = Results()
    for number, stage in enumerate(stages, 1):
        print(
            f"[{number}/{len(stages)}] {stage.name}: {stage.title} (about {stage.seconds:.0f} s)",
            file=sys.stderr,
            flush=True,
        )
        lab.begin(stage)
        began, load = time.monotonic(), os.getloadavg()[0]
        try:
            figures = stage.run(lab)
        except Exception as error:  # whatever it is, the other stages still count
            report_unexpected(error)
            figures = [failed(f"stage {stage.name}", error)]
        results.stages[stage.name] = StageResult(stage.title, figures, time.monotonic() - began, load)
        keep(results)
    return results


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="bench", description=__doc__)
    parser.add_argument("--only")
    parser.add_argument("--out", type=Path, default=OUT)
    parser.add_argument("--add", type=Path, action="append", default=[])
    parser.add_argument("--page", type=Path, default=PAGE)
    parser.add_argument("--write-page", action="store_true")
    parser.add_argument("--judge", action="store_true")
    parser.add_argument("--report", action="store_true")
    parser.add_argument("--list", action="store_true")
    arguments = parser.parse_args(argv)
    if arguments.list:
        for stage in STAGES:
            print(f"{stage.name:<14} {stage.title} (about {stage.seconds:.0f} s)")
        return 0
    stages = [] if arguments.report else chosen(arguments.only, STAGES)
    added = [Results.read(file) for file in arguments.add]
    # A part of the stages is added to what the file holds; a run of all of them starts anew.
    whole = arguments.only is None and not arguments.report
    results = Results() if whole or not arguments.out.exists() else Results.read(arguments.out)
    began = time.monotonic()
    if stages:
        about = sum(stage.seconds for stage in stages) / 60
        print(f"bench: {len(stages)} stages, about {about:.1f} min on two idle processors", file=sys.stderr)

    def keep(measured: Results) -> None:
        results.add(measured)
        results.write(arguments.out)

    now = measure(stages, Lab(out=arguments.out.parent / "bench"), keep)
    for other in added:
        now.add(other)
    keep(now)
    if not results.stages:
        raise UserError(f"{arguments.out} holds no figures yet; run scripts/bench.")
    everything = results.in_order([stage.name for stage in STAGES])
    names = list(results.stages if arguments.report else now.stages)
    print(terminal([(name, stage) for name, stage in everything if name in names]))
    if arguments.write_page:
        write_page(arguments.page, everything)
        write_latency(arguments.page, arguments.out.parent / "bench", copy_plot=arguments.page == PAGE)
        plot = arguments.out.parent / "bench" / "growth.png"
        if "growth" in results.stages and plot.exists() and arguments.page == PAGE:
            shutil.copyfile(plot, PLOT)
    missed, accepted, not_judged = verdicts(results, names)
    counts = f"{len(missed)} missed, {len(accepted)} missed as accepted, {len(not_judged)} not judged"
    print(f"\nbench: {(time.monotonic() - began) / 60:.1f} min; {counts}")
    for text in not_judged:
        print(f"!!! NOT JUDGED: {text} !!!")
    for text in accepted:
        print(f"bench: missed as accepted: {text}")
    for text in missed:
        print(f"bench: MISSED: {text}")
    if not arguments.judge:
        return 0
    return 1 if missed else NOTHING_KNOWN if not_judged else 0


if __name__ == "__main__":
    run("bench", main)
