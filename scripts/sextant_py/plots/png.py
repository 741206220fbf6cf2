"""Panels as a picture of matplotlib."""

from collections.abc import Sequence
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from ..errors import UserError
from ..figure_style import STYLE
from . import lanes, marks, styles
from .look import COMMON, Look
from .marks import Mark
from .panels import Line, Panel, first_of_lines
from .styles import Style

MOST_POINTS = 2000  # of a line
MOST_ENTRIES = 14  # of a legend
LANE_IN = 0.42
DASHES = ("-", "--", ":", "-.")
# Of a legend above its panel: a line's sample, and the width beside the heading of a common picture [characters].
ENTRY, ROOM = 7, 85
ENTRY_PT = 12.0  # height of an entry of a narrow picture's legend
CHARACTER = 0.0075  # width of one of a band's name, as a share of a common picture's


def style_of(number: int) -> tuple[str, str]:
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


def sheet(
    rows: int, title: str, heights: list[float] | None = None, look: Look = COMMON, **options: object
) -> tuple[Figure, list[Axes]]:
    """Panels above each other, of these heights [in]."""
    plt.rcParams.update(STYLE | dict(look.style))
    heights = heights or [look.panel_in] * rows
    size = (look.width_in, (1.2 if title else 0.6) + sum(heights))
    figure, axes = plt.subplots(rows, 1, squeeze=False, figsize=size, height_ratios=heights, **options)
    if title:
        figure.suptitle(title, fontsize=13)
    return figure, list(axes[:, 0])


def legend(axes: Axes, handles: list[Artist] | None = None, look: Look = COMMON) -> None:
    """Above the panel where it is short, beside it where it is long; of many lines the first ones. Of a narrow picture
    between heading and panel, the entries under each other."""
    handles = axes.get_legend_handles_labels()[0] if handles is None else handles
    if not handles:
        return
    if len(handles) > MOST_ENTRIES:
        more = Line2D([], [], linestyle="none", label=f"… {len(handles) - MOST_ENTRIES + 1} more")
        handles = [*handles[: MOST_ENTRIES - 1], more]
    heading, labels = axes.get_title(loc="left"), [str(handle.get_label()) for handle in handles]
    place = {"loc": "upper left", "bbox_to_anchor": (1.0, 1.0), "fontsize": 8.5, "borderaxespad": 0.2}
    if look.is_narrow:
        place |= {"loc": "lower left", "bbox_to_anchor": (0.0, 1.0), "labelspacing": 0.15}
        axes.set_title(heading, loc="left", pad=6 + ENTRY_PT * len(handles))
    elif sum(len(label) + ENTRY for label in labels) + len(heading) < ROOM * look.share:
        place |= {"loc": "lower right", "ncols": len(labels), "fontsize": 9}
    axes.legend(handles=handles, **place)


def draw_line(axes: Axes, line: Line, colour: str, dash: str) -> None:
    time_s, value, low, high = line.points(MOST_POINTS)
    if low is not None:
        axes.fill_between(time_s, low, high, color=colour, alpha=0.25, linewidth=0)
    axes.plot(time_s, value, dash, color=colour, linewidth=1.1)


def draw_lines(axes: Axes, lines: list[Line], look: Look) -> None:
    if not lines:
        axes.text(0.5, 0.5, "not recorded", transform=axes.transAxes, ha="center", color="grey")
        return

    def drawn(style: Style) -> tuple[str, str]:
        return look.colour(style.colour), DASHES[style.dash]

    each, entries = styles.of_lines(lines)
    for line, style in zip(lines, each, strict=True):
        draw_line(axes, line, *drawn(style))
    axes.ticklabel_format(axis="y", useOffset=False)
    shown = [(text, *drawn(style)) for text, style in entries]
    legend(axes, [Line2D([], [], color=colour, linestyle=dash, label=text) for text, colour, dash in shown], look)


def draw_lanes(axes: Axes, lines: list[Line], look: Look) -> None:
    """A lane for each discrete signal. A name that its band has no room for is in the legend."""
    found = lanes.of(lines)
    begin_s = min(line.series.time_s[0] for line in lines)
    span_s = max(line.series.time_s[-1] for line in lines) - begin_s
    unnamed: dict[str, str] = {}
    for number, lane in enumerate(found):
        if not lane.is_named:
            time_s, heights, _ = lane.steps(len(lane.line.series.values))
            colour = look.colour(styles.numbered(number).colour)
            axes.step(time_s, heights, where="post", color=colour, linewidth=1.0)
            continue
        for band in lane.bands():
            colour, place = look.colour(band.colour), (lane.base, lanes.HEIGHT)
            axes.broken_barh([(band.begin_s, band.length_s)], place, facecolors=colour, alpha=0.45)
            if band.length_s * look.share >= len(band.text) * CHARACTER * span_s:
                axes.text(band.middle_s, lane.middle, band.text, ha="center", va="center", fontsize=8.5)
            else:
                unnamed[band.text] = colour
    axes.set_yticks([lane.middle for lane in found], [lane.label for lane in found])
    axes.set_ylim(-0.1, len(found))
    axes.tick_params(axis="y", length=0)
    axes.grid(visible=False, axis="y")
    legend(axes, [Patch(color=colour, alpha=0.45, label=text) for text, colour in unnamed.items()], look)


def draw_marks(grid: list[Axes], found: Sequence[Mark], look: Look, named: int) -> None:
    """Lines and spans in every panel; named: the place of that with their texts."""
    begin_s, end_s = grid[0].get_xlim()
    found = marks.within(found, begin_s, end_s)
    for axes in grid:
        for mark in found:
            colour = look.colour(marks.COLOURS[mark.kind])
            if mark.end_s is not None:
                axes.axvspan(mark.begin_s, mark.end_s, color=colour, alpha=0.1, linewidth=0, zorder=0)
            axes.axvline(mark.begin_s, color=colour, linewidth=0.9, alpha=0.8, zorder=1.5)
    for mark, text in marks.texts(found, end_s - begin_s, marks.NEAR / look.share):
        note = grid[named].annotate(
            text, (mark.begin_s, 1), xycoords=("data", "axes fraction"), xytext=(2, -3), textcoords="offset points",
            rotation=90, ha="left", va="top", fontsize=8,
            bbox={"facecolor": grid[named].get_facecolor(), "alpha": 0.75, "linewidth": 0, "pad": 1},
        )  # fmt: skip
        note.set_in_layout(False)  # a long text takes no room from the panels


def figure_of(panels: list[Panel], title: str, found: Sequence[Mark] = (), look: Look = COMMON) -> Figure:
    heights = [0.6 + LANE_IN * len(panel.lines) if panel.is_discrete else look.panel_in for panel in panels]
    figure, grid = sheet(len(panels), title, heights, look, sharex=True)
    for axes, panel in zip(grid, panels, strict=True):
        axes.set_title(panel.heading, loc="left")
        (draw_lanes if panel.is_discrete else draw_lines)(axes, panel.lines, look)
        axes.margins(x=0.01)
    draw_marks(grid, found, look, first_of_lines(panels))
    grid[-1].set_xlabel("Time [s]")
    return figure


def draw(panels: list[Panel], title: str, output: Path, found: Sequence[Mark] = ()) -> None:
    save(figure_of(panels, title, found), output)
