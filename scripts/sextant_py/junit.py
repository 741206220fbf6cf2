"""Writes a JUnit file."""

from pathlib import Path
from typing import TYPE_CHECKING

from .errors import UserError

if TYPE_CHECKING:
    from junitparser import JUnitXml


def write(xml: "JUnitXml", file: Path) -> None:
    """With its directory. UserError: it cannot be written."""
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        xml.write(str(file))
    except OSError as error:
        raise UserError(f"the JUnit file {file} cannot be written: {error.strerror}.") from None
