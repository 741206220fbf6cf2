"""The picture of the study over the library of machines."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from sextant_py.control_methods import METHODS

from studies.picture import picture

from .points import PERIODS_US, SPEEDS
from .results import Outcome, Results, grouped

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def shares(results: Results, row: Callable[[Outcome], object], column: Callable[[Outcome], object],
           rows: list, columns: list) -> list[list[float]]:  # fmt: skip
    """Of the points that are not right, in percent; not a number where there are none."""
    found = grouped(results.outcomes, lambda one: (row(one), column(one)))
    own = [[found.get((r, c), []) for c in columns] for r in rows]
    return [[100 * sum(not one.is_right for one in cell) / len(cell) if cell else math.nan for cell in line]
            for line in own]  # fmt: skip


def border_cells(axes: Axes, rows: int, columns: int) -> None:
    """Cells of one colour are told apart, too."""
    axes.set_xticks([place - 0.5 for place in range(1, columns)], minor=True)
    axes.set_yticks([place - 0.5 for place in range(1, rows)], minor=True)
    axes.grid(which="minor", color="#ffffff", alpha=1, linewidth=1.5)
    axes.tick_params(which="minor", length=0)


def draw(results: Results, file: Path) -> None:
    machines = [machine["id"] for machine in results.machines]
    panels = (
        (machines, list(METHODS), lambda o: o.machine, lambda o: o.method, [m["name"] for m in results.machines],
         list(METHODS), "", "by machine and method"),
        (list(PERIODS_US), list(SPEEDS), lambda o: o.period_us, lambda o: abs(o.speed),
         [f"{p} µs" for p in PERIODS_US], [f"{s:g}" for s in SPEEDS], "speed by base speed",
         "by control period and speed"),
    )  # fmt: skip
    with picture(file, 1, 2, (11, 4.8), {"axes.grid": False}, width_ratios=(1.1, 1)) as (figure, (axes,)):
        for ax, (rows, columns, row, column, row_names, column_names, label, title) in zip(axes, panels, strict=True):
            grid = shares(results, row, column, rows, columns)
            image = ax.imshow(grid, aspect="auto", cmap="magma_r", vmin=0, vmax=100)
            ax.set_yticks(range(len(rows)), row_names)
            ax.set_xticks(
                range(len(columns)),
                column_names,
                rotation=45 if not label else 0,
                ha="right" if not label else "center",
            )
            ax.set_xlabel(label)
            ax.set_title(title)
            border_cells(ax, len(rows), len(columns))
        figure.colorbar(image, ax=axes, label="points not right [%]")
        figure.suptitle(
            f"{len(results.not_right)} of {len(results.outcomes)} healthy points are not right", x=0.01, ha="left"
        )
