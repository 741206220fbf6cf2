"""The file of a sweep: which keys of a scenario vary, over which values, and what is drawn of it."""

import itertools
import math
import re
import tomllib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from . import sweep_sample
from .errors import UserError
from .sweep_reader import MAX_POINTS, RANGE_KEYS, Settings, SweepReader, line_of, refusal, shown, toml_value

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
    log_keys: set[str]
    seed: int | None  # of a sample
    plot: Plot
    text: str  # of the file, for messages
    method: str = "random"  # by which a sample is drawn

    @property
    def kind(self) -> str:
        return "grid" if self.seed is None else sweep_sample.KINDS[self.method]


def _between(low: float, high: float, log: bool, share: float) -> float:
    """The ends are exact at shares 0 and 1."""
    if share in (0.0, 1.0):
        return float(high if share else low)
    if log:
        return math.exp(math.log(low) + share * (math.log(high) - math.log(low)))
    return low + share * (high - low)


def _axes(read: SweepReader, table: Settings, where: str, keys: set[str]) -> dict[str, list | tuple]:
    """Of each key its choices; or from, to, whether the scale is logarithmic, and the count where there is one."""
    found: dict[str, list | tuple] = {}
    for path, spec in read.leaves(table, where).items():
        name = path.removeprefix(f"{where}.")
        if isinstance(spec, dict):
            read.known(spec, f"{path}.", keys)
            found[name] = read.span(spec, path)
            if "count" in keys:
                found[name] += (read.count(spec.get("count"), path, '"count"', 2),)
        elif isinstance(spec, list):
            found[name] = read.choices(spec, path)
        else:
            known = ", ".join(key for key in ("from", "to", "count", "scale") if key in keys)
            raise read.refuse(path, f"expected a list of values or {{ {known} }}, got {shown(spec)}.")
    return found


def _log_keys(axes: dict[str, list | tuple]) -> set[str]:
    return {name for name, axis in axes.items() if isinstance(axis, tuple) and axis[2]}


def _grid(read: SweepReader, table: Settings) -> tuple[list[str], list[Settings], set[str]]:
    """Every combination; the first key changes slowest."""
    axes = _axes(read, table, "grid", RANGE_KEYS)
    values = {
        name: axis if isinstance(axis, list) else [_between(*axis[:3], k / (axis[3] - 1)) for k in range(axis[3])]
        for name, axis in axes.items()
    }
    if math.prod(map(len, values.values())) > MAX_POINTS:
        raise read.refuse("grid", f"more than {MAX_POINTS} points.")
    points = [dict(zip(values, one, strict=True)) for one in itertools.product(*values.values())]
    return list(values), points, _log_keys(axes)


def _sample(read: SweepReader, table: Settings) -> tuple[list[str], list[Settings], set[str], int, str]:
    """The points of a sample, with its seed and its method."""
    read.known(table, "random.", {"method", "samples", "seed", "ranges"})
    method = table.get("method", "random")
    if method not in sweep_sample.KINDS:
        raise read.refuse("random.method", f"expected {', '.join(sweep_sample.KINDS)}, got {shown(method)}.")
    samples = read.count(table.get("samples"), "random.samples", "how many points", 1)
    if refusal := sweep_sample.refusal(method, samples):
        raise read.refuse("random.samples", refusal)
    if "seed" not in table:
        raise read.refuse("random", '"seed" is missing; the same seed gives the same points.')
    seed = read.count(table["seed"], "random.seed", "a seed", 0)
    draws = _axes(read, read.table(table, "random.ranges"), "random.ranges", RANGE_KEYS - {"count"})

    def drawn(draw: list | tuple, share: float) -> Any:
        return draw[int(share * len(draw))] if isinstance(draw, list) else _between(*draw, share)

    rows = sweep_sample.shares(method, samples, len(draws), seed) if draws else ()
    points = [
        {name: drawn(draw, share) for (name, draw), share in zip(draws.items(), row, strict=True)} for row in rows
    ]
    return list(draws), points, _log_keys(draws), seed, method


def _fixed(read: SweepReader, tree: Settings, varied: list[str], where: str) -> Settings:
    fixed = {}
    for path, value in read.leaves(read.table(tree, "set"), "set").items():
        name = path.removeprefix("set.")
        if isinstance(value, dict):
            raise read.refuse(path, "expected one value, got a range.")
        if name in varied:
            raise read.refuse(path, f"this key varies in [{where}] as well.")
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
    read.known(tree, "", {"name", "description", "scenario", "time_limit_s", "set", "grid", "random", "plot"})
    if ("grid" in tree) == ("random" in tree):
        raise UserError(f"{file}: expected either [grid] or [random], got {'both' if 'grid' in tree else 'neither'}.")
    where = "grid" if "grid" in tree else "random"
    table = read.table(tree, where)
    varied, points, log_keys, *sample = (_grid if where == "grid" else _sample)(read, table)
    if not varied:
        raise read.refuse("grid" if where == "grid" else "random.ranges", "expected at least one key that varies.")
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
        fixed=_fixed(read, tree, varied, where),
        varied=varied,
        points=points,
        log_keys=log_keys,
        seed=sample[0] if sample else None,
        plot=_plot(read, tree, varied),
        text=text,
        method=sample[1] if sample else "random",
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


def refuse_key(sweep: Sweep, key: str, message: str) -> UserError:
    """About a key of the scenario that the sweep sets or varies."""
    table = "set" if key in sweep.fixed else "grid" if sweep.seed is None else "random.ranges"
    return refusal(sweep.file, sweep.text, f"{table}.{key}", message, key)


def refuse_plot(sweep: Sweep, message: str) -> UserError:
    return refusal(sweep.file, sweep.text, "plot.metrics", message)
