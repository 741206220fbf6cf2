"""Runs every scenario of the paper again and writes docs/paper: numbers.json, its pictures and README.md."""

import argparse
import os
from collections.abc import Callable
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from . import (
    mil_program,
    paper_curves,
    paper_cycle,
    paper_cycle_figures,
    paper_defaults,
    paper_figures,
    paper_rise,
    paper_steady,
    paper_steps,
    paper_vehicle,
    paper_vehicle_figure,
)
from .errors import UserError, run
from .paper_lab import Lab
from .paper_numbers import Numbers, load
from .paper_page import render
from .paths import ROOT

FIGURES = paper_figures.ALL | paper_cycle_figures.ALL | paper_vehicle_figure.ALL
PICTURES = (*FIGURES, *paper_curves.ALL)
Measure = Callable[[Lab, Numbers, bool], None]

MEASURES: tuple[Measure, ...] = (
    paper_defaults.measure_defaults,
    paper_steps.measure_steps,
    paper_steps.measure_constant_torque,
    paper_steps.measure_reversal,
    paper_rise.measure_smooth,
    paper_rise.measure_dead_zone,
    paper_steps.measure_high_torque,
    paper_steps.measure_negative,
    paper_steady.measure_halving,
    paper_steady.measure_ripple,
    paper_steady.measure_frequency,
    paper_cycle.measure_cycle,
    paper_vehicle.measure_vehicle,
    paper_cycle.measure_table6,
)


def parser_of(program: str, description: str) -> argparse.ArgumentParser:
    """With the arguments of both programs."""
    parser = argparse.ArgumentParser(
        prog=program,
        description=description,
        epilog=f"examples:\n  scripts/{program}\n  scripts/{program} --jobs 2",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    jobs = "runs at a time (default: all cores)"
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), metavar="N", help=jobs)
    parser.add_argument("--mil", type=Path, metavar="PATH", help="sextant-mil to use (default: that of build/release)")
    return parser


def parse_arguments(arguments: list[str]) -> argparse.Namespace:
    parser = parser_of("paper_report", "Runs every scenario of the paper again and writes numbers, pictures and page.")
    parser.add_argument("--quick", action="store_true", help="a few numbers only, no pictures, no page")
    parser.add_argument("--page", action="store_true", help="no runs: the page again from numbers.json")
    where = "where to write (default: docs/paper; with --quick out/paper)"
    parser.add_argument("--out", type=Path, metavar="DIR", help=where)
    options = parser.parse_args(arguments)
    if options.jobs < 1:
        raise UserError("--jobs: at least one.")
    options.out = options.out or ROOT / ("out/paper" if options.quick else "docs/paper")
    return options


def measure(lab: Lab, numbers: Numbers, quick: bool, step: Callable[[str], None]) -> None:
    for function in MEASURES:
        step(function.__name__.removeprefix("measure_").replace("_", " "))
        function(lab, numbers, quick)


def draw(lab: Lab, numbers: Numbers, out: Path, step: Callable[[str], None]) -> None:
    for name, figure in FIGURES.items():
        step(name.replace("_", " "))
        figure(lab, out / f"{name}.png")
    for name, curve in paper_curves.ALL.items():
        step(name.replace("_", " "))
        curve(numbers, out / f"{name}.png")


def write_page(out: Path) -> None:
    (out / "README.md").write_text(render(load(out / "numbers.json")), encoding="utf-8")


def report(lab: Lab, out: Path, quick: bool) -> None:
    numbers = Numbers()
    columns = (TextColumn("{task.description:<26}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True)) as progress:
        pictures = 0 if quick else len(PICTURES)
        task = progress.add_task("", total=len(MEASURES) + pictures)

        def step(name: str) -> None:
            progress.update(task, description=name, completed=step.done)
            step.done += 1

        step.done = 0
        measure(lab, numbers, quick, step)
        if not quick:
            draw(lab, numbers, out, step)
        progress.update(task, description="done", completed=step.done)
    numbers.save(out / "numbers.json")
    if not quick:
        write_page(out)
    print(f"{len(numbers.entries)} numbers: {out / 'numbers.json'}")


def main(arguments: list[str]) -> int:
    options = parse_arguments(arguments)
    try:
        options.out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UserError(f"--out: {options.out} cannot be made: {error.strerror}.") from None
    if options.page:
        write_page(options.out)
        return 0
    with Lab(mil_program.find(options.mil), options.jobs) as lab:
        report(lab, options.out, options.quick)
    return 0


if __name__ == "__main__":
    run("paper_report", main)
