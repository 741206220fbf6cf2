"""The table of a sweep: a row for each finished point, a column for each key and each metric."""

from pathlib import Path
from typing import Any

import pyarrow
import pyarrow.csv
import pyarrow.parquet

from .errors import UserError
from .sweep_file import Sweep, toml_value
from .sweep_store import SweepStore


def column(values: list[Any]) -> pyarrow.Array:
    """Numbers as numbers, texts as texts; what is mixed or a list as the file writes it."""
    present = [value for value in values if value is not None]
    kinds = {type(value) for value in present}
    if kinds == {bool}:
        return pyarrow.array(values, pyarrow.bool_())
    if kinds == {int} and all(-(2**63) <= value < 2**63 for value in present):
        return pyarrow.array(values, pyarrow.int64())
    if kinds <= {int, float}:
        return pyarrow.array([None if value is None else float(value) for value in values], pyarrow.float64())
    if kinds == {str}:
        return pyarrow.array(values, pyarrow.string())
    return pyarrow.array([None if value is None else toml_value(value) for value in values], pyarrow.string())


def build(sweep: Sweep, store: SweepStore, metrics: list[str]) -> pyarrow.Table:
    records = list(store.in_order())
    columns = {"point": pyarrow.array([record["point"] for record in records], pyarrow.int64())}
    for key in sweep.varied:
        columns[key] = column([sweep.points[record["point"]][key] for record in records])
    for metric in metrics:
        name = metric if metric not in columns else f"metrics.{metric}"
        values = [record["metrics"].get(metric) for record in records]
        columns[name] = pyarrow.array(values, pyarrow.float64())
    for name in ("status", "reason"):
        columns[name] = pyarrow.array([record[name] for record in records], pyarrow.string())
    fixed = ", ".join(f"{key} = {toml_value(value)}" for key, value in sweep.fixed.items())
    seed = "" if sweep.seed is None else str(sweep.seed)
    about = {"sweep": sweep.name, "scenario": sweep.scenario.name, "seed": seed, "set": fixed}
    return pyarrow.table(columns).replace_schema_metadata({f"sextant.{name}": text for name, text in about.items()})


def write(table: pyarrow.Table, directory: Path, csv: bool) -> list[Path]:
    """The files that were written. Each is whole or the one before."""
    writers = {"table.parquet": pyarrow.parquet.write_table}
    if csv:
        writers["table.csv"] = pyarrow.csv.write_csv
    for name, write_file in writers.items():
        part = directory / f"{name}.part"
        try:
            write_file(table, part)
            part.rename(directory / name)
        except OSError as error:
            raise UserError(f"the table {directory / name} cannot be written: {error}.") from None
    return [directory / name for name in writers]
