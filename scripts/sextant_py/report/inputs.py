"""Which kind of result a path is."""

import json
from pathlib import Path

from ..errors import UserError
from ..recording.formats import SUFFIXES
from . import junit_results, mil_results, recordings, sweeps, timings
from .model import Run, Settings

KINDS = (
    "a result directory of sextant-mil, its summary.json, a directory of result directories, a directory of "
    f"scripts/sweep, a JUnit file (.xml), a file of sextant-ecu --timing-out (.json), a trace or a recording "
    f"({', '.join(SUFFIXES)})"
)


def _directory(path: Path, settings: Settings) -> list[Run]:
    if (path / sweeps.STATE).is_file():
        return [sweeps.read(path)]
    if (path / "summary.json").is_file():
        return [mil_results.read(path, settings)]
    found = sorted(file.parent for file in path.glob("*/summary.json"))
    if not found:
        raise UserError(f"{path} holds no result: neither summary.json nor */summary.json nor {sweeps.STATE}.")
    return [mil_results.read(directory, settings) for directory in found]


def _json(path: Path, settings: Settings) -> list[Run]:
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise UserError(f"{path} cannot be read: {error.strerror}.") from None
    except ValueError:
        content = None
    if timings.is_timing(content):
        return [timings.read(path, content)]
    return [mil_results.read(path, settings)]


def runs_of(path: Path, settings: Settings) -> list[Run]:
    """UserError: one sentence."""
    if path.is_dir():
        return _directory(path, settings)
    suffix = path.suffix.lower()
    if suffix in SUFFIXES:  # several files may make a recording of which none has this name
        return [recordings.read(path, settings)]
    if not path.exists():
        raise UserError(f"{path} does not exist.")
    if suffix == ".json":
        return _json(path, settings)
    if suffix == ".xml":
        return junit_results.read(path)
    raise UserError(f"{path} is none of the results that a report is made from: {KINDS}.")
