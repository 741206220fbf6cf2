"""Figures as wide as a page, and what their panels have: bands between minimum and maximum, lines, the reference."""

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..figure_style import STYLE
from .trace import Trace

EXACT, SAMPLED, REFERENCE, PAPER, THIRD = "#1b4f9c", "#e08e2b", "#111111", "#b3282d", "#3f8f5b"
MAX_POINTS = 3000
TORQUE = "torque_{}_nm"  # of `band`
SHEET_STYLE = STYLE | {"axes.xmargin": 0.0, "legend.fontsize": 9, "lines.linewidth": 1.3}


def sheet(rows: int, columns: int = 1, height: float = 4.0, **options) -> tuple[Figure, np.ndarray]:
    """A figure as wide as a page; its panels as an array."""
    plt.rcParams.update(SHEET_STYLE)
    return plt.subplots(rows, columns, figsize=(9.2, height), squeeze=False, **options)


def save(figure: Figure, file: Path) -> None:
    figure.savefig(file)
    plt.close(figure)


def thinned(trace: Trace, low: str, high: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """End, minimum and maximum of at most MAX_POINTS blocks: no peak is lost, and none stands before its time."""
    size = -(-len(trace.t_s) // MAX_POINTS)
    starts = np.arange(0, len(trace.t_s), size)
    ends = np.append(starts[1:], len(trace.t_s)) - 1
    return (trace.t_s[ends], np.minimum.reduceat(trace[low], starts), np.maximum.reduceat(trace[high], starts))


def band(axes: Axes, trace: Trace, quantity: str, colour: str, label: str, scale: float = 1.0, **options) -> None:
    """Between minimum and maximum of a quantity: `torque_{}_nm`, `flux_{}_wb` or `current_{}_a`."""
    t_s, low, high = thinned(trace, quantity.format("min"), quantity.format("max"))
    # A line of no width would vanish where minimum and maximum are close.
    axes.fill_between(t_s * scale, low, high, color=colour, linewidth=0.7, label=label, **options)


def line(axes: Axes, trace: Trace, name: str, colour: str, label: str, scale: float = 1.0, **options) -> None:
    step = -(-len(trace.t_s) // (2 * MAX_POINTS))
    axes.plot(trace.t_s[::step] * scale, trace[name][::step], color=colour, label=label, **options)


def reference(axes: Axes, trace: Trace, scale: float = 1.0, label: str = "reference") -> None:
    line(axes, trace, "torque_reference_nm", REFERENCE, label, scale, linestyle="--", linewidth=1.0)


def legend(axes: Axes, **options) -> None:
    """Above the panel, right of its title."""
    axes.legend(**({"loc": "lower right", "bbox_to_anchor": (1.0, 1.0), "ncols": 5, "borderaxespad": 0.2} | options))
