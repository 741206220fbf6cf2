"""Pictures of the studies' pages."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from pathlib import Path
from typing import Any

from sextant_py.figure_style import STYLE

WIDTH = 9.2  # of a sheet [inches]


@contextmanager
def picture(
    file: Path, rows: int, columns: int, size: tuple[float, float], style: dict[str, Any] | None = None, **options: Any
) -> Iterator[tuple[Any, Any]]:
    """A figure of that size in inches and its panels, an array of rows; the file is written at the end.

    style: what differs from that of all pictures. options: of matplotlib's subplots.
    """
    import matplotlib as mpl  # takes a second, which a run without a picture need not wait for

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    with mpl.rc_context(STYLE | (style or {})):
        figure, panels = plt.subplots(rows, columns, figsize=size, squeeze=False, **options)
        try:
            yield figure, panels
            figure.savefig(file)
        finally:
            plt.close(figure)


class Sheets(dict[str, Callable[..., None]]):
    """Pictures as wide as a page, by name: functions of what each shows and, last, of its file."""

    def sheet(self, rows: int, columns: int, height: float, **options: Any) -> Callable[[Callable], Callable]:
        """The picture of a function that draws what it is given on the panels, its last argument."""

        def made(draw: Callable) -> Callable:
            @wraps(draw)
            def drawn(*shown_and_file: Any) -> None:
                from sextant_py.plots.sheets import SHEET_STYLE

                *shown, file = shown_and_file
                with picture(file, rows, columns, (WIDTH, height), SHEET_STYLE, **options) as (_, panels):
                    draw(*shown, panels)

            self[draw.__name__] = drawn
            return drawn

        return made
