"""Runs every scenario of the paper again and writes docs/paper: numbers.json, its pictures and README.md."""

import argparse
from collections.abc import Callable
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from sextant_py import mil_program, program_arguments
from sextant_py.errors import run
from sextant_py.paths import ROOT

from studies.command import made

from . import curves, cycle, cycle_figures, defaults, figures, rise, steady, steps, vehicle, vehicle_figure
from .lab import Lab
from .numbers import Numbers
from .page import render

FIGURES = figures.ALL | cycle_figures.ALL | vehicle_figure.ALL
PICTURES = (*FIGURES, *curves.ALL)
Measure = Callable[[Lab, Numbers, bool], None]

MEASURES: tuple[Measure, ...] = (
    defaults.measure_defaults,
    steps.measure_steps,
    steps.measure_constant_torque,
    steps.measure_reversal,
    rise.measure_smooth,
    rise.measure_dead_zone,
    steps.measure_high_torque,
    steps.measure_negative,
    steady.measure_halving,
    steady.measure_ripple,
    steady.measure_frequency,
    cycle.measure_cycle,
    vehicle.measure_vehicle,
    cycle.measure_table6,
)


NUMBERS = Path(__file__).with_name("numbers.json")


def parser_of(program: str, description: str) -> argparse.ArgumentParser:
    """With the arguments of both programs."""
    parser = program_arguments.parser_of(
        program, description, f"examples:\n  scripts/{program}\n  scripts/{program} --jobs 2"
    )
    program_arguments.add_runs(parser)
    return parser


def parse_arguments(arguments: list[str]) -> argparse.Namespace:
    parser = parser_of("paper_report", "Runs every scenario of the paper again and writes numbers, pictures and page.")
    parser.add_argument("--quick", action="store_true", help="a few numbers only, no pictures, no page")
    parser.add_argument("--page", action="store_true", help="no runs: the page again from numbers.json")
    where = "where to write, also numbers.json (default: docs/paper; with --quick out/paper)"
    parser.add_argument("--out", type=Path, metavar="DIR", help=where)
    options = parser.parse_args(arguments)
    apart = options.out or (ROOT / "out/paper" if options.quick else None)
    options.numbers = apart / NUMBERS.name if apart else NUMBERS
    options.out = apart or ROOT / "docs/paper"
    return options


def measure(lab: Lab, numbers: Numbers, quick: bool, step: Callable[[str], None]) -> None:
    for function in MEASURES:
        step(function.__name__.removeprefix("measure_").replace("_", " "))
        function(lab, numbers, quick)


def draw(lab: Lab, numbers: Numbers, out: Path, step: Callable[[str], None]) -> None:
    for name, figure in FIGURES.items():
        step(name.replace("_", " "))
        figure(lab, out / f"{name}.png")
    for name, curve in curves.ALL.items():
        step(name.replace("_", " "))
        curve(numbers, out / f"{name}.png")


def write_page(numbers: Path, out: Path) -> None:
    (out / "README.md").write_text(render(Numbers.load(numbers)), encoding="utf-8")


def report(lab: Lab, file: Path, out: Path, quick: bool) -> None:
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
    numbers.save(file)
    if not quick:
        write_page(file, out)
    print(f"{len(numbers.entries)} numbers: {file}")


def main(arguments: list[str]) -> int:
    options = parse_arguments(arguments)
    made(options.out)
    if options.page:
        write_page(options.numbers, options.out)
        return 0
    with Lab(mil_program.find(options.mil), options.jobs) as lab:
        report(lab, options.numbers, options.out, options.quick)
    return 0


if __name__ == "__main__":
    run("paper_report", main)
