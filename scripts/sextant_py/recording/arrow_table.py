"""Blocks of a group as Arrow tables, for CSV and Parquet, and the files of a recording that has one file a group."""

import json
from pathlib import Path

import numpy as np
import pyarrow

from ..errors import UserError
from .model import MAIN, Group

GROUP = b"sextant_group"
RECORDING = b"sextant_recording"


def file_of(path: Path, group: str, main: str = MAIN) -> Path:
    """NAME.csv for the main group, NAME.GROUP.csv for the others; a "/" of the group's name becomes a point."""
    return path if group == main else path.with_name(f"{path.stem}.{group.replace('/', '.')}{path.suffix}")


def schema(group: Group, metadata: dict | None = None) -> pyarrow.Schema:
    fields = []
    for column in group.columns:
        kind = pyarrow.string() if column.is_text else pyarrow.from_numpy_dtype(np.dtype(column.kind))
        about = {"unit": column.unit, "description": column.text}
        fields.append(pyarrow.field(column.name, kind, nullable=False, metadata=about))
    about = {GROUP: json.dumps(group.described(), ensure_ascii=False)}
    if metadata is not None:
        about[RECORDING] = json.dumps(metadata, ensure_ascii=False)
    return pyarrow.schema(fields, metadata=about)


def table(group: Group, block: np.ndarray, of: pyarrow.Schema) -> pyarrow.Table:
    arrays = []
    for column in group.columns:
        values = block[column.name]
        if column.is_text:
            arrays.append(pyarrow.array([bytes(value).decode("utf-8", "replace") for value in values]))
        else:
            arrays.append(pyarrow.array(np.ascontiguousarray(values)))
    return pyarrow.Table.from_arrays(arrays, schema=of)


def check_cells(path: Path, group: Group, batch: pyarrow.RecordBatch) -> None:
    """An empty cell is NaN, which a whole number or a text cannot be."""
    for index, column in enumerate(group.columns):
        if batch.column(index).null_count and np.dtype(column.kind).kind in "iuS":
            what = "texts" if column.is_text else "whole numbers"
            raise UserError(f"{path}: the column {column.name} of {what} has an empty cell; write a value there.")


def block(group: Group, batch: pyarrow.RecordBatch) -> np.ndarray:
    rows = np.empty(batch.num_rows, group.dtype)
    for index, column in enumerate(group.columns):
        values = batch.column(index)
        rows[column.name] = (
            [str(value).encode() for value in values.to_pylist()]
            if column.is_text
            else values.to_numpy(zero_copy_only=False)
        )
    return rows
