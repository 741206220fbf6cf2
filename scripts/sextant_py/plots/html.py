"""Pictures as one interactive HTML file that needs no network: plotly with its script inside."""

from pathlib import Path

import numpy as np
from plotly import graph_objects
from plotly.colors import qualitative
from plotly.subplots import make_subplots

from ..errors import UserError
from .panels import Line, Panel
from .points import envelope

MOST_POINTS = 5000  # of a line
COLOURS = qualitative.D3
DASHES = ("solid", "dash", "dot", "dashdot")  # once the colours are used up
PANEL_PX, HEAD_PX = 260, 120
Figure = graph_objects.Figure


def sheet(headings: list[str], title: str, shared: bool = True) -> Figure:
    rows = len(headings)
    gap = 0.25 / rows if rows > 1 else 0.0
    figure = make_subplots(rows, 1, shared_xaxes=shared, vertical_spacing=gap, subplot_titles=headings)
    figure.update_annotations(x=0, xanchor="left", font_size=14)
    legend = {"font": {"size": 11}, "groupclick": "toggleitem", "traceorder": "grouped"}
    figure.update_layout(title=title, height=HEAD_PX + PANEL_PX * rows, template="plotly_white", legend=legend)
    figure.update_layout(hovermode="x unified", margin={"l": 70, "r": 30, "t": 80, "b": 50})
    return figure


def save(figure: Figure, output: Path) -> None:
    try:
        output.parent.mkdir(parents=True, exist_ok=True)
        figure.write_html(output, include_plotlyjs=True, config={"displaylogo": False, "responsive": True})
    except OSError as error:
        raise UserError(f"the plot {output} cannot be written: {error.strerror or error}.") from None


def style_of(number: int) -> dict[str, object]:
    """Colour and dash of a line of a panel."""
    return {"color": COLOURS[number % len(COLOURS)], "dash": DASHES[number // len(COLOURS) % len(DASHES)]}


def faint(colour: str) -> str:
    """The colour #rrggbb for a band."""
    red, green, blue = (int(colour[at : at + 2], 16) for at in (1, 3, 5))
    return f"rgba({red},{green},{blue},0.2)"


def add_line(figure: Figure, line: Line, number: int, panel: Panel, row: int) -> None:
    """A line, its band first. Rows count from 1."""
    group = {"legendgroup": str(row), "legendgrouptitle_text": panel.heading}
    if panel.is_discrete:
        shape = style_of(number) | {"width": 1.4, "shape": "hv"}
        x, y = envelope(line.series.time_s, line.series.values, MOST_POINTS)
        figure.add_scatter(x=x, y=y, mode="lines", name=line.label, line=shape, row=row, col=1, **group)
        return
    time_s, *values = line.points(MOST_POINTS)
    value, low, high = (None if part is None else part.astype(np.float32) for part in values)
    shape = style_of(number) | {"width": 1.4}
    if low is not None:
        edge = {"mode": "lines", "line": {"width": 0}, "showlegend": False, "hoverinfo": "skip"}
        fill = {"fill": "tonexty", "fillcolor": faint(str(shape["color"]))}
        figure.add_scatter(x=time_s, y=low, row=row, col=1, **edge)
        figure.add_scatter(x=time_s, y=high, row=row, col=1, **fill, **edge)
    figure.add_scatter(x=time_s, y=value, mode="lines", name=line.label, line=shape, row=row, col=1, **group)


def draw(panels: list[Panel], title: str, output: Path) -> None:
    figure = sheet([panel.heading for panel in panels], title)
    for row, panel in enumerate(panels, 1):
        for number, line in enumerate(panel.lines):
            add_line(figure, line, number, panel, row)
    figure.update_xaxes(title_text="Time [s]", row=len(panels), col=1)
    save(figure, output)
