"""Sweeps of a scenario's configuration from Python, by the machinery of scripts/sweep."""

import os
import re
import tempfile
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


def _axis(key: str, axis: Any, method: str) -> str:
    """A range or the choices of a key, as a sweep file has them."""
    if isinstance(axis, list):
        return toml_value(axis)
    names = ("from", "to", "count") if method == "grid" else ("from", "to")
    if not isinstance(axis, tuple) or len(axis) not in (len(names), len(names) + 1):
        parts = "(low, high, count)" if method == "grid" else "(low, high)"
        raise UserError(f'ranges: {key}: expected {parts}, with "log" at the end or not, or a list, got {axis!r}.')
    words = [f"{name} = {toml_value(value)}" for name, value in zip((*names, "scale"), axis, strict=False)]
    return "{ " + ", ".join(words) + " }"


def _text(scenario: Path, ranges: dict[str, Any], overrides: dict[str, Any], head: list[str], table: str) -> str:
    """The sweep file."""
    method = "grid" if table == "grid" else "random"
    lines = [f"scenario = {toml_value(str(scenario))}", "[set]"]
    lines += [f"{toml_value(key)} = {toml_value(value)}" for key, value in overrides.items()]
    lines += [*head, f"[{table}]"]
    return "\n".join(lines + [f"{toml_value(key)} = {_axis(key, axis, method)}" for key, axis in ranges.items()]) + "\n"


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
    ranges: dict[str, tuple | list],
    samples: int = 64,
    method: str = "sobol",
    seed: int = 1,
    workers: int | None = None,
    overrides: dict[str, Any] | None = None,
    out: str | Path | None = None,
) -> pandas.DataFrame:
    """Runs a scenario at many points of its configuration; a row a point, with its metrics, status and reason.

    ranges: configuration keys to (low, high), to (low, high, "log"), or to a list of choices; for a grid to
    (low, high, count), (low, high, count, "log") or a list.
    samples, seed: of a sample; a grid has neither.
    method: "sobol" (scrambled; samples: a power of two), "latin_hypercube", "random" or "grid".
    workers: runs at a time; None: one for each processor.
    overrides: configuration keys that are the same in every point.
    out: a directory for finished points, with which the same call continues an interrupted sweep; None: none.

    `attrs["units"]` has the units of keys and metrics. Raises UserError, with a sentence, where the sweep cannot begin.
    """
    if method != "grid" and method not in KINDS:
        raise UserError(f'method: expected grid, {", ".join(KINDS)}, got "{method}".')
    if workers is not None and workers < 1:
        raise UserError(f"workers: expected a number from 1, got {workers}.")
    if not ranges:
        raise UserError("ranges: expected at least one key that varies.")
    head = [] if method == "grid" else ["[random]"]
    if head:
        head += [f"method = {toml_value(method)}", f"samples = {toml_value(samples)}", f"seed = {toml_value(seed)}"]
    table = "random.ranges" if head else "grid"
    text = _text(Path(scenario).resolve(), ranges, overrides or {}, head, table)
    with tempfile.TemporaryDirectory(prefix="sextant-sweep-") as own:
        try:
            return _table(sweep_file.parse(CALL, text), Path(own if out is None else out), workers)
        except UserError as error:
            raise UserError(re.sub(rf"^{CALL}:\d+: ", f"{CALL}: ", str(error))) from None
