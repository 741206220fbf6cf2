"""Copies a recording from one format to another, block by block."""

import os
from collections.abc import Callable
from pathlib import Path

from ..errors import UserError
from .formats import AT_THE_END, open_sink
from .model import MAIN, Source, merged


def copy(source: Source, output: Path, names: list[str] | None, report: Callable[[float], None]) -> dict[str, int]:
    """The rows written by group. report is told the share that is done, 0 to 1."""
    chosen = list(source.groups) if names is None else names
    total = sum(source.rows(name) for name in chosen) or 1
    done = 0
    metadata = {**source.metadata, "main": chosen[0] if len(chosen) == 1 else MAIN, "rows": {}}
    sink = None
    try:
        sink = open_sink(output, metadata)
        for name in chosen:
            sink.add(source.groups[name])
        for group, block in merged(source, chosen):
            sink.append(group.name, block)
            done += len(block)
            report(done / total)
        sink.close({**metadata, "rows": dict(sink.kept)})
    except OSError as error:
        raise UserError(_left(output, sink, metadata, os.strerror(error.errno) if error.errno else error)) from None
    return dict(sink.kept)


def _left(output: Path, sink: object, metadata: dict, reason: object) -> str:
    """What is left of a copy that found no room."""
    if sink is not None and output.suffix in AT_THE_END:
        sink.abandon()
    if sink is None or output.suffix in AT_THE_END:
        return f"{output} cannot be written: {reason}; nothing of it is kept."
    sink.close(metadata)
    rows = ", ".join(f"{count} of {name}" for name, count in sink.kept.items())
    return f"{output} cannot be written to its end: {reason}; rows that are kept: {rows or 'none'}."
