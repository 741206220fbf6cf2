"""Panels as a picture of matplotlib."""

from collections.abc import Sequence
from dataclasses import dataclass, field
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
NARROW_IN = 6.0  # below it the names of the lines stand under each other
NAME_PT = 12.0  # height of a line's name there
MARK = "#c4202b"
MOST_NAMES = 3  # of marks at one instant


@dataclass(frozen=True)
class Look:
    """Size and colours of a picture."""

    width_in: float = WIDTH_IN
    panel_in: float = PANEL_IN  # height of a panel
    style: dict[str, object] = field(default_factory=dict)  # of matplotlib, beside that of every picture
    mark: str = MARK  # colour of marks

    @property
    def is_narrow(self) -> bool:
        return self.width_in < NARROW_IN


@dataclass(frozen=True)
class Mark:
    """An instant with a name, as of a fault."""

    time_s: float
    text: str


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


def sheet(rows: int, title: str, look: Look | None = None, **options: object) -> tuple[Figure, list[Axes]]:
    look = look or Look()
    plt.rcParams.update(STYLE | look.style)
    size = (look.width_in, (1.2 if title else 0.6) + look.panel_in * rows)
    figure, axes = plt.subplots(rows, 1, squeeze=False, figsize=size, **options)
    if title:
        figure.suptitle(title, fontsize=13)
    return figure, list(axes[:, 0])


def legend(axes: Axes) -> None:
    """Above the panel where it is short, at its right where it is long."""
    labels = axes.get_legend_handles_labels()[1]
    if not labels:
        return
    if sum(map(len, labels)) < 70 and len(labels) <= 4:
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, fontsize=9, borderaxespad=0.2)
    else:
        axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize=8.5, borderaxespad=0.2)


def narrow_legend(axes: Axes) -> None:
    """Names under each other, between heading and panel."""
    count = len(axes.get_legend_handles_labels()[1])
    if count:
        axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), fontsize=8.5, borderaxespad=0.2, labelspacing=0.15)
        axes.set_title(axes.get_title(loc="left"), loc="left", pad=6 + NAME_PT * count)


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


def draw_marks(grid: list[Axes], marks: Sequence[Mark], colour: str) -> None:
    """A line through every panel at each instant, with the names in the first one."""
    texts: dict[float, list[str]] = {}
    for mark in marks:
        texts.setdefault(mark.time_s, []).append(mark.text)
    for time_s, names in texts.items():
        for axes in grid:
            axes.axvline(time_s, color=colour, linewidth=1.0, linestyle="--", zorder=5)
        begin, end = grid[0].get_xlim()
        is_late = time_s > 0.5 * (begin + end)
        side = {"ha": "right", "xytext": (-3, -3)} if is_late else {"ha": "left", "xytext": (3, -3)}
        place = {"xycoords": grid[0].get_xaxis_transform(), "textcoords": "offset points", "va": "top"}
        text = ", ".join(names[:MOST_NAMES]) + (" …" if len(names) > MOST_NAMES else "")
        note = grid[0].annotate(text, (time_s, 1.0), color=colour, fontsize=8.5, zorder=6, **side, **place)
        note.set_in_layout(False)  # a long name takes no room from the panels


def figure_of(panels: list[Panel], title: str, marks: Sequence[Mark] = (), look: Look | None = None) -> Figure:
    look = look or Look()
    figure, grid = sheet(len(panels), title, look, sharex=True)
    for axes, panel in zip(grid, panels, strict=True):
        if panel.is_discrete:
            draw_states(axes, panel.lines)
        else:
            for number, line in enumerate(panel.lines):
                draw_line(axes, line, number)
            axes.ticklabel_format(axis="y", useOffset=False)
        axes.set_title(panel.heading, loc="left")
        axes.margins(x=0.01)
        (narrow_legend if look.is_narrow else legend)(axes)
    draw_marks(grid, marks, look.mark)
    grid[-1].set_xlabel("Time [s]")
    return figure


def draw(panels: list[Panel], title: str, output: Path) -> None:
    save(figure_of(panels, title), output)
