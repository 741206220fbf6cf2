"""Pictures of the studies' pages."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from sextant_py.figure_style import STYLE


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
