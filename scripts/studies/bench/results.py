"""out/bench.json, the figures of one run; and the page made of it."""

import re
import shutil
from dataclasses import dataclass, field
from pathlib import Path

from sextant_py.errors import UserError
from sextant_py.paths import ROOT

from studies import json_file, page
from studies.origin import Origin

from .figure import MISSED, NOT_MEASURED, PUBLISHED, Figure

FORMAT = 3
PAGE = ROOT / "docs" / "performance.md"
IMAGES = ROOT / "docs" / "images"
PLOTS = {"growth": "growth.png", "live": "latency.png"}  # by stage, in the folder beside the results
PERCENTILES = ("p50_us", "p99_us", "p99.9_us")
PART = re.compile(r"^of it| beside it| loop")  # of another distribution, which the page shows, or a peer
MISSES_ALONE = ("scenarios",)  # stages whose figures the page shows where they miss their target
WITHOUT_TARGET = ("growth",)  # stages whose figures without a target the page shows too
LATENCY = (
    "\n\n![Wake-up latency beside cyclictest, and command to gate](images/latency.png)\n\n*The part that takes longer.*"
)


@dataclass
class StageResult:
    title: str
    figures: list[Figure]
    seconds: float = 0.0
    load: float = 0.0  # load average when it began
    distributions: dict[str, dict[str, float]] = field(default_factory=dict)


Stages = dict[str, StageResult]


@dataclass
class Run:
    """What one run of scripts/bench measured, and where."""

    origin: Origin
    stages: Stages = field(default_factory=dict)
    format: int = FORMAT


def read(file: Path) -> Run:
    """UserError: the file is no result of a benchmark."""
    run = json_file.read(file, Run, "bench")
    if run.format != FORMAT:
        raise UserError(f"{file} has format {run.format}, not {FORMAT}; measure again with scripts/bench.")
    return run


def write(file: Path, run: Run) -> None:
    json_file.write(file, run, levels=3)


def terminal(stages: Stages) -> str:
    lines = []
    for name, stage in stages.items():
        lines += ["", f"{name}: {stage.title}"]
        for f in stage.figures:
            verdict = "" if f.verdict == PUBLISHED else f.verdict
            note = f"  ({f.note})" if f.note else ""
            lines.append(f"  {f.measure:<86} {f.shown:>12} {f.target:>10}  {verdict}{note}")
    return "\n".join(lines[1:])


def figure_rows(stages: Stages) -> tuple[list[tuple], list[tuple]]:
    """Of the figures that were measured: those with a target, and those without that the page shows."""
    with_target, without = [], []
    for name, stage in stages.items():
        for f in stage.figures:
            measure = f"{f.measure} ({f.note})" if f.note and f.verdict == MISSED else f.measure
            target, shown = (text.replace(" x", " ×") for text in (f.target, f.shown))
            if f.verdict == NOT_MEASURED:
                continue
            if f.target and (f.verdict == MISSED or name not in MISSES_ALONE):
                missed = f", **{MISSED}**" if f.verdict == MISSED else ""
                with_target.append((measure, target, shown + missed, f"`{name}`"))
            elif not f.target and name in WITHOUT_TARGET:
                without.append((measure, shown if f.verdict == PUBLISHED else f.verdict, f"`{name}`"))
    return with_target, without


def latency(stages: Stages) -> str:
    """The distributions; empty where there are none."""
    rows = [
        (text, *(f"{summary[key]:.3g}" for key in PERCENTILES), f"{summary['max_us']:.4g}")
        for stage in stages.values()
        for text, summary in stage.distributions.items()
        if not PART.search(text)
    ]
    head = ("[µs]", "median", "99 %", "99.9 %", "longest")
    return page.table(head, rows) + LATENCY if rows else ""


def not_measured(stages: Stages) -> str:
    found = [f for stage in stages.values() for f in stage.figures if f.verdict == NOT_MEASURED]
    return "\n".join(f"- Not measured: {f.measure}: {f.note}." for f in found)


def blocks(run: Run) -> dict[str, str]:
    """By mark of the page, what stands there."""
    with_target, without = figure_rows(run.stages)
    return {
        "run": run.origin.text,
        "judged figures": page.table(("measure", "target", "figure", "stage"), with_target, (0, 3)),
        "published figures": page.table(("measure", "figure", "stage"), without, (0, 2)),
        "latency": latency(run.stages),
        "not measured": not_measured(run.stages),
    }


def write_page(file: Path, run: Run, plots: Path) -> None:
    """What this run measured and nothing else; where it is the committed page, its pictures too."""
    page.put_into(file, blocks(run))
    for stage, plot in PLOTS.items():
        if file == PAGE and stage in run.stages and (plots / plot).exists():
            shutil.copyfile(plots / plot, IMAGES / plot)
