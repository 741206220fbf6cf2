"""The file of a sweep: which keys of a scenario vary, over which values, and what is drawn of it."""

import itertools
import json
import math
import re
import tomllib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from . import sweep_sample
from .errors import UserError

RANGE_KEYS = {"from", "to", "count", "scale"}
SCALES = ("linear", "log")
MAX_POINTS = 1_000_000
_TABLE = re.compile(r"^\s*\[([^\[\]]+)\]\s*(?:#.*)?$")
_KEY = re.compile(r"""^\s*((?:"[^"]*"|'[^']*'|[\w-]+)(?:\s*\.\s*(?:"[^"]*"|'[^']*'|[\w-]+))*)\s*=""")

Settings = dict[str, Any]


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


def toml_value(value: Any) -> str:
    """A value as TOML writes it, on one line."""
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(toml_value, value)) + "]"
    return repr(value)


def shown(value: Any) -> str:
    """A value as a sentence shows it."""
    if isinstance(value, dict) or value is None:
        return "nothing" if value is None else "a table"
    return f'"{value}"' if isinstance(value, str) else toml_value(value)


def _plain(key: str) -> str:
    return re.sub(r"""["'\s]""", "", key)


def line_of(text: str, key: str) -> int | None:
    """The line that sets a dotted key, or a table in which it lies; tomllib does not tell."""
    table, nearest = "", None
    for number, line in enumerate(text.splitlines(), 1):
        if heading := _TABLE.match(line):
            table = found = _plain(heading[1])
        elif entry := _KEY.match(line):
            found = f"{table}.{_plain(entry[1])}" if table else _plain(entry[1])
        else:
            continue
        if found == key:
            return number
        if key.startswith(found + "."):
            nearest = number
    return nearest


def refusal(file: Path, text: str, key: str, message: str, name: str | None = None) -> UserError:
    """A sentence about a key of the file, with its line; name: the key as people know it."""
    line = line_of(text, key)
    return UserError(f"{file}:{f'{line}:' if line else ''} {name or key}: {message}")


class _Reader:
    """Looks values up and refuses them with file, line and key."""

    def __init__(self, file: Path, text: str) -> None:
        self.file, self.text = file, text

    def refuse(self, key: str, message: str) -> UserError:
        return refusal(self.file, self.text, key, message)

    def known(self, table: Settings, prefix: str, names: set[str]) -> None:
        for name in table:
            if name not in names:
                raise self.refuse(f"{prefix}{name}", f"unknown key; known here are {', '.join(sorted(names))}.")

    def table(self, tree: Settings, key: str) -> Settings:
        value = tree.get(key.rpartition(".")[2], {})
        if not isinstance(value, dict):
            raise self.refuse(key, f"expected a table, got {shown(value)}.")
        return value

    def text_at(self, tree: Settings, key: str, default: str | None = None) -> str:
        value = tree.get(key, default)
        if value is None:
            raise UserError(f"{self.file}: {key}: this key is missing; it is a text.")
        if not isinstance(value, str) or not value.strip():
            raise self.refuse(key, f"expected a text, got {shown(value)}.")
        return value

    def number(self, value: Any, key: str, what: str) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            raise self.refuse(key, f"expected {what}, got {shown(value)}.")
        return value

    def count(self, value: Any, key: str, what: str, smallest: int) -> int:
        if isinstance(value, bool) or not isinstance(value, int) or not smallest <= value <= MAX_POINTS:
            expected = f"expected {what}, a whole number from {smallest} to {MAX_POINTS}"
            raise self.refuse(key, f"{expected}, got {shown(value)}.")
        return value

    def names(self, value: Any, key: str) -> list[str]:
        if not isinstance(value, list) or not all(isinstance(name, str) for name in value):
            raise self.refuse(key, f"expected a list of names, got {shown(value)}.")
        if len(set(value)) < len(value):
            raise self.refuse(key, "a name is there twice.")
        return value

    def setting(self, value: Any, key: str) -> Any:
        """A value that sextant-mil can be given."""
        if isinstance(value, list):
            return [self.setting(item, key) for item in value]
        if isinstance(value, bool | str):
            return value
        return self.number(value, key, "a finite number, a text, true or false, or a list of them")

    def leaves(self, table: Settings, prefix: str) -> dict[str, Any]:
        """Dotted keys, written with or without quotes, to what each is given."""
        found: dict[str, Any] = {}
        for name, value in table.items():
            key = f"{prefix}.{name}"
            inside = isinstance(value, dict) and not RANGE_KEYS & value.keys()
            for path, leaf in (self.leaves(value, key) if inside else {key: value}).items():
                if path in found:
                    raise self.refuse(path, "this key is there twice, with quotes and without.")
                found[path] = leaf
        return found

    def choices(self, value: list, key: str) -> list[Any]:
        if not value:
            raise self.refuse(key, "expected at least one value, got an empty list.")
        values = [self.setting(item, key) for item in value]
        if len({toml_value(item) for item in values}) < len(values):
            raise self.refuse(key, "a value is there twice.")
        return values

    def span(self, spec: Settings, key: str) -> tuple[float, float, bool]:
        """from, to and whether the scale is logarithmic."""
        scale = spec.get("scale", "linear")
        if scale not in SCALES:
            raise self.refuse(key, f'scale: expected "linear" or "log", got {shown(scale)}.')
        ends = []
        for end in ("from", "to"):
            if end not in spec:
                raise self.refuse(key, f'"{end}" is missing.')
            ends.append(self.number(spec[end], key, f'a finite number for "{end}"'))
        if not ends[0] < ends[1]:
            raise self.refuse(key, f"expected from < to, got {ends[0]} and {ends[1]}.")
        if scale == "log" and ends[0] <= 0:
            raise self.refuse(key, f'expected "from" above 0 on a log scale, got {ends[0]}.')
        return ends[0], ends[1], scale == "log"


def _between(low: float, high: float, log: bool, share: float) -> float:
    """The ends are exact at shares 0 and 1."""
    if share in (0.0, 1.0):
        return float(high if share else low)
    if log:
        return math.exp(math.log(low) + share * (math.log(high) - math.log(low)))
    return low + share * (high - low)


def _axes(read: _Reader, table: Settings, where: str, keys: set[str]) -> dict[str, list | tuple]:
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


def _grid(read: _Reader, table: Settings) -> tuple[list[str], list[Settings], set[str]]:
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


def _sample(read: _Reader, table: Settings) -> tuple[list[str], list[Settings], set[str], int, str]:
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


def _fixed(read: _Reader, tree: Settings, varied: list[str], where: str) -> Settings:
    fixed = {}
    for path, value in read.leaves(read.table(tree, "set"), "set").items():
        name = path.removeprefix("set.")
        if isinstance(value, dict):
            raise read.refuse(path, "expected one value, got a range.")
        if name in varied:
            raise read.refuse(path, f"this key varies in [{where}] as well.")
        fixed[name] = read.setting(value, path)
    return fixed


def _plot(read: _Reader, tree: Settings, varied: list[str]) -> Plot:
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
    read = _Reader(file, text)
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
