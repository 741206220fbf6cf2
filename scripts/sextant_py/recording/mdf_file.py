"""Recordings as ASAM MDF 4: a channel group a group, its master channel the time in seconds from the beginning."""

import gc
import json
import struct
import sys
import zlib
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
from asammdf import MDF, Signal
from asammdf.blocks.utils import MdfException
from isal import isal_zlib

from ..errors import UserError
from .model import BLOCK_ROWS, Column, Group, Metadata, begin_of_run, damage, metadata_of, of_sextant, unreadable
from .value_texts import value_texts

ATTACHMENT = "sextant_recording.json"
# What asammdf raises where a file is not what it should be.
UNREADABLE = (
    *(MdfException, isal_zlib.error, zlib.error, struct.error, OSError),
    *(ValueError, KeyError, IndexError, TypeError, AttributeError, MemoryError),
)
HEADER_AT = 64  # of the HD block, whose first link, after 24 bytes, is that to the first data group
SLICE_ROWS = 131_072
ZIPPED = 2  # deflate, with the bytes transposed


def conversion_of(group: str, column: Column) -> dict[str, int | str] | None:
    """From value to text (CCBLOCK type 7), so that tools show the name of a state and not its number; a value without
    one stays as it is."""
    texts = value_texts(group, column.name)
    if not texts:
        return None
    pairs = {f"val_{k}": value for k, value in enumerate(texts)} | {
        f"text_{k}": t for k, t in enumerate(texts.values())
    }
    return {**pairs, "default": ""}


class MdfSink:
    """Blocks go to a temporary file beside the recording; closing writes the recording."""

    def __init__(self, path: Path, metadata: Metadata) -> None:
        self._path = path
        self._mdf = MDF(version="4.10", temporary_folder=path.parent)
        self._metadata = metadata
        self._groups: dict[str, Group] = {}
        self._numbers: dict[str, int] = {}
        self._begin_ns = metadata.get("begin_ns")
        wall_ns = metadata.get("wall_minus_monotonic_begin_ns")
        if self._begin_ns is not None and wall_ns is not None:
            self._mdf.header.start_time = datetime.fromtimestamp((self._begin_ns + wall_ns) / 1e9, UTC)
        self.kept: dict[str, int] = {}

    def abandon(self) -> None:
        """Gives up the file, which is not readable."""
        self._mdf.close()

    def add(self, group: Group) -> None:
        self._groups[group.name] = group
        self.kept[group.name] = 0

    def append(self, name: str, block: np.ndarray) -> None:
        group = self._groups[name]
        times = group.times_ns(block)
        if self._begin_ns is None:
            begin_ns = begin_of_run(self._metadata, block[:1])
            self._begin_ns = int(times[0]) if begin_ns is None else begin_ns
        seconds = (times - self._begin_ns) / 1e9
        if name in self._numbers:
            columns = [(np.ascontiguousarray(block[column.name]), None) for column in group.columns]
            self._mdf.extend(self._numbers[name], [(seconds, None), *columns])
        else:
            signals = [self._signal(name, column, block[column.name], seconds) for column in group.columns]
            self._numbers[name] = self._mdf.append(signals, acq_name=name, comment=group.text)
        self.kept[name] += len(block)

    @staticmethod
    def _signal(group: str, column: Column, values: np.ndarray, seconds: np.ndarray) -> Signal:
        options = {"encoding": "utf-8"} if column.is_text else {"conversion": conversion_of(group, column)}
        samples = np.ascontiguousarray(values)
        return Signal(samples, seconds, unit=column.unit, name=column.name, comment=column.text, **options)

    def close(self, metadata: Metadata) -> None:
        groups = [group.described() for group in self._groups.values()]
        about = {"recording": {**metadata, "rows": self.kept}, "groups": groups}
        text = json.dumps(about, ensure_ascii=False, indent=1).encode()
        self._mdf.attach(text, ATTACHMENT, mime="application/json", compression=True, embedded=True)
        try:
            self._mdf.save(self._path, overwrite=True, compression=ZIPPED)
        finally:
            self._mdf.close()


class MdfSource:
    """A file that MdfSink wrote: the attachment tells exact types and order."""

    unverified = None  # its blocks have checksums

    def __init__(self, path: Path) -> None:
        self.cut: str | None = None
        self._path, self.paths = path, [path]
        check_whole(path)
        self._mdf = opened(path)
        about = self._about()
        with of_sextant(path, f"the attachment {ATTACHMENT}"):
            self.metadata: Metadata = metadata_of(about["recording"])
            groups = [Group.of(entry) for entry in about["groups"]]
            named = {found.channel_group.acq_name: index for index, found in enumerate(self._mdf.groups)}
            self.groups = {group.name: group for group in groups if group.name in named}
            self._numbers = {name: named[name] for name in self.groups}
            for name, group in self.groups.items():
                channels = [channel.name for channel in self._mdf.groups[named[name]].channels[1:]]
                if channels != list(group.dtype.names):
                    raise ValueError("other channels than those described")

    def _about(self) -> Any:
        """What the attachment says."""
        try:
            names = [str(block.file_name) for block in self._mdf.attachments]
            if ATTACHMENT in names:
                return json.loads(bytes(self._mdf.extract_attachment(names.index(ATTACHMENT))[0]))
        except UNREADABLE as error:
            raise unreadable(self._path, error, "is truncated or damaged, and cannot be read") from None
        raise UserError(f"{self._path} is no Sextant recording: it has no attachment {ATTACHMENT}.")

    def rows(self, name: str) -> int:
        return self._mdf.groups[self._numbers[name]].channel_group.cycles_nr

    def blocks(self, name: str, rows: int = BLOCK_ROWS) -> Iterator[np.ndarray]:
        has_text = any(column.is_text for column in self.groups[name].columns)
        with damage(self._path, *UNREADABLE):
            for block in [self._whole(name)] if has_text else self._slices(name):
                for first in range(0, len(block), rows):
                    yield block[first : first + rows]

    def _whole(self, name: str) -> np.ndarray:
        """All rows at once: texts lie outside of the rows. No group of many rows has any."""
        block = np.empty(self.rows(name), self.groups[name].dtype)
        for index, column in enumerate(self.groups[name].columns, start=1):
            options = {"raw": True, "ignore_invalidation_bits": True}
            block[column.name] = self._mdf.get(group=self._numbers[name], index=index, **options).samples
        return block

    def _slices(self, name: str) -> Iterator[np.ndarray]:
        """By asammdf's loader of whole rows: its access by channel decompresses the file anew for each slice."""
        group, record = self._mdf.groups[self._numbers[name]], self._record(name)
        for begin in range(0, self.rows(name), SLICE_ROWS):
            count = min(SLICE_ROWS, self.rows(name) - begin)
            parts = self._mdf._mdf._load_data(group, record_offset=begin, record_count=count)
            records = np.frombuffer(b"".join(bytes(part.data) for part in parts), record, count)
            block = np.empty(count, self.groups[name].dtype)
            for column in self.groups[name].columns:
                block[column.name] = records[column.name]
            yield block

    def _record(self, name: str) -> np.dtype:
        """The layout of a row in the file, whose first channel is the master."""
        group, columns = self._mdf.groups[self._numbers[name]], self.groups[name].columns
        layout = {
            "names": [column.name for column in columns],
            "formats": [column.kind for column in columns],
            "offsets": [channel.byte_offset for channel in group.channels[1:]],
            "itemsize": group.channel_group.samples_byte_nr,
        }
        return np.dtype(layout)


def opened(path: Path) -> MDF:
    """asammdf complains on stderr about what it has opened halfway; what is raised here says as much."""
    hook, sys.unraisablehook = sys.unraisablehook, lambda _: None
    try:
        try:
            return MDF(path)
        except UNREADABLE as error:
            refusal = unreadable(path, error, "is truncated or damaged, and cannot be read")
        gc.collect()  # what was opened halfway is in a cycle
    finally:
        sys.unraisablehook = hook
    raise refusal


def check_whole(path: Path) -> None:
    """MdfSink's files have the description of their groups at the end: without it nothing of them is readable."""
    with path.open("rb") as file:
        begin = file.read(HEADER_AT + 32)
    if begin[:3] != b"MDF" or len(begin) < HEADER_AT + 32:
        raise UserError(f"{path} is no MDF file.")
    if not begin[8:16].startswith(b"4"):
        version = begin[8:16].decode("ascii", "replace").strip(" \0")
        raise UserError(f"{path} is MDF {version}, and MDF 4 is read.")
    first_group = int.from_bytes(begin[HEADER_AT + 24 :], "little")
    if first_group >= path.stat().st_size:
        raise UserError(f"{path} is truncated: it lacks its end, without which nothing of it is readable.")
