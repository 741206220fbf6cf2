"""Panels as a picture of matplotlib."""

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from ..errors import UserError
from ..figure_style import STYLE
from . import lanes, marks, styles
from .marks import Mark
from .panels import Line, Panel
from .styles import Style

MOST_POINTS = 2000  # of a line
MOST_ENTRIES = 14  # of a legend
WIDTH_IN, PANEL_IN, LANE_IN = 11.0, 2.6, 0.42
DASHES = ("-", "--", ":", "-.")
ENTRY, ROOM = 7, 85  # of a legend above its panel: a line's sample and the width beside the heading [characters]
CHARACTER = 0.0075  # width of one of a band's name, as a share of the picture's


def style_of(number: int) -> tuple[str, str]:
    """Colour and dash of a line of a panel."""
    style = styles.numbered(number)
    return style.colour, DASHES[style.dash]


def save(figure: Figure, output: Path) -> None:
    try:
        output.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(output)
    except (OSError, ValueError) as error:
        raise UserError(f"the plot {output} cannot be written: {getattr(error, 'strerror', None) or error}.") from None
    finally:
        plt.close(figure)


def sheet(rows: int, title: str, heights: list[float] | None = None, **options: object) -> tuple[Figure, list[Axes]]:
    """Panels above each other, of these heights [in]."""
    plt.rcParams.update(STYLE)
    heights = heights or [PANEL_IN] * rows
    size = (WIDTH_IN, 1.2 + sum(heights))
    figure, axes = plt.subplots(rows, 1, squeeze=False, figsize=size, height_ratios=heights, **options)
    figure.suptitle(title, fontsize=13)
    return figure, list(axes[:, 0])


def legend(axes: Axes, handles: list | None = None) -> None:
    """Above the panel where it is short, beside it where it is long; of many lines the first ones."""
    handles = axes.get_legend_handles_labels()[0] if handles is None else handles
    if not handles:
        return
    if len(handles) > MOST_ENTRIES:
        more = Line2D([], [], linestyle="none", label=f"… {len(handles) - MOST_ENTRIES + 1} more")
        handles = [*handles[: MOST_ENTRIES - 1], more]
    labels = [str(handle.get_label()) for handle in handles]
    if sum(len(label) + ENTRY for label in labels) + len(axes.get_title(loc="left")) < ROOM:
        axes.legend(
            handles=handles,
            loc="lower right",
            bbox_to_anchor=(1.0, 1.0),
            ncols=len(labels),
            fontsize=9,
            borderaxespad=0.2,
        )
    else:
        axes.legend(handles=handles, loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize=8.5, borderaxespad=0.2)


def draw_line(axes: Axes, line: Line, style: Style) -> None:
    time_s, value, low, high = line.points(MOST_POINTS)
    if low is not None:
        axes.fill_between(time_s, low, high, color=style.colour, alpha=0.25, linewidth=0)
    axes.plot(time_s, value, DASHES[style.dash], color=style.colour, linewidth=1.1)


def draw_lines(axes: Axes, lines: list[Line]) -> None:
    if not lines:
        axes.text(0.5, 0.5, "not recorded", transform=axes.transAxes, ha="center", color="grey")
        return
    each, entries = styles.of_lines(lines)
    for line, style in zip(lines, each, strict=True):
        draw_line(axes, line, style)
    axes.ticklabel_format(axis="y", useOffset=False)
    legend(
        axes, [Line2D([], [], color=style.colour, linestyle=DASHES[style.dash], label=text) for text, style in entries]
    )


def draw_lanes(axes: Axes, lines: list[Line]) -> None:
    """A lane for each discrete signal. A name that its band has no room for is in the legend."""
    found = lanes.of(lines)
    begin_s = min(line.series.time_s[0] for line in lines)
    span_s = max(line.series.time_s[-1] for line in lines) - begin_s
    unnamed: dict[str, str] = {}
    for number, lane in enumerate(found):
        if not lane.is_named:
            time_s, heights, _ = lane.steps(len(lane.line.series.values))
            axes.step(time_s, heights, where="post", color=styles.numbered(number).colour, linewidth=1.0)
            continue
        for band in lane.bands():
            axes.broken_barh(
                [(band.begin_s, band.length_s)], (lane.base, lanes.HEIGHT), facecolors=band.colour, alpha=0.45
            )
            if band.length_s >= len(band.text) * CHARACTER * span_s:
                axes.text(band.middle_s, lane.middle, band.text, ha="center", va="center", fontsize=8.5)
            else:
                unnamed[band.text] = band.colour
    axes.set_yticks([lane.middle for lane in found], [lane.label for lane in found])
    axes.set_ylim(-0.1, len(found))
    axes.tick_params(axis="y", length=0)
    axes.grid(visible=False, axis="y")
    legend(axes, [Patch(color=colour, alpha=0.45, label=text) for text, colour in unnamed.items()])


def draw_marks(grid: list[Axes], found: list[Mark]) -> None:
    """Lines and spans in every panel, their texts in the first."""
    begin_s, end_s = grid[0].get_xlim()
    found = marks.within(found, begin_s, end_s)
    for axes in grid:
        for mark in found:
            colour = marks.COLOURS[mark.kind]
            if mark.end_s is not None:
                axes.axvspan(mark.begin_s, mark.end_s, color=colour, alpha=0.1, linewidth=0, zorder=0)
            axes.axvline(mark.begin_s, color=colour, linewidth=0.9, alpha=0.8, zorder=1.5)
    for mark, text in marks.texts(found, end_s - begin_s):
        grid[0].annotate(
            text, (mark.begin_s, 1), xycoords=("data", "axes fraction"), xytext=(2, -3), textcoords="offset points",
            rotation=90, ha="left", va="top", fontsize=8, color=marks.COLOURS[mark.kind],
            bbox={"facecolor": "white", "alpha": 0.75, "linewidth": 0, "pad": 1},
        )  # fmt: skip


def draw(panels: list[Panel], title: str, output: Path, found: list[Mark] | None = None) -> None:
    heights = [0.6 + LANE_IN * len(panel.lines) if panel.is_discrete else PANEL_IN for panel in panels]
    figure, grid = sheet(len(panels), title, heights, sharex=True)
    for axes, panel in zip(grid, panels, strict=True):
        axes.set_title(panel.heading, loc="left")
        (draw_lanes if panel.is_discrete else draw_lines)(axes, panel.lines)
        axes.margins(x=0.01)
    draw_marks(grid, found or [])
    grid[-1].set_xlabel("Time [s]")
    save(figure, output)
