"""`identify` as the studies run it."""

from collections.abc import Iterable
from pathlib import Path

from sextant_py import identify
from sextant_py.identify_files import Results
from sextant_py.sweep_file import Settings
from sextant_py.sweep_reader import set_words

from .command import made


def identified(
    file: Path, mil: Path, directory: Path, parts: Iterable[str], settings: Settings, threshold_v: float | None = None
) -> Results:
    """What these parts find on the drive of a file with these settings, told the threshold of its switches."""
    told = [] if threshold_v is None else ["--threshold-v", str(threshold_v)]
    options = identify.parse_arguments([str(file), "--only", ",".join(parts), *told, *set_words(settings)])
    return identify.identified(file, mil, made(directory), options)
