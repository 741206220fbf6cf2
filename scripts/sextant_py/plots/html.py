"""Pictures as one interactive HTML file that needs no network: plotly with its script inside."""

import html
import itertools
from pathlib import Path

import numpy as np
from plotly import graph_objects
from plotly.subplots import make_subplots

from ..errors import UserError
from . import lanes, marks, styles
from .marks import Mark
from .panels import Line, Panel, first_of_lines
from .styles import Style

MOST_POINTS = 5000  # of a line
DASHES = ("solid", "dash", "dot", "dashdot")
PANEL_PX, LANE_PX, CHARACTER_PX = 200, 34, 7
PLOT_PX = {"wide": 900, "narrow": 250}  # of a page: a name that its band has no room for is in the legend alone
FAINT = 0.2
HERE = Path(__file__).parent
Figure = graph_objects.Figure


def legend_of(row: int) -> str:
    return "legend" if row == 1 else f"legend{row}"


def sheet(headings: list[str], heights_px: list[int] | None = None, shared: bool = True) -> Figure:
    """Panels above each other, each with its heading and its legend above it; page.js gives them their places."""
    rows = len(headings)
    figure = make_subplots(rows, 1, shared_xaxes=shared, vertical_spacing=0, subplot_titles=headings)
    figure.update_annotations(x=0, xanchor="left", yanchor="top", font_size=14)
    figure.update_layout(template="plotly_white", hovermode="x unified", dragmode="zoom", showlegend=True)
    for row in range(1, rows + 1):
        place = {
            "orientation": "h",
            "x": 0,
            "xanchor": "left",
            "yanchor": "top",
            "font": {"size": 11},
            "tracegroupgap": 0,
        }
        figure.update_layout({legend_of(row): {**place, "bgcolor": "rgba(0,0,0,0)"}})
    heights_px = heights_px or [PANEL_PX] * rows
    figure.update_layout(
        meta={
            "panels": [
                {"axis": "yaxis" if row == 1 else f"yaxis{row}", "legend": legend_of(row), "height_px": height}
                for row, height in enumerate(heights_px, 1)
            ],
            "left_px": 0,
        }
    )
    return figure


def _measure_legends(figure: Figure) -> None:
    """Entries and their width, by which page.js leaves room for the legends."""
    for row, panel in enumerate(figure.layout.meta.get("panels", []), 1):
        names = [
            str(line.name)
            for line in figure.data
            if line.name and line.showlegend is not False and (line.legend or "legend") == legend_of(row)
        ]
        panel["entries"] = len(names)
        panel["entry_px"] = CHARACTER_PX * max(map(len, names), default=0)
        figure.update_layout({legend_of(row): {"entrywidth": panel["entry_px"]}})


def save(figure: Figure, title: str, output: Path) -> None:
    if figure.layout.meta:
        _measure_legends(figure)
    options = {"displaylogo": False, "responsive": False}
    body = figure.to_html(full_html=False, include_plotlyjs=True, config=options)
    page = (HERE / "page.html").read_text(encoding="utf-8")
    script = (HERE / "page.js").read_text(encoding="utf-8")
    try:
        output.parent.mkdir(parents=True, exist_ok=True)
        output.write_text(page.format(title=html.escape(title), figure=body, script=script), encoding="utf-8")
    except OSError as error:
        raise UserError(f"the plot {output} cannot be written: {error.strerror or error}.") from None


def style_of(number: int) -> dict[str, object]:
    return _shape(styles.numbered(number))


def _shape(style: Style) -> dict[str, object]:
    return {"color": style.colour, "dash": DASHES[style.dash]}


def faint(colour: str, share: float = FAINT) -> str:
    """The colour #rrggbb for a band."""
    red, green, blue = (int(colour[at : at + 2], 16) for at in (1, 3, 5))
    return f"rgba({red},{green},{blue},{share})"


def add_line(figure: Figure, line: Line, style: Style, row: int) -> None:
    """A line, its band first. Rows count from 1."""
    place = {"row": row, "col": 1, "legend": legend_of(row), "legendgroup": line.label}
    time_s, *values = line.points(MOST_POINTS)
    value, low, high = (None if part is None else part.astype(np.float32) for part in values)
    if low is not None:
        edge = {"mode": "lines", "line": {"width": 0}, "showlegend": False, "hoverinfo": "skip"}
        fill = {"fill": "tonexty", "fillcolor": faint(style.colour)}
        figure.add_scatter(x=time_s, y=low, **edge, **place)
        figure.add_scatter(x=time_s, y=high, **fill, **edge, **place)
    shape = _shape(style) | {"width": 1.4}
    figure.add_scatter(x=time_s, y=value, mode="lines", name=line.label, line=shape, **place)


def add_bands(figure: Figure, lane: lanes.Lane, row: int, named: set[str]) -> None:
    """The bands of an enumeration by their values, and their names under the pointer."""
    place = {"row": row, "col": 1, "legend": legend_of(row)}
    bands = lane.bands()
    low, high = lane.base, lane.base + lanes.HEIGHT
    values: dict[str, list[lanes.Band]] = {}
    for band in bands:
        values.setdefault(band.text, []).append(band)
    for text, runs in values.items():
        x = [at for run in runs for at in (run.begin_s, run.end_s, run.end_s, run.begin_s, None)]
        fill = {"fill": "toself", "fillcolor": faint(runs[0].colour, 0.45), "hoverinfo": "skip"}
        shown = {"name": text, "showlegend": text not in named, "legendgroup": text}
        figure.add_scatter(
            x=x, y=[low, low, high, high, None] * len(runs), mode="lines", line={"width": 0}, **fill, **shown, **place
        )
        named.add(text)
    time_s = [at for band in bands for at in (band.begin_s, band.end_s)]
    texts = [band.text for band in bands for _ in range(2)]
    figure.add_scatter(
        x=time_s, y=[lane.middle] * len(time_s), mode="lines", line={"width": 0}, text=texts, showlegend=False,
        name=lane.label, hovertemplate=f"{html.escape(lane.label)}: %{{text}}<extra></extra>", **place,
    )  # fmt: skip
    span_s = bands[-1].end_s - bands[0].begin_s
    for width, plot_px in PLOT_PX.items():
        shown = [band for band in bands if band.length_s * plot_px >= CHARACTER_PX * (len(band.text) + 1) * span_s]
        figure.add_scatter(
            x=[band.middle_s for band in shown], y=[lane.middle] * len(shown), text=[band.text for band in shown],
            mode="text", textfont={"size": 11}, showlegend=False, hoverinfo="skip", meta=width,
            visible=width == "wide", **place,
        )  # fmt: skip


def add_lanes(figure: Figure, lines: list[Line], row: int) -> None:
    """A lane for each discrete signal, the first on top."""
    found, named = lanes.of(lines), set()
    for number, lane in enumerate(found):
        if lane.is_named:
            add_bands(figure, lane, row, named)
            continue
        time_s, heights, values = lane.steps(MOST_POINTS)
        shape = style_of(number) | {"width": 1.4, "shape": "hv", "dash": "solid"}
        figure.add_scatter(
            x=time_s, y=heights, customdata=values, mode="lines", line=shape, name=lane.label, showlegend=False,
            hovertemplate=f"{html.escape(lane.line.label)}: %{{customdata}}<extra></extra>", row=row, col=1,
        )  # fmt: skip
    ticks = {"tickvals": [lane.middle for lane in found], "ticktext": [lane.label for lane in found]}
    meta = figure.layout.meta
    meta["left_px"] = max(meta["left_px"], CHARACTER_PX * max(len(lane.label) for lane in found))
    figure.update_yaxes(row=row, col=1, range=[-0.1, len(found)], showgrid=False, zeroline=False, **ticks)


def add_marks(figure: Figure, found: list[Mark], begin_s: float, end_s: float, named: int) -> None:
    """Lines and spans in every panel, but not in what is between them; named: the place of that with their texts."""
    found = marks.within(found, begin_s, end_s)
    axes = [panel["axis"].replace("axis", "") for panel in figure.layout.meta["panels"]]
    for mark, axis in itertools.product(found, axes):
        colour = marks.COLOURS[mark.kind]
        across = {"yref": f"{axis} domain", "y0": 0, "y1": 1, "xref": "x"}
        if mark.end_s is not None:
            fill = {"fillcolor": faint(colour, 0.12), "line_width": 0, "layer": "below"}
            figure.add_shape(type="rect", x0=mark.begin_s, x1=mark.end_s, **fill, **across)
        figure.add_shape(type="line", x0=mark.begin_s, x1=mark.begin_s, line={"color": colour, "width": 1}, **across)
    for mark, text in marks.texts(found, end_s - begin_s):
        figure.add_annotation(
            x=mark.begin_s, xref="x", y=1, yref=f"{axes[named]} domain", text=html.escape(text), textangle=-90,
            showarrow=False, xanchor="left", yanchor="top", font={"size": 11},
        )  # fmt: skip


def draw(panels: list[Panel], title: str, output: Path, found: list[Mark] | None = None) -> None:
    heights = [20 + LANE_PX * len(panel.lines) if panel.is_discrete else PANEL_PX for panel in panels]
    figure = sheet([panel.heading for panel in panels], heights)
    for row, panel in enumerate(panels, 1):
        if panel.is_discrete:
            add_lanes(figure, panel.lines, row)
            continue
        each, _ = styles.of_lines(panel.lines)
        for line, style in zip(panel.lines, each, strict=True):
            add_line(figure, line, style, row)
    times = [line.series.time_s for panel in panels for line in panel.lines]
    add_marks(figure, found or [], min(t[0] for t in times), max(t[-1] for t in times), first_of_lines(panels))
    figure.update_xaxes(title_text="Time [s]", row=len(panels), col=1)
    save(figure, title, output)
