"""Copies a recording from one format to another, block by block."""

import os
import tempfile
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path

import numpy as np

from ..errors import UserError
from .formats import AT_THE_END, earlier, open_sink
from .model import MAIN, Group, Metadata, Sink, Source, damage, merged


def main_of(names: list[str]) -> str:
    """The group that a file of the recording's own name has, where each group is a file."""
    return names[0] if len(names) == 1 else MAIN


def copy(source: Source, output: Path, names: list[str] | None, report: Callable[[float], None]) -> dict[str, int]:
    """The rows written by group. report gets the share that is done, 0 to 1.

    The files are written in a folder beside the output and moved at the end: a copy that fails leaves what is there.
    """
    chosen = list(source.groups) if names is None else names
    try:
        output.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(
            prefix=f".{output.name}.", dir=output.parent, ignore_cleanup_errors=True
        ) as folder:
            kept = _write(source, Path(folder) / output.name, chosen, report)
            _move(Path(folder), output)
    except OSError as error:
        reason = os.strerror(error.errno) if error.errno else error
        raise UserError(f"{output} cannot be written: {reason}; nothing of it is kept.") from None
    return kept


def _blocks(source: Source, names: list[str]) -> Iterator[tuple[Group, np.ndarray]]:
    with damage(source.paths[0], OSError):
        yield from merged(source, names)


def _write(source: Source, path: Path, names: list[str], report: Callable[[float], None]) -> dict[str, int]:
    metadata = {**source.metadata, "main": main_of(names), "rows": {}}
    total, done = sum(source.rows(name) for name in names) or 1, 0
    sink = open_sink(path, metadata)
    try:
        for name in names:
            sink.add(source.groups[name])
        for group, block in _blocks(source, names):
            sink.append(group.name, block)
            done += len(block)
            report(done / total)
        sink.close({**metadata, "rows": dict(sink.kept)})
    except BaseException:
        _abandon(sink, path, metadata)
        raise
    return dict(sink.kept)


def _abandon(sink: Sink, path: Path, metadata: Metadata) -> None:
    with suppress(Exception):
        if path.suffix in AT_THE_END:
            sink.abandon()
        else:
            sink.close(metadata)


def _move(folder: Path, output: Path) -> None:
    """Replaces the recording at the output, of which no file stays."""
    old, new = earlier(output), [output.with_name(place.name) for place in folder.iterdir()]
    for place in new:
        (folder / place.name).replace(place)
    for place in set(old) - set(new):
        place.unlink()
