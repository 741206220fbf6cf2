"""Sweeps of a scenario's configuration from Python, by the machinery of scripts/sweep."""

import os
import re
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas
from sextant_py import mil_program, sweep_cluster, sweep_file, sweep_program, sweep_table
from sextant_py.errors import UserError
from sextant_py.sweep import keep_records, make_jobs
from sextant_py.sweep_file import Sweep, toml_value
from sextant_py.sweep_sample import KINDS
from sextant_py.sweep_store import SweepStore

CALL = Path("sextant.sweep")  # in messages, instead of the name of a file; it also stands for the working directory


def _axis(key: str, axis: Any, method: str, where: str) -> str:
    """A range or the choices of a key, as a sweep file has them."""
    if isinstance(axis, list):
        return toml_value(axis)
    names = ("from", "to", "count") if method == "grid" else ("from", "to")
    if not isinstance(axis, tuple) or len(axis) not in (len(names), len(names) + 1):
        parts = "(low, high, count)" if method == "grid" else "(low, high)"
        raise UserError(f'{where}: {key}: expected {parts}, with "log" at the end or not, or a list, got {axis!r}.')
    words = [f"{name} = {toml_value(value)}" for name, value in zip((*names, "scale"), axis, strict=False)]
    return "{ " + ", ".join(words) + " }"


def _entries(axes: dict[str, Any], method: str, where: str) -> list[str]:
    return [f"{toml_value(key)} = {_axis(key, axis, method, where)}" for key, axis in axes.items()]


@dataclass(frozen=True)
class _Varied:
    """What of the configuration varies, as `sweep` is told."""

    ranges: dict[str, Any]
    coupled: list[dict[str, Any]]
    points: Path | None
    method: str
    samples: int
    seed: int

    def check(self) -> None:
        if self.method != "grid" and self.method not in KINDS:
            raise UserError(f'method: expected grid, {", ".join(KINDS)}, got "{self.method}".')
        if not isinstance(self.coupled, list) or not all(isinstance(table, dict) for table in self.coupled):
            raise UserError("coupled: expected a list of dictionaries, each of keys that move together.")
        if self.points is not None and (self.ranges or self.coupled):
            other = "ranges" if self.ranges else "coupled"
            raise UserError(f"points: a list of points has every key that varies: leave {other} out.")
        if self.points is None and not self.ranges and not self.coupled:
            raise UserError("ranges, coupled or points: expected at least one key that varies.")

    def head(self) -> list[str]:
        """What a sweep file has of it before the first table."""
        return [] if self.points is None else [f"points = {toml_value(self.points)}"]

    def tables(self) -> list[str]:
        if self.points is not None:
            return []
        if self.method == "grid":
            lines = ["[grid]"]
        else:
            sample = {"method": self.method, "samples": self.samples, "seed": self.seed}
            lines = ["[random]", *(f"{key} = {toml_value(value)}" for key, value in sample.items()), "[random.ranges]"]
        lines += _entries(self.ranges, self.method, "ranges")
        for table in self.coupled:
            lines += ["[[coupled]]", *_entries(table, self.method, "coupled")]
        return lines


def _text(scenario: Path, varied: _Varied, overrides: dict[str, Any]) -> str:
    """The sweep file."""
    lines = [f"scenario = {toml_value(scenario)}", *varied.head(), "[set]"]
    lines += [f"{toml_value(key)} = {toml_value(value)}" for key, value in overrides.items()]
    return "\n".join([*lines, *varied.tables()]) + "\n"


def _table(sweep: Sweep, directory: Path, workers: int | None) -> pandas.DataFrame:
    program = mil_program.find(None)
    scenario = sweep_program.examine(program, sweep)
    configuration = sweep_program.contents(scenario, sweep)
    store = SweepStore(directory, sweep, configuration, sweep_program.fingerprint(program))
    try:
        store.open()
        if jobs := make_jobs(sweep, store, program, None):
            count = min(workers or len(os.sched_getaffinity(0)), len(jobs))
            with sweep_cluster.local_client(count) as client:
                keep_records(sweep_cluster.run_jobs(client, jobs), store, len(sweep.points))
        table = sweep_table.build(sweep, store, scenario.metrics())
    finally:
        store.close()
    frame = table.to_pandas().set_index("point")
    frame.attrs["units"] = {name: unit for name, unit in scenario.units().items() if name in frame.columns}
    return frame


def sweep(
    scenario: str | Path,
    ranges: dict[str, tuple | list] | None = None,
    samples: int = 64,
    method: str = "sobol",
    seed: int = 1,
    workers: int | None = None,
    overrides: dict[str, Any] | None = None,
    out: str | Path | None = None,
    coupled: list[dict[str, tuple | list]] | None = None,
    points: str | Path | None = None,
) -> pandas.DataFrame:
    """Runs a scenario at many points of its configuration; a row a point, with its metrics, status and reason.

    ranges: configuration keys to (low, high), to (low, high, "log"), or to a list of choices; for a grid to
    (low, high, count), (low, high, count, "log") or a list.
    samples, seed: of a sample; a grid has neither.
    method: "sobol" (scrambled; samples: a power of two), "latin_hypercube", "random" or "grid".
    workers: runs at a time; None: one for each processor.
    overrides: configuration keys that are the same in every point.
    out: a directory for finished points, with which the same call continues an interrupted sweep; None: none.
    coupled: keys that move together, a dictionary like `ranges` for each set of them.
    points: a CSV file with a key in each column and a point in each row, instead of ranges and coupled.

    `attrs["units"]` has the units of keys and metrics. Raises UserError, with a sentence, where the sweep cannot begin.
    """
    if workers is not None and workers < 1:
        raise UserError(f"workers: expected a number from 1, got {workers}.")
    file = None if points is None else Path(points)
    varied = _Varied(ranges or {}, [] if coupled is None else coupled, file, method, samples, seed)
    varied.check()
    text = _text(Path(scenario).resolve(), varied, overrides or {})
    with tempfile.TemporaryDirectory(prefix="sextant-sweep-") as own:
        try:
            return _table(sweep_file.parse(CALL, text), Path(own if out is None else out), workers)
        except UserError as error:
            raise UserError(re.sub(rf"^{CALL}:\d+: ", f"{CALL}: ", str(error))) from None
