"""Panels as a picture of matplotlib."""

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ..errors import UserError
from ..figure_style import STYLE
from .panels import Line, Panel

MOST_POINTS = 2000  # of a line
COLOURS = 10
WIDTH_IN, PANEL_IN = 11.0, 2.6
DASHES = ("-", "--", ":", "-.")  # once the colours are used up
TALL = 2.0  # distance of the states of discrete signals


def style_of(number: int) -> tuple[str, str]:
    """Colour and dash of a line of a panel."""
    return f"C{number % COLOURS}", DASHES[number // COLOURS % len(DASHES)]


def save(figure: Figure, output: Path) -> None:
    try:
        output.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(output)
    except (OSError, ValueError) as error:
        raise UserError(f"the plot {output} cannot be written: {getattr(error, 'strerror', None) or error}.") from None
    finally:
        plt.close(figure)


def sheet(rows: int, title: str, **options: object) -> tuple[Figure, list[Axes]]:
    plt.rcParams.update(STYLE)
    size = (WIDTH_IN, 1.2 + PANEL_IN * rows)
    figure, axes = plt.subplots(rows, 1, squeeze=False, figsize=size, **options)
    figure.suptitle(title, fontsize=13)
    return figure, list(axes[:, 0])


def legend(axes: Axes) -> None:
    """Above the panel where it is short, below it where it is long."""
    labels = axes.get_legend_handles_labels()[1]
    if not labels:
        return
    if sum(map(len, labels)) < 70 and len(labels) <= 4:
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, fontsize=9, borderaxespad=0.2)
    else:
        axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize=8.5, borderaxespad=0.2)


def draw_line(axes: Axes, line: Line, number: int) -> None:
    time_s, value, low, high = line.points(MOST_POINTS)
    colour, style = style_of(number)
    if low is not None:
        axes.fill_between(time_s, low, high, color=colour, alpha=0.25, linewidth=0)
    axes.plot(time_s, value, style, color=colour, linewidth=1.1, label=line.label)


def draw_states(axes: Axes, lines: list[Line]) -> None:
    """One signal by its values; several above each other, each from its smallest value to its largest."""
    alone = len({line.series.name for line in lines}) == 1
    marks: dict[str, float] = {}
    base = 0.0
    for number, line in enumerate(lines):
        values = line.series.values.astype(float)
        if not alone and line.series.name not in marks:
            marks[line.series.name] = base
            base += values.max() - values.min() + TALL
        offset = 0.0 if alone else marks[line.series.name] - values.min()
        colour, style = style_of(number)
        label = line.label if alone else f"{line.label} ({values.min():g} … {values.max():g})"
        axes.step(line.series.time_s, values + offset, style, where="post", color=colour, label=label, alpha=0.8)
    if alone:
        axes.yaxis.set_major_locator(MaxNLocator(integer=True))
    else:
        axes.set_yticks([])


def draw(panels: list[Panel], title: str, output: Path) -> None:
    figure, grid = sheet(len(panels), title, sharex=True)
    for axes, panel in zip(grid, panels, strict=True):
        if panel.is_discrete:
            draw_states(axes, panel.lines)
        else:
            for number, line in enumerate(panel.lines):
                draw_line(axes, line, number)
        axes.set_title(panel.heading, loc="left")
        axes.margins(x=0.01)
        legend(axes)
    grid[-1].set_xlabel("Time [s]")
    save(figure, output)
