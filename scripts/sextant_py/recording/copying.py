"""Copies a recording from one format to another, block by block."""

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from .model import MAIN, Group, Source, damage, merged
from .replacing import close_whole, replacing, whole_sink


def main_of(names: list[str]) -> str:
    """The group that a file of the recording's own name has, where each group is a file."""
    return names[0] if len(names) == 1 else MAIN


def copy(source: Source, output: Path, names: list[str] | None, report: Callable[[float], None]) -> dict[str, int]:
    """The rows written by group. report gets the share that is done, 0 to 1. A copy that fails leaves what is there."""
    names = list(source.groups) if names is None else names
    metadata = {**source.metadata, "main": main_of(names), "rows": {}}
    total = sum(source.rows(name) for name in names) or 1
    rows = dict.fromkeys(names, 0)
    with replacing(output) as path, whole_sink(path, metadata) as sink:
        for name in names:
            sink.add(source.groups[name])
        for group, block in _blocks(source, names):
            sink.append(group.name, block)
            rows[group.name] += len(block)
            report(sum(rows.values()) / total)
        close_whole(sink, metadata, rows)
    return rows


def _blocks(source: Source, names: list[str]) -> Iterator[tuple[Group, np.ndarray]]:
    with damage(source.paths[0], OSError):
        yield from merged(source, names)
