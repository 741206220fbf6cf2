"""The pictures of docs/paper on the drive cycle: the paper's figures 18 to 27."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from sextant_py.plots.sheets import EXACT, MAX_POINTS, PAPER, TORQUE, band, reference, save, sheet
from sextant_py.plots.trace import Trace

from . import cycle
from .cycle import FIGURES
from .lab import Lab


def figure_18(lab: Lab, file: Path) -> None:
    exact = cycle.cycle(lab, "linear").trace
    figure, panels = sheet(3, 2, 7.4, width_ratios=(3, 2), sharex="col")
    rows = (
        ("torque_{}_nm", "Torque [N·m]"),
        ("flux_{}_wb", "Stator flux [Wb]"),
        ("current_{}_a", "Current vector [A]"),
    )
    parts = (exact, exact.between(*cycle.FIRST_S))
    for (quantity, label), row in zip(rows, panels, strict=True):
        for axes, part in zip(row, parts, strict=True):
            band(axes, part, quantity, EXACT, "event-exact")
        row[0].set_ylabel(label)
    for axes, part in zip(panels[0], parts, strict=True):
        reference(axes, part)
    panels[0, 0].set_title("NYCC, 598 s, table extended linearly")
    panels[0, 1].set_title("First departure")
    panels[0, 0].legend(loc="upper left", ncols=2)
    panels[0, 0].set(xlim=(0, 598), ylim=(-16, 40))
    for axes in panels[-1]:
        axes.set_xlabel("Time [s]")
    save(figure, file)


def table6_sheet(lab: Lab, title: str, label: str) -> tuple[Figure, list[tuple[Axes, Trace, float, float]]]:
    """Nine panels in the order of Table 6, with trace, upper and lower band of each."""
    runs = cycle.table6(lab, list(FIGURES))
    figure, panels = sheet(3, 3, 7.6, sharex=True, sharey=True)
    cells = []
    for (upper, lower), run in zip(FIGURES, runs, strict=True):
        axes = panels[cycle.BANDS.index(lower), cycle.BANDS.index(upper)]
        axes.set_title(f"Figure {FIGURES[upper, lower]}: +{upper:g} / −{lower:g} N·m", fontsize=9.5)
        cells.append((axes, run.trace, upper, lower))
    for axes in panels[-1]:
        axes.set_xlabel("Time [s]")
    for axes in panels[:, 0]:
        axes.set_ylabel(label)
    figure.suptitle(title, fontsize=11)
    return figure, cells


def figures_19_27(lab: Lab, file: Path) -> None:
    title = "Table 6: torque error over 100 s of NYCC (blue, left) and torque reference (black, right)"
    figure, cells = table6_sheet(lab, title, "Torque error [N·m]")
    for axes, trace, upper, lower in cells:
        part = trace.between(cycle.START_S, 100)
        size = -(-len(part.t_s) // MAX_POINTS)
        starts = np.arange(0, len(part.t_s), size)
        low, high = part.error
        axes.fill_between(
            part.t_s[starts],
            np.minimum.reduceat(low, starts),
            np.maximum.reduceat(high, starts),
            color=EXACT,
            linewidth=0.5,
        )
        for limit in (-upper, lower):
            axes.axhline(limit, color=PAPER, linewidth=0.9, linestyle=":")
        axes.set(xlim=(0, 100), ylim=(-1.4, 1.4))
        torque = axes.twinx()
        reference(torque, part)
        torque.set_ylim(-32, 32)
        torque.grid(visible=False)
        if axes.get_subplotspec().is_last_col():
            torque.set_ylabel("Reference [N·m]")
        else:
            torque.set_yticklabels([])
    save(figure, file)


def figures_19_27_departure(lab: Lab, file: Path) -> None:
    figure, cells = table6_sheet(lab, "Table 6: the first departure, torque and reference", "Torque [N·m]")
    for axes, trace, _, _ in cells:
        part = trace.between(53.5, 57.5)
        band(axes, part, TORQUE, EXACT, "torque")
        reference(axes, part)
        axes.set_ylim(-4.2, 2)
    save(figure, file)


ALL: dict[str, Callable[[Lab, Path], None]] = {
    "figure_18": figure_18,
    "figures_19_27": figures_19_27,
    "figures_19_27_departure": figures_19_27_departure,
}
