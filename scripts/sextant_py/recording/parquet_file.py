"""Recordings as Parquet: a file a group; units and descriptions are metadata of its fields."""

import json
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import numpy as np
import pyarrow
from pyarrow import parquet

from ..errors import UserError
from . import arrow_table
from .model import BLOCK_ROWS, MAIN, Group, Metadata, damage, metadata_of, of_sextant, unreadable

ROW_GROUP_ROWS = 131_072


class ParquetSink:
    """Rows are gathered to row groups. A Parquet file is readable once it is closed."""

    def __init__(self, path: Path, metadata: Metadata) -> None:
        self._path = path
        self._metadata = metadata
        self._groups: dict[str, Group] = {}
        self._schemas: dict[str, pyarrow.Schema] = {}
        self._writers: dict[str, parquet.ParquetWriter] = {}
        self._waiting: dict[str, list[np.ndarray]] = {}
        self.kept: dict[str, int] = {}

    def abandon(self) -> None:
        """Gives up the files, of which none is readable."""
        for writer in self._writers.values():
            writer.is_open = False  # it shall not write its end
            with suppress(OSError):
                writer.file_handle.close()

    def _file(self, name: str) -> Path:
        return arrow_table.file_of(self._path, name, self._metadata.get("main", MAIN))

    def add(self, group: Group) -> None:
        self._groups[group.name] = group
        self._schemas[group.name] = arrow_table.schema(group)
        self._writers[group.name] = parquet.ParquetWriter(
            self._file(group.name), self._schemas[group.name], compression="zstd", write_page_checksum=True
        )
        self._waiting[group.name] = []
        self.kept[group.name] = 0

    def append(self, name: str, block: np.ndarray) -> None:
        self._waiting[name].append(block)
        self.kept[name] += len(block)
        if sum(map(len, self._waiting[name])) >= ROW_GROUP_ROWS:
            self._flush(name)

    def _flush(self, name: str) -> None:
        if self._waiting[name]:
            block, self._waiting[name] = np.concatenate(self._waiting[name]), []
            self._writers[name].write_table(arrow_table.table(self._groups[name], block, self._schemas[name]))

    def close(self, metadata: Metadata) -> None:
        about = json.dumps({**metadata, "rows": self.kept}, ensure_ascii=False)
        for name, writer in self._writers.items():
            self._flush(name)
            writer.add_key_value_metadata({arrow_table.RECORDING.decode(): about})
            writer.close()


class ParquetSource:
    """NAME.parquet and its groups NAME.GROUP.parquet."""

    unverified = None  # its blocks have checksums

    def __init__(self, path: Path) -> None:
        self._path = path
        self.paths: list[Path] = []
        self.metadata: Metadata = {}
        self.groups: dict[str, Group] = {}
        self.cut: str | None = None
        self._files: dict[str, parquet.ParquetFile] = {}
        for place in [path, *sorted(path.parent.glob(f"{path.stem}.*{path.suffix}"))]:
            if place.exists():
                self._add(path, place)
        if not self.groups:
            raise UserError(f"{path} holds no group of a Sextant recording; scripts/convert writes such files.")

    def _add(self, path: Path, place: Path) -> None:
        try:
            file = parquet.ParquetFile(place, page_checksum_verification=True)
        except (pyarrow.ArrowException, OSError) as error:
            what = "is no Parquet file, or truncated: it lacks its end, without which nothing of it is readable"
            raise unreadable(place, error, what) from None
        about = file.schema_arrow.metadata or {}
        if arrow_table.GROUP not in about:
            return
        stored = (file.metadata.metadata or {}).get(arrow_table.RECORDING)
        with damage(place, ValueError):
            described, recording = json.loads(about[arrow_table.GROUP]), json.loads(stored) if stored else {}
        with of_sextant(place, "its description of the group"):
            group, metadata = Group.of(described), metadata_of(recording)
            if not file.schema_arrow.equals(arrow_table.schema(group), check_metadata=False):
                raise ValueError("other columns than those described")
        if arrow_table.file_of(path, group.name, metadata.get("main", MAIN)) != place:
            return  # of a recording whose name begins the same
        self.groups[group.name] = group
        self._files[group.name] = file
        self.paths.append(place)
        self.metadata = metadata

    def rows(self, name: str) -> int:
        return self._files[name].metadata.num_rows

    def blocks(self, name: str, rows: int = BLOCK_ROWS) -> Iterator[np.ndarray]:
        place = arrow_table.file_of(self._path, name, self.metadata.get("main", MAIN))
        with damage(place, pyarrow.ArrowException, OSError):
            for batch in self._files[name].iter_batches(rows):
                arrow_table.check_cells(place, self.groups[name], batch)
                yield arrow_table.block(self.groups[name], batch)
