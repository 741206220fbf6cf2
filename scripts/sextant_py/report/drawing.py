"""The pictures of a run on the page of a report."""

from pathlib import Path

from ..errors import UserError
from . import pictures
from .model import Run
from .settings import Settings


def draw(run: Run, path: Path, settings: Settings) -> None:
    """Adds the picture of a file's signals, or a note where it has nothing to draw. UserError: a signal or a span was
    asked for that is not there."""
    try:
        run.pictures.append(pictures.of_file(path, settings.signals, run.faults, settings.span))
    except UserError as error:
        if settings.signals or settings.span != (None, None):
            raise
        run.notes.append(f"Nothing is drawn: {error}")
