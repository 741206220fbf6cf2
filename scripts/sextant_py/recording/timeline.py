"""The samples, batches and frames of a recording in the order of their times."""

import heapq
from collections.abc import Iterator
from dataclasses import dataclass
from operator import attrgetter

import numpy as np

from .model import Source
from .topics import WAVEFORM, batches_of


@dataclass(frozen=True)
class Item:
    """What was published at once: a row, or the rows of a batch."""

    t_ns: int
    group: str
    rows: np.ndarray


def rows(source: Source, name: str) -> Iterator[Item]:
    for block in source.blocks(name):
        for index, t_ns in enumerate(source.groups[name].times_ns(block)):
            yield Item(int(t_ns), name, block[index])


def batches(source: Source, name: str) -> Iterator[Item]:
    """The batches of the waveform. The last one of a block may go on in the next."""
    begun: np.ndarray | None = None
    for block in source.blocks(name):
        *whole, begun = batches_of(block if begun is None else np.concatenate((begun, block)))
        for batch in whole:
            yield Item(int(batch["t_ns"][-1]), name, batch)
    if begun is not None:
        yield Item(int(begun["t_ns"][-1]), name, begun)


def items(source: Source, names: list[str]) -> Iterator[Item]:
    """The items of these groups, the earliest first."""
    each = [batches(source, name) if name == WAVEFORM else rows(source, name) for name in names]
    return heapq.merge(*each, key=attrgetter("t_ns"))


def begin_ns(source: Source, names: list[str]) -> int:
    firsts = ((source.groups[name], next(source.blocks(name), None)) for name in names)
    return min(int(group.times_ns(block[:1])[0]) for group, block in firsts if block is not None and len(block))
