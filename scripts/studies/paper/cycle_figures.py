"""The pictures of docs/paper on the drive cycle: the paper's figures 18 to 27."""

import numpy as np
from matplotlib.axes import Axes
from sextant_py.plots.sheets import EXACT, MAX_POINTS, PAPER, TORQUE, band, reference
from sextant_py.plots.trace import Trace

from studies.picture import Sheets

from . import cycle
from .cycle import FIGURES
from .lab import Lab

ALL = Sheets()


@ALL.sheet(3, 2, 7.4, width_ratios=(3, 2), sharex="col")
def figure_18(lab: Lab, panels: np.ndarray) -> None:
    exact = cycle.cycle(lab, "linear").trace
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


def table6_cells(lab: Lab, panels: np.ndarray, title: str, label: str) -> list[tuple[Axes, Trace, float, float]]:
    """Nine panels in the order of Table 6, with trace, upper and lower band of each."""
    cells = []
    for (upper, lower), run in zip(FIGURES, cycle.table6(lab, list(FIGURES)), strict=True):
        axes = panels[cycle.BANDS.index(lower), cycle.BANDS.index(upper)]
        axes.set_title(f"Figure {FIGURES[upper, lower]}: +{upper:g} / −{lower:g} N·m", fontsize=9.5)
        cells.append((axes, run.trace, upper, lower))
    for axes in panels[-1]:
        axes.set_xlabel("Time [s]")
    for axes in panels[:, 0]:
        axes.set_ylabel(label)
    panels[0, 0].figure.suptitle(title, fontsize=11)
    return cells


@ALL.sheet(3, 3, 7.6, sharex=True, sharey=True)
def figures_19_27(lab: Lab, panels: np.ndarray) -> None:
    title = "Table 6: torque error over 100 s of NYCC (blue, left) and torque reference (black, right)"
    for axes, trace, upper, lower in table6_cells(lab, panels, title, "Torque error [N·m]"):
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


@ALL.sheet(3, 3, 7.6, sharex=True, sharey=True)
def figures_19_27_departure(lab: Lab, panels: np.ndarray) -> None:
    title = "Table 6: the first departure, torque and reference"
    for axes, trace, _, _ in table6_cells(lab, panels, title, "Torque [N·m]"):
        part = trace.between(53.5, 57.5)
        band(axes, part, TORQUE, EXACT, "torque")
        reference(axes, part)
        axes.set_ylim(-4.2, 2)
