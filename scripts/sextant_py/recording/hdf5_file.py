"""Recordings as HDF5: a dataset a signal, with unit and description; the group telemetry is the root."""

import io
import json
import os
import re
from collections.abc import Iterator
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from ..errors import UserError
from . import topics
from .model import (
    BLOCK_ROWS,
    MAIN,
    TIMES,
    Column,
    Group,
    Metadata,
    cut_sentence,
    damage,
    left,
    metadata_of,
    missing_rows,
    of_sextant,
    unclosed_sentence,
    unverified_sentence,
)

ATTRIBUTE = "recording"  # of the root: the metadata as JSON, and blanks
# Reserved at the beginning: it is written in place at the end, and a cut of the file leaves it. HDF5 allows 64 KiB.
ATTRIBUTE_BYTES = 32_000
MOST_NAMES = 5  # in a sentence
UNREADABLE = (OSError, RuntimeError, KeyError, ValueError, TypeError)  # what h5py raises at damage


class Hdf5Sink:
    """The layout of a trace.

    HDF5 loses the whole file, and crashes at exit, where its own writes find no room. So the room is taken first, for
    more than the rows can need: every chunk they touch and its index.
    """

    CHUNK_ROWS = 4096
    INDEX_BYTES = 16_384

    def __init__(self, path: Path, metadata: Metadata) -> None:
        self._path = path
        # Space that was given up is not used again: what one flush left behind stays whole during the next.
        # Headers and attributes of HDF5 1.8 have checksums.
        self._file = h5py.File(path, "w", fs_strategy="none", libver=("v108", "latest"))
        self._groups: dict[str, Group] = {}
        self._datasets: dict[str, list[h5py.Dataset]] = {}
        self.kept: dict[str, int] = {}
        try:
            self._reserve(())
            self._describe(metadata)
            for name, value in metadata.get("attributes", {}).items():
                self._file.attrs[name] = value
            self._file.flush()
        except OSError:
            self._file.close()
            raise

    def _describe(self, metadata: Metadata) -> None:
        text = json.dumps(metadata, ensure_ascii=False).encode().ljust(ATTRIBUTE_BYTES)
        if len(text) > ATTRIBUTE_BYTES:
            raise OSError(0, f"the metadata of the recording take more than {ATTRIBUTE_BYTES} bytes")
        self._file.attrs.modify(ATTRIBUTE, np.array(text, f"S{ATTRIBUTE_BYTES}"))

    def _reserve(self, columns: tuple[Column, ...], rows: int = 0) -> None:
        """Room for so many rows of the columns, and for the metadata."""
        need = sum(
            (rows + 2 * self.CHUNK_ROWS) * np.dtype(column.kind).itemsize + self.INDEX_BYTES for column in columns
        )
        os.posix_fallocate(self._file.id.get_vfd_handle(), self._file.id.get_filesize(), need + 4 * ATTRIBUTE_BYTES)

    def _stored(self, group: Group) -> tuple[Column, ...]:
        return tuple(column for column in group.columns if not (group.time_of and column.name == group.time))

    def add(self, group: Group) -> None:
        self._reserve(group.columns)
        place = self._file if group.name == MAIN else self._file.require_group(group.name)
        self._groups[group.name] = group
        self._datasets[group.name] = [self._create(place, column) for column in self._stored(group)]
        if group.text and group.name != MAIN:
            place.attrs["description"] = group.text
        self.kept[group.name] = 0
        self._file.flush()

    def _create(self, place: h5py.Group, column: Column) -> h5py.Dataset:
        shape = {"shape": (0,), "maxshape": (None,), "chunks": (self.CHUNK_ROWS,)}
        dataset = place.create_dataset(column.name, dtype=np.dtype(column.kind), fletcher32=True, **shape)
        if column.unit:
            dataset.attrs["unit"] = column.unit
        if column.text:
            dataset.attrs["description"] = column.text
        return dataset

    def append(self, name: str, block: np.ndarray) -> None:
        columns = self._stored(self._groups[name])
        self._reserve(columns, len(block))
        for dataset, column in zip(self._datasets[name], columns, strict=True):
            dataset.resize(self.kept[name] + len(block), axis=0)
            dataset[-len(block) :] = block[column.name]
        self._file.flush()
        self.kept[name] += len(block)

    def close(self, metadata: Metadata) -> None:
        try:
            self._reserve(())
            self._describe(metadata)
        except OSError:
            pass  # the metadata of the beginning stay
        finally:
            self._file.close()
            self._give_back()

    def _give_back(self) -> None:
        """The room that was taken and not used: what stands behind the end that the superblock names."""
        with self._path.open("rb") as file:
            end = int.from_bytes(file.read(36)[28:36], "little")
        if end < self._path.stat().st_size:
            os.truncate(self._path, end)


class PaddedFile(io.RawIOBase):
    """A truncated file that reads as zeros behind its cut, so that HDF5 opens it."""

    def __init__(self, path: Path, size: int) -> None:
        self._file = path.open("rb")
        self._size = size
        self._at = 0

    def readable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def seek(self, offset: int, whence: int = io.SEEK_SET) -> int:
        self._at = offset + {io.SEEK_SET: 0, io.SEEK_CUR: self._at, io.SEEK_END: self._size}[whence]
        return self._at

    def tell(self) -> int:
        return self._at

    def readinto(self, buffer: Any) -> int:
        view = memoryview(buffer).cast("B")
        wanted = max(0, min(len(view), self._size - self._at))
        self._file.seek(self._at)
        read = self._file.readinto(view[:wanted])
        view[read:wanted] = bytes(wanted - read)
        self._at += wanted
        return wanted

    def close(self) -> None:
        self._file.close()
        super().close()


class Hdf5Source:
    """A recording of scripts/record or a trace of sextant-mil. HDF5 verifies headers, attributes and values by their
    checksums; the index of the chunks has none, and is compared with the number of rows."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self.paths = [path]
        self._size = path.stat().st_size
        self.cut: str | None = None
        self.unverified: str | None = None
        self._file = self._open(path)
        self.metadata: Metadata = self._metadata()
        self.groups: dict[str, Group] = {}
        self._rows: dict[str, int] = {}
        self._places: dict[str, h5py.Group] = {}
        self._left_out: list[str] = []  # datasets without a time axis
        self._unlike: list[str] = []  # datasets that are longer than others beside them
        self._met: set[int] = set()  # groups, by their addresses: a group may have several names, or hold itself
        with nullcontext() if self._is_padded else damage(path, *UNREADABLE):
            self._add("", self._file)
        if not self.groups and self._is_padded:
            raise UserError(f"{path} is truncated, and nothing of it is readable.")
        if not self.groups:
            raise UserError(f"{path} has no signals with a time axis ({', '.join(TIMES)}), so it is no recording.")
        if self._is_padded:
            lost = missing_rows(self.metadata, self._rows)
            text = ", ".join(f"{count} of {name}" for name, count in lost.items())
            self.cut = cut_sentence(path, self._rows, f"rows that are lost: {text or 'an unknown number'}")
        else:
            self.cut = unclosed_sentence(path, self.metadata, self._rows) or self._unlike_sentence()
        if self._left_out:
            names = ", ".join(self._left_out[:MOST_NAMES]) + (" …" if len(self._left_out) > MOST_NAMES else "")
            note = f"what has no time axis is left out: {names}"
            self.unverified = f"{self.unverified}; {note}" if self.unverified else f"{path}: {note}"

    def _unlike_sentence(self) -> str | None:
        if not self._unlike:
            return None
        longer = ", ".join(self._unlike[:MOST_NAMES])
        return f"{self._path} has signals with more values than others beside them: {longer}; {left(self._rows)}"

    def _open(self, path: Path) -> h5py.File:
        """Without a lock, which a recorder holds on the file that it writes."""
        self._is_padded = False
        try:
            return h5py.File(path, "r", locking=False)
        except OSError as error:
            if error.errno:
                raise UserError(f"{path} cannot be read: {os.strerror(error.errno)}.") from None
            if not (found := re.search(r"truncated file.*stored_eof = (\d+)", str(error))):
                if h5py.is_hdf5(path):
                    raise UserError(f"{path} cannot be read: {error}.") from None
                raise UserError(f"{path} is not an HDF5 file.") from None
            self._is_padded = True
            size = int(found[1])
        try:
            return h5py.File(PaddedFile(path, size), "r")
        except (OSError, RuntimeError):
            raise UserError(
                f"{path} is truncated: {self._size} of {size} bytes are there, and nothing of it is readable."
            ) from None

    def _metadata(self) -> Metadata:
        try:
            stored = self._file.attrs.get(ATTRIBUTE)
            found = json.loads(value_of(stored)) if stored is not None else {"attributes": self._attributes()}
        except (OSError, RuntimeError, KeyError, ValueError):
            if self._is_padded:
                raise UserError(f"{self._path} is truncated, and nothing of it is readable.") from None
            raise UserError(f"{self._path} has no readable attribute {ATTRIBUTE}; it is no recording.") from None
        with of_sextant(self._path, f"the attribute {ATTRIBUTE}"):
            return metadata_of(found)

    def _attributes(self) -> dict[str, Any]:
        return {name: value_of(value) for name, value in self._file.attrs.items()}

    def _member(self, place: h5py.Group, key: str) -> Any:
        try:
            return place[key]
        except (OSError, RuntimeError, KeyError):
            if isinstance(place.get(key, getlink=True), h5py.HardLink):
                raise
            name = f"{place.name.rstrip('/')}/{key}"
            raise UserError(
                f"{self._path} was not written by Sextant: it has the link {name} to what is not there."
            ) from None

    def _add(self, path: str, place: h5py.Group) -> None:
        """The group at a path, and those in it. The root's name is that of the telemetry."""
        address = h5py.h5o.get_info(place.id).addr
        if address in self._met:
            return
        self._met.add(address)
        try:
            # items() gives None for a member whose header is damaged or behind the cut.
            members = list(place.items()) if self._is_padded else [(key, self._member(place, key)) for key in place]
        except (OSError, RuntimeError, KeyError):
            if not self._is_padded:
                raise
            return  # behind the cut
        datasets = {key: data for key, data in members if isinstance(data, h5py.Dataset) and data.ndim == 1}
        others = [data.name for _, data in members if isinstance(data, h5py.Dataset) and data.ndim != 1]
        self._left_out += others
        if datasets:
            self._add_group(self._free_name(path or MAIN), place, datasets)
        for key, member in members:
            if isinstance(member, h5py.Group):
                self._add(f"{path}/{key}" if path else key, member)

    def _free_name(self, name: str) -> str:
        """A group of a file of other origin may have the name that the signals of the root have."""
        number, free = 1, name
        while free in self.groups:
            number += 1
            free = f"{name}_{number}"
        return free

    def _add_group(self, name: str, place: h5py.Group, datasets: dict[str, h5py.Dataset]) -> None:
        columns = [column_of(key, data) for key, data in datasets.items()]
        for data in datasets.values():
            self._check_index(data)
        counts = {data.name: self._readable_rows(data) for data in datasets.values()}
        rows = min(counts.values())
        if max(counts.values()) > rows:
            self._unlike.append(max(counts, key=counts.get))
        shares = not any(column.name in TIMES for column in columns)
        if shares and (MAIN not in self.groups or (rows != self._rows[MAIN] and not self._is_padded)):
            self._left_out += [data.name for data in datasets.values()]
            return
        if shares:
            rows = min(rows, self._rows[MAIN])
            main = self.groups[MAIN]
            columns.insert(0, next(column for column in main.columns if column.name == main.time))
        columns.sort(key=lambda column: place_of(name, column.name))
        text = "" if name == MAIN else text_of(place.attrs.get("description", ""))
        self._places[name] = place
        self.groups[name] = Group(name, tuple(columns), text, MAIN if shares else "")
        self._rows[name] = rows

    def _check_index(self, data: h5py.Dataset) -> None:
        """A chunk that is missing, at another place or without its checksum would give other rows, or zeros."""
        if not data.fletcher32:
            self.unverified = unverified_sentence(self._path)
            return
        if self._is_padded:
            return
        found: list[tuple[int, int]] = []
        data.id.chunk_iter(lambda chunk: found.append((chunk.chunk_offset[0], chunk.filter_mask)))
        if sorted(found) != [(begin, 0) for begin in range(0, len(data), data.chunks[0])]:
            raise UserError(f"{self._path} is damaged and cannot be read: its index of {data.name} is wrong.")

    def _readable_rows(self, data: h5py.Dataset) -> int:
        """Rows before the first chunk that reaches behind the cut."""
        if not self._is_padded or not len(data):
            return len(data)
        rows = 0
        try:
            while rows < len(data):
                chunk = data.id.get_chunk_info_by_coord((rows,))
                if chunk.byte_offset is None or chunk.byte_offset + chunk.size > self._size:
                    break
                rows += data.chunks[0]
        except (OSError, RuntimeError, ValueError):
            pass  # its place is behind the cut
        return min(rows, len(data))

    def rows(self, name: str) -> int:
        return self._rows[name]

    def blocks(self, name: str, rows: int = BLOCK_ROWS) -> Iterator[np.ndarray]:
        group = self.groups[name]
        for begin in range(0, self._rows[name], rows):
            end = min(begin + rows, self._rows[name])
            block = np.empty(end - begin, group.dtype)
            for column in group.columns:
                is_shared = group.time_of and column.name == group.time
                place = self._places[group.time_of if is_shared else name]
                with damage(self._path, *UNREADABLE):
                    block[column.name] = place[column.name][begin:end]
            yield block


def place_of(group: str, signal: str) -> tuple[bool, int]:
    """HDF5 sorts names by the alphabet; the contract's order is restored, other groups have the time axis first."""
    known = [column.name for column in topics.group_of(group).columns] if group in topics.TOPICS else []
    return (signal not in TIMES and signal not in known, known.index(signal) if signal in known else 0)


def value_of(attribute: Any) -> Any:
    """An attribute as JSON holds it. Where a text is not UTF-8, it is Latin-1."""
    if isinstance(attribute, np.ndarray | np.generic):
        attribute = attribute.tolist()
    if isinstance(attribute, list):
        return [value_of(value) for value in attribute]
    if isinstance(attribute, str):
        attribute = attribute.encode("utf-8", "surrogateescape")  # h5py's, of bytes that are not UTF-8
    if isinstance(attribute, bytes):
        try:
            return attribute.decode()
        except UnicodeDecodeError:
            return attribute.decode("latin-1")
    return attribute if isinstance(attribute, int | float | type(None)) else str(attribute)


def text_of(attribute: Any) -> str:
    """An attribute that is a text, or a list of one."""
    value = value_of(attribute)
    return str(value[0] if isinstance(value, list) and len(value) == 1 else value)


def column_of(name: str, data: h5py.Dataset) -> Column:
    unit, text = (text_of(data.attrs.get(key, "")) for key in ("unit", "description"))
    kind = data.dtype
    if kind.kind not in "iufbS":
        raise UserError(f"{data.file.filename}: the signal {data.name} has the type {kind}, which no recording has.")
    return Column(name, "|u1" if kind.kind == "b" else np.dtype(kind.str).newbyteorder("=").str, unit, text)
