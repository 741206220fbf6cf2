"""Recordings as CSV: a file a group, NAME.csv.json with types, units and descriptions, and NAME.csv.sha256."""

import csv as text_csv
import io
import json
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow
from pyarrow import csv

from ..append_file import AppendFile
from ..csv_heading import CONTROL, refuse_control, refuse_separators, refuse_twice
from ..errors import UserError
from . import arrow_table, checksums
from .model import (
    BLOCK_ROWS,
    MAIN,
    Column,
    Group,
    Metadata,
    cut_sentence,
    metadata_of,
    missing_rows,
    unclosed_sentence,
    unverified_sentence,
)

BLOCK_BYTES = 1 << 22
INDEX = "index"


def description_of(path: Path) -> Path:
    return path.with_name(path.name + ".json")


class CsvSink:
    """A line a row, appended whole."""

    def __init__(self, path: Path, metadata: Metadata) -> None:
        self._path = path
        self._metadata = metadata
        self._groups: dict[str, Group] = {}
        self._schemas: dict[str, pyarrow.Schema] = {}
        self._files: dict[str, AppendFile] = {}
        self.kept: dict[str, int] = {}
        checksums.place_of(path).unlink(missing_ok=True)  # of a recording that had the name

    def add(self, group: Group) -> None:
        self._groups[group.name] = group
        self._schemas[group.name] = arrow_table.schema(group)
        self._files[group.name] = AppendFile(self._file(group.name))
        heading = io.StringIO()
        text_csv.writer(heading, lineterminator="\n").writerow([column.name for column in group.columns])
        self._files[group.name].append(heading.getvalue())
        self.kept[group.name] = 0
        self._describe(self._metadata)

    def _file(self, name: str) -> Path:
        return arrow_table.file_of(self._path, name, self._metadata.get("main", MAIN))

    def _describe(self, metadata: Metadata) -> None:
        groups = [group.described() for group in self._groups.values()]
        text = json.dumps({"recording": metadata, "groups": groups}, ensure_ascii=False, indent=1)
        place = description_of(self._path)
        new = place.with_name(place.name + ".new")
        try:
            new.write_text(text + "\n", encoding="utf-8")
        except OSError:
            new.unlink(missing_ok=True)
            raise
        new.replace(place)

    def append(self, name: str, block: np.ndarray) -> None:
        text = io.BytesIO()
        options = csv.WriteOptions(include_header=False, quoting_style="needed")
        csv.write_csv(arrow_table.table(self._groups[name], block, self._schemas[name]), text, options)
        self._files[name].append_bytes(text.getvalue())
        self.kept[name] += len(block)

    def close(self, metadata: Metadata) -> None:
        try:
            if self._groups:
                self._describe({**metadata, "rows": self.kept})
                places = [self._file(name) for name in self._groups]
                checksums.write(self._path, [*places, description_of(self._path)])
        except OSError:
            pass  # the description of the beginning stays, or there are no checksums
        finally:
            for file in self._files.values():
                file.close()


class WholeLines(io.RawIOBase):
    """A text file up to its last complete line; of other origin whole, since its last line may have no end."""

    def __init__(self, path: Path, is_foreign: bool = False) -> None:
        self._path, self._is_foreign = path, is_foreign
        self._file = path.open("rb")
        self.end = size = path.stat().st_size
        tail = b"\n" if is_foreign else b""
        while self.end and b"\n" not in tail:
            begin = max(0, self.end - 65536)
            self._file.seek(begin)
            tail = self._file.read(self.end - begin)
            self.end = begin + (tail.rfind(b"\n") + 1)
        self.cut_bytes = size - self.end
        self._file.seek(0)

    def readable(self) -> bool:
        return True

    def readinto(self, buffer: Any) -> int:
        data = self._file.read(min(len(buffer), self.end - self._file.tell()))
        if self._is_foreign and CONTROL.search(data):
            refuse_control(self._path, self._path.read_bytes())
        buffer[: len(data)] = data
        return len(data)

    def close(self) -> None:
        self._file.close()
        super().close()


class CsvSource:
    """A recording of scripts/record or scripts/convert, or any CSV file that has a time axis."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self.metadata: Metadata = {}
        self.cut: str | None = None
        self.groups: dict[str, Group] = {}
        self._bools: set[str] = set()  # columns of other origin that say true and false
        place = description_of(path)
        listed = checksums.read(path)
        self._heading = heading_of(path) if not place.exists() and listed is None else None  # of a file of other origin
        if listed is not None and (place.exists() or place.name in listed):
            checksums.verify(path, listed, place)
        if place.exists():
            self._read_description(place)
        else:
            self.groups = {MAIN: self._guessed()}
        beside = [other for other in (place, checksums.place_of(path)) if other.exists()]
        self.paths = [*(self._file(name) for name in self.groups), *beside]
        self._rows = {name: self._count(name) for name in self.groups}
        cut = {name for name in self.groups if self._lines(name).cut_bytes}
        lost = missing_rows(self.metadata, self._rows)
        if listed is not None:
            self._verify(listed, cut | lost.keys())
        if cut or lost:
            text = ", ".join(f"{count} of {name}" for name, count in lost.items()) or "the one of its last line"
            self.cut = cut_sentence(path, self._rows, f"rows that are lost: {text}")
        else:
            self.cut = unclosed_sentence(path, self.metadata, self._rows)
        self.unverified = None if listed is not None or self.cut else unverified_sentence(path)

    def _verify(self, listed: checksums.Listed, cut: set[str]) -> None:
        for name in self.groups:
            checksums.verify(self._path, listed, self._file(name), name in cut)
        checksums.verify_names(self._path, listed, self.paths)

    def _file(self, name: str) -> Path:
        return arrow_table.file_of(self._path, name, self.metadata.get("main", MAIN))

    def _lines(self, name: str) -> WholeLines:
        return WholeLines(self._file(name), self._heading is not None)

    def _options(self, **more: Any) -> csv.ReadOptions:
        """A heading of other origin has the names that it was given here."""
        found = self._heading
        names = {} if found is None else {"column_names": found.names, "skip_rows": found.lines}
        return csv.ReadOptions(use_threads=False, **names, **more)

    def _read_description(self, place: Path) -> None:
        try:
            described = json.loads(place.read_text(encoding="utf-8"))
            self.metadata = metadata_of(described["recording"])
            self.groups = {entry["name"]: Group.of(entry) for entry in described["groups"]}
        except (ValueError, KeyError, TypeError):
            raise UserError(
                f"{place} does not describe a recording as Sextant does; where it is of another program, rename it."
            ) from None
        for name in self.groups:
            if not self._file(name).exists():
                raise UserError(f"{self._file(name)} does not exist, which {place} names as the group {name}.")

    def _guessed(self) -> Group:
        """Types as the first block has them, where no description says them."""
        try:
            with csv.open_csv(self._lines(MAIN), self._options()) as reader:
                fields = list(reader.schema)
                first = reader.read_next_batch() if any(is_text(field) for field in fields) else None
        except pyarrow.ArrowException as error:
            raise unreadable(self._path, error) from None
        self._bools = {field.name for field in fields if pyarrow.types.is_boolean(field.type)}
        columns = [guessed_column(self._path, field, first) for field in fields]
        return Group(MAIN, tuple(map(of_contract, columns)))

    def _count(self, name: str) -> int:
        if self._heading is not None:
            with self._opened(name) as reader:
                return sum(batch.num_rows for batch in reader)
        lines, source = 0, self._lines(name)
        buffer = bytearray(BLOCK_BYTES)
        while count := source.readinto(buffer):
            lines += buffer.count(b"\n", 0, count)
        return max(lines - 1, 0)

    def rows(self, name: str) -> int:
        return self._rows[name]

    def blocks(self, name: str, rows: int = BLOCK_ROWS) -> Iterator[np.ndarray]:
        if not self._rows[name]:
            return
        group = self.groups[name]
        checked: set[str] = set()  # columns with infinities that the file says
        with self._opened(name) as reader:
            for batch in reader:
                arrow_table.check_cells(self._file(name), group, batch)
                whole = arrow_table.block(group, batch)
                for column in infinite_columns(group, whole) - checked:
                    self._refuse_beyond_range(name, column)
                    checked.add(column)
                for begin in range(0, len(whole), rows):
                    yield whole[begin : begin + rows]

    def _refuse_beyond_range(self, name: str, column: str) -> None:
        """Refuses a number beyond the range of the column's type, which would be read as infinity."""
        kind, row = np.dtype(self.groups[name].dtype[column]).type, 0
        with self._opened(name, {column: pyarrow.string()}) as reader:
            for batch in reader:
                for cell in batch.column(0).to_pylist():
                    row += 1
                    if is_beyond_range(cell or "", kind):
                        where = f"{self._file(name)}, row {row} of {name}"
                        raise UserError(f'{where}: {column} must be a finite number, not "{cell}".')

    @contextmanager
    def _opened(self, name: str, types: dict[str, pyarrow.DataType] | None = None) -> Iterator[csv.CSVStreamingReader]:
        """types: of the columns that are read, where not all are as the group says."""
        if types is None:
            types = {field.name: field.type for field in arrow_table.schema(self.groups[name])}
            types |= dict.fromkeys(self._bools, pyarrow.bool_())
        read = self._options(block_size=BLOCK_BYTES)
        convert = csv.ConvertOptions(column_types=types, include_columns=list(types), strings_can_be_null=False)
        try:
            with csv.open_csv(self._lines(name), read, convert_options=convert) as reader:
                yield reader
        except pyarrow.ArrowException as error:
            raise unreadable(self._file(name), error) from None


@dataclass
class Heading:
    """The names of the columns, and the lines up to the first row."""

    names: list[str]
    lines: int


def _lines_of(path: Path) -> Iterator[tuple[int, str]]:
    """The lines of a file of other origin up to its heading, numbered, with any line end."""
    try:
        with path.open(encoding="utf-8-sig") as file:
            for number, line in enumerate(file, 1):
                refuse_control(path, line.encode(), number)
                yield number, line
    except UnicodeDecodeError:
        raise not_utf8(path) from None


def heading_of(path: Path) -> Heading:
    """The first line that is neither empty nor a comment. The first name may be empty, as pandas writes an index."""
    found = next((place for place in _lines_of(path) if place[1].strip() and not place[1].startswith("#")), None)
    if found is None:
        raise UserError(f"{path} is not a CSV file of a recording: it has no heading.")
    number, line = found
    where = f"{path}:{number}"
    try:
        names = next(text_csv.reader([line.rstrip("\n")], strict=True), [])
    except text_csv.Error:
        raise UserError(f"{where}: a quote of the heading is not closed.") from None
    refuse_separators(names, where)
    names = [name.strip() or (INDEX if at == 0 else "") for at, name in enumerate(names)]
    if "" in names:
        raise UserError(f"{where}: column {names.index('') + 1} has no name; give it one.")
    for name in names:
        refuse_twice(name, names, where)
    return Heading(names, number)


def not_utf8(path: Path) -> UserError:
    """About the first line that is no text in UTF-8."""
    with path.open("rb") as file:
        for number, line in enumerate(file, 1):
            try:
                line.decode()
            except UnicodeDecodeError:
                return UserError(f"{path}, line {number}: this is no text in UTF-8; save the file in that encoding.")
    return UserError(f"{path} is no text in UTF-8; save it in that encoding.")


def infinite_columns(group: Group, block: np.ndarray) -> set[str]:
    floats = (column.name for column in group.columns if np.dtype(column.kind).kind == "f")
    return {name for name in floats if np.isinf(block[name]).any()}


def is_beyond_range(cell: str, kind: type[np.floating]) -> bool:
    """Whether a cell says a finite number that its type does not hold."""
    try:
        with np.errstate(over="ignore"):
            return bool(np.isinf(kind(float(cell)))) and "inf" not in cell.lower()
    except ValueError:
        return False


def is_utf8(path: Path) -> bool:
    try:
        with path.open(encoding="utf-8") as file:
            while file.read(BLOCK_BYTES):
                pass
    except UnicodeDecodeError:
        return False
    return True


def unreadable(path: Path, error: Exception) -> UserError:
    """Where pyarrow, which counts lines in one thread only, names a line, so does the sentence."""
    if not is_utf8(path):
        return not_utf8(path)
    text = " ".join(str(error).split())
    if found := re.search(r"Row #(\d+): (.*)", text):
        return UserError(f"{path}, line {found[1]}: {found[2].rstrip('.')}; correct or remove that line.")
    return UserError(f"{path} is not a CSV file of a recording: {text.rstrip('.')}.")


def of_contract(column: Column) -> Column:
    """A guessed column that has the name of a member of DriveTelemetry, with its unit and text. Whole numbers are those
    of the contract alone: another column may have decimals behind the first block."""
    from .topics import group_of

    known = next((known for known in group_of(MAIN).columns if known.name == column.name), None)
    if known is None:
        return column
    is_whole = column.kind != "|u1" and np.dtype(known.kind).kind in "iu"
    return Column(column.name, "<i8" if is_whole else column.kind, known.unit, known.text)


def is_text(field: pyarrow.Field) -> bool:
    return pyarrow.types.is_string(field.type) or pyarrow.types.is_binary(field.type)


def guessed_column(path: Path, field: pyarrow.Field, first: pyarrow.RecordBatch | None) -> Column:
    """first: the first rows, where a column holds texts."""
    if is_text(field):
        raise not_a_number(path, field.name, first.column(field.name).to_pylist())
    if pyarrow.types.is_temporal(field.type):
        raise UserError(f"{path}: the column {field.name} has dates or times of day; write seconds, or leave it out.")
    if pyarrow.types.is_null(field.type):
        return Column(field.name, "<f8")  # no row, or none that has a value
    return Column(field.name, "|u1" if pyarrow.types.is_boolean(field.type) else "<f8")


def not_a_number(path: Path, column: str, cells: list[str | bytes]) -> UserError:
    """About the first cell that is no number, in a file without a description, which texts would need."""
    for row, cell in enumerate(cells, 1):
        try:
            float(cell or "nan")
        except ValueError:
            shown = cell if isinstance(cell, str) else cell.decode("utf-8", "replace")
            return UserError(
                f'{path}: row {row} of the column {column} has "{shown}", which is no number; correct it, or leave out '
                "a row of units or a column of texts."
            )
    return UserError(f"{path}: the column {column} holds text; leave it out.")
