"""The file of a sweep: which keys of a scenario vary, over which values, and what is drawn of it."""

import itertools
import math
import re
import tomllib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from . import sweep_points, sweep_sample
from .errors import UserError
from .sweep_axes import COUPLED, AxesReader, Axis, keys_of
from .sweep_reader import MAX_POINTS, Settings, SweepReader, line_of, refusal, shown, toml_value

__all__ = ["Plot", "Settings", "Sweep", "line_of", "load", "parse", "shown", "toml_value"]


@dataclass
class Plot:
    """What is drawn: each metric against one or two keys."""

    metrics: list[str] = field(default_factory=list)
    keys: list[str] = field(default_factory=list)


@dataclass
class Sweep:
    """A sweep as its file says it. Every point is one run of the scenario."""

    file: Path
    name: str
    description: str
    scenario: Path
    time_limit_s: float | None  # of one point [s]
    fixed: Settings  # the same in every point
    varied: list[str]
    points: list[Settings]  # values of the varied keys
    plot: Plot
    text: str  # of the file, for messages
    axes: list[Axis] = field(default_factory=list)  # of a grid or a sample
    seed: int | None = None  # of a sample
    method: str = "random"  # by which a sample is drawn
    points_file: Path | None = None  # that lists the points
    points_heading: int = 0  # line of its heading

    @property
    def kind(self) -> str:
        if self.seed is not None:
            return sweep_sample.KINDS[self.method]
        return "list" if self.points_file else "grid"

    @property
    def log_keys(self) -> set[str]:
        return set().union(*(axis.log_keys for axis in self.axes))

    def groups(self) -> list[list[str]]:
        """The varied keys; those that move together are one group."""
        return [list(axis.columns) for axis in self.axes] or [[key] for key in self.varied]


def _points_of_grid(read: SweepReader, axes: list[Axis]) -> list[Settings]:
    """Every combination; the first axis changes slowest."""
    if math.prod(map(len, axes)) > MAX_POINTS:
        raise read.refuse("grid", f"more than {MAX_POINTS} points.")
    rows = itertools.product(*(axis.rows() for axis in axes))
    return [{key: value for settings in row for key, value in settings.items()} for row in rows]


@dataclass
class _Sample:
    """How the points of a sample are drawn."""

    method: str
    samples: int
    seed: int


def _read_sample(read: SweepReader, table: Settings) -> _Sample:
    read.known(table, "random.", {"method", "samples", "seed", "ranges"})
    method = table.get("method", "random")
    if method not in sweep_sample.KINDS:
        raise read.refuse("random.method", f"expected {', '.join(sweep_sample.KINDS)}, got {shown(method)}.")
    samples = read.count(table.get("samples"), "random.samples", "how many points", 1)
    if refusal := sweep_sample.refusal(method, samples):
        raise read.refuse("random.samples", refusal)
    if "seed" not in table:
        raise read.refuse("random", '"seed" is missing; the same seed gives the same points.')
    return _Sample(method, samples, read.count(table["seed"], "random.seed", "a seed", 0))


def _points_of_sample(sample: _Sample, axes: list[Axis]) -> list[Settings]:
    rows = sweep_sample.shares(sample.method, sample.samples, len(axes), sample.seed)
    return [
        {key: value for axis, share in zip(axes, row, strict=True) for key, value in axis.at(share).items()}
        for row in rows
    ]


def _axes(read: SweepReader, tree: Settings, where: str, table: Settings) -> list[Axis]:
    """The axes of a grid or a sample: those of single keys, then the coupled ones."""
    reader = AxesReader(read, where == "grid")
    axes = list(reader.single(table, where))
    for axis in reader.coupled(tree):
        for key in axis.columns:
            if key in keys_of(axes):
                raise read.refuse(f"{COUPLED}.{key}", "this key varies elsewhere in this sweep as well.")
        axes.append(axis)
    if not axes:
        raise read.refuse(where, "expected at least one key that varies.")
    return axes


def _listed(read: SweepReader, tree: Settings) -> dict[str, Any]:
    """Keys and points of a file that lists them."""
    if COUPLED in tree:
        raise read.refuse(COUPLED, "a list of points has every key that varies: leave [[coupled]] out.")
    file = read.file.parent / read.text_at(tree, "points")
    found = sweep_points.load(file)
    return {"varied": found.keys, "points": found.points, "points_file": file, "points_heading": found.line}


def _varied(read: SweepReader, tree: Settings) -> dict[str, Any]:
    """What the sweep says of its points."""
    kinds = {"grid": "[grid]", "random": "[random]", "points": "points"}
    given = [text for key, text in kinds.items() if key in tree] or ["[[coupled]]"] * (COUPLED in tree)
    if len(given) != 1:
        got = " and ".join(given) or "none of them"
        raise UserError(f"{read.file}: expected one of [grid], [random], points or [[coupled]] alone, got {got}.")
    if "points" in tree:
        return _listed(read, tree)
    if "random" not in tree:
        axes = _axes(read, tree, "grid", read.table(tree, "grid"))
        return {"varied": keys_of(axes), "points": _points_of_grid(read, axes), "axes": axes}
    table = read.table(tree, "random")
    sample = _read_sample(read, table)
    axes = _axes(read, tree, "random.ranges", read.table(table, "random.ranges"))
    points = _points_of_sample(sample, axes)
    return {"varied": keys_of(axes), "points": points, "axes": axes, "seed": sample.seed, "method": sample.method}


def _fixed(read: SweepReader, tree: Settings, varied: list[str]) -> Settings:
    fixed = {}
    for path, value in read.leaves(read.table(tree, "set"), "set").items():
        name = path.removeprefix("set.")
        if isinstance(value, dict):
            raise read.refuse(path, "expected one value, got a range.")
        if name in varied:
            raise read.refuse(path, "this key varies elsewhere in this sweep as well.")
        fixed[name] = read.setting(value, path)
    return fixed


def _plot(read: SweepReader, tree: Settings, varied: list[str]) -> Plot:
    table = read.table(tree, "plot")
    read.known(table, "plot.", {"metrics", "keys"})
    plot = Plot(read.names(table.get("metrics", []), "plot.metrics"), read.names(table.get("keys", []), "plot.keys"))
    if len(plot.keys) > 2:
        raise read.refuse("plot.keys", f"expected one or two keys, got {len(plot.keys)}.")
    for key in plot.keys:
        if key not in varied:
            raise read.refuse("plot.keys", f'"{key}" does not vary in this sweep; {", ".join(varied)} do.')
    return plot


def parse(file: Path, text: str) -> Sweep:
    read = SweepReader(file, text)
    try:
        tree = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise UserError(f"{file}: not valid TOML: {error}.") from None
    own = {"name", "description", "scenario", "time_limit_s", "set", "grid", "random", COUPLED, "points", "plot"}
    read.known(tree, "", own)
    found = _varied(read, tree)
    limit = tree.get("time_limit_s")
    if limit is not None and read.number(limit, "time_limit_s", "a number above 0") <= 0:
        raise read.refuse("time_limit_s", f"expected a number above 0, got {limit}.")
    scenario = (file.parent / read.text_at(tree, "scenario")).resolve()
    if not scenario.is_file():
        raise read.refuse("scenario", f"the scenario file {scenario} does not exist.")
    name = read.text_at(tree, "name", file.stem)
    if not re.fullmatch(r"\w[\w.-]*", name):
        raise read.refuse("name", f'expected letters, digits, "_", "-" and ".", got "{name}".')
    return Sweep(
        file=file,
        name=name,
        description=read.text_at(tree, "description", name),
        scenario=scenario,
        time_limit_s=limit,
        fixed=_fixed(read, tree, found["varied"]),
        plot=_plot(read, tree, found["varied"]),
        text=text,
        **found,
    )


def load(file: Path) -> Sweep:
    try:
        text = file.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise UserError(f"{file} does not exist.") from None
    except UnicodeDecodeError:
        raise UserError(f"{file} is not UTF-8 text.") from None
    except OSError as error:
        raise UserError(f"{file} cannot be read: {error.strerror}.") from None
    return parse(file, text)


def _table_of(sweep: Sweep, key: str) -> str:
    """The table of the file that sets or varies a key of the scenario."""
    if key in sweep.fixed:
        return "set"
    if any(len(group) > 1 and key in group for group in sweep.groups()):
        return COUPLED
    return "grid" if sweep.seed is None else "random.ranges"


def refuse_key(sweep: Sweep, key: str, message: str) -> UserError:
    """About a key of the scenario that the sweep sets or varies."""
    if sweep.points_file and key not in sweep.fixed:
        return UserError(f"{sweep.points_file}:{sweep.points_heading}: {key}: {message}")
    return refusal(sweep.file, sweep.text, f"{_table_of(sweep, key)}.{key}", message, key)


def refuse_plot(sweep: Sweep, message: str) -> UserError:
    return refusal(sweep.file, sweep.text, "plot.metrics", message)
