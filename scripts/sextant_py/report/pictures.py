"""The signals of a run over time, drawn by the code of scripts/plot for wide and narrow, light and dark pages."""

import base64
from collections.abc import Sequence
from io import BytesIO
from pathlib import Path

import matplotlib.pyplot as plt
from matplotlib.figure import Figure

from ..errors import UserError
from ..plots import marks, panels, png, series, styles
from ..plots.look import Look
from .model import Fault, Picture, Run, Settings, Span

# Torque, flux, speed and current; of a capture of control periods, which has no magnitude, the phase currents.
CHOSEN = ("torque_requested_nm", "torque", "torque_reference_nm", "flux", "speed", "current")
PHASES = ("i_a_a", "i_b_a", "i_c_a")
DPI = 144
WIDE_IN, NARROW_IN = 10.4, 3.7  # a hundred pixels of the page an inch
# The colours of the dashboard's dark theme.
_TEXT, _CARD, _GRID = "#e4e9f0", "#171e27", "#97a4b5"
DARK = {
    **dict.fromkeys(("text.color", "axes.labelcolor", "axes.edgecolor", "xtick.color", "ytick.color"), _TEXT),
    **dict.fromkeys(("figure.facecolor", "axes.facecolor"), _CARD),
    "grid.color": _GRID,
}
DARK_COLOURS = dict(
    zip(
        (*styles.COLOURS, styles.REFERENCE),
        (
            *("#5aa2ff", "#ffa24d", "#4cc38a", "#ff7b72", "#c99bff"),
            *("#c8a394", "#f2a6d8", "#97a4b5", "#d3d36b", "#4fd1c5"),
            "#ffb37a",
        ),
        strict=True,
    )
)
LOOKS = {
    (is_narrow, is_dark): Look(
        NARROW_IN if is_narrow else WIDE_IN, 2.4, DARK if is_dark else {}, DARK_COLOURS if is_dark else {}
    )
    for is_narrow in (False, True)
    for is_dark in (False, True)
}


def data_uri(content: bytes) -> str:
    return "data:image/png;base64," + base64.b64encode(content).decode("ascii")


def _encoded(figure: Figure) -> str:
    content = BytesIO()
    figure.savefig(content, format="png", dpi=DPI)
    plt.close(figure)
    return data_uri(content.getvalue())


def _names(file: series.SeriesFile, wanted: Sequence[str]) -> list[str]:
    """Those of the wanted signals that the file has."""
    found = []
    for name in wanted:
        try:
            file.find(name)
        except UserError:
            continue
        found.append(name)
    return found


def _marks(files: list[series.SeriesFile], faults: Sequence[Fault] | None) -> list[marks.Mark]:
    """Those of the files; the faults, where they are known, with their names and times."""
    found = marks.of(files)
    if faults is None:
        return found
    found = [mark for mark in found if mark.kind != marks.FAULT]
    found += [marks.Mark(marks.FAULT, fault.t_s, None, fault.name) for fault in faults]
    return sorted(found, key=lambda mark: mark.begin_s)


def of_file(path: Path, wanted: Sequence[str], faults: Sequence[Fault] | None, span: Span) -> Picture:
    """The wanted signals, or the chosen ones, with what happened as marks. UserError: there is none to draw."""
    files = series.load([path], *span)
    names = list(wanted)
    if not names:
        names = _names(files[0], CHOSEN)
        names += [] if "current" in names else _names(files[0], PHASES)
    arranged = panels.arrange(files, names)
    found = _marks(files, faults)
    variants = {}
    for key, look in LOOKS.items():
        with plt.rc_context():
            variants[key] = _encoded(png.figure_of(arranged, "", found, look))
    return Picture(", ".join(panel.heading for panel in arranged) + f" of {path.name} over time", variants)


def draw(run: Run, path: Path, settings: Settings) -> None:
    """Adds the picture of a file's signals, or a note where it has nothing to draw. UserError: a signal or a span was
    asked for that is not there."""
    try:
        run.pictures.append(of_file(path, settings.signals, run.faults, settings.span))
    except UserError as error:
        if settings.signals or settings.span != (None, None):
            raise
        run.notes.append(f"Nothing is drawn: {error}")
