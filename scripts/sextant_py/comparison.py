"""Two runs metric by metric: what may differ, and by how much it does."""

import json
import math
from dataclasses import dataclass, field, replace
from pathlib import Path

from .errors import UserError
from .recording.formats import SUFFIXES
from .toml_file import parsed

DEFAULT = "1%"
IGNORE = "ignore"
# By the clock of the machine, so never the same; and a remainder of rounding, of which a verdict allows 1e-4.
# A fault latches in a control period, which is far shorter than a millisecond.
FAULT_TIME = "fault_s"
OF_FAULT = "fault "  # before the name of a fault, of the row of its time
BY_METRIC = {"wall_s": IGNORE, "realtime_factor": IGNORE, "energy_unaccounted": "1e-4", FAULT_TIME: "1e-3"}
# A value counts as this share of the largest one of its unit at least: of a remainder near zero, such as the bias of a
# torque, 1 % would be below what any change of a run leaves.
NEAR_ZERO = 0.01
SAME, OUT, IGNORED = "within", "OUT", "ignored"


@dataclass(frozen=True)
class Tolerance:
    """Of a metric's difference: a share of the first run's value, or of a hundredth of its scale where that is more;
    or an amount in the metric's unit."""

    text: str
    amount: float = math.inf
    relative: bool = False

    @classmethod
    def parse(cls, text: str, where: str) -> "Tolerance":
        """`1%`, `0.05` or `ignore`; `where` is for the refusal."""
        if text == IGNORE:
            return cls(text)
        try:
            amount = float(text.removesuffix("%"))
        except ValueError:
            amount = math.nan
        if not 0 <= amount < math.inf:
            raise UserError(f'{where}: expected a tolerance such as 1%, 0.05 or {IGNORE}, got "{text}".')
        return cls(text, amount / 100 if text.endswith("%") else amount, text.endswith("%"))

    def allows(self, first: float, second: float, scale: float = 0.0) -> bool:
        """scale: the largest magnitude of the quantity. [unit of the metric]"""
        return abs(second - first) <= self.limit(max(abs(first), NEAR_ZERO * scale))

    def limit(self, whole: float) -> float:
        """The largest difference; `whole` is what a share is of. [unit of the metric]"""
        return self.amount * whole if self.relative else self.amount


@dataclass
class Tolerances:
    default: Tolerance = field(default_factory=lambda: Tolerance.parse(DEFAULT, "default"))
    metrics: dict[str, Tolerance] = field(
        default_factory=lambda: {name: Tolerance.parse(text, name) for name, text in BY_METRIC.items()}
    )

    given: set[str] = field(default_factory=set)  # names that a file or an argument has set

    def of(self, metric: str) -> Tolerance:
        return self.metrics.get(metric, self.default)

    def read(self, file: Path) -> None:
        """`default` and the table `[metrics]` of a TOML file; what it does not name stays."""
        tree = parsed(file)
        if unknown := sorted(set(tree) - {"default", "metrics"}):
            raise UserError(f"{file}: {unknown[0]}: unknown key; known here are default, metrics.")
        if not isinstance(tree.get("metrics", {}), dict):
            raise UserError(f"{file}: metrics: expected a table of metrics with their tolerances.")
        if "default" in tree:
            self.default = Tolerance.parse(str(tree["default"]), f"{file}: default")
        for name, text in tree.get("metrics", {}).items():
            self.metrics[name] = Tolerance.parse(str(text), f"{file}: metrics.{name}")
            self.given.add(name)

    def add(self, setting: str) -> None:
        """NAME=TOLERANCE; the name `default` is for the metrics that have none of their own."""
        name, sign, text = setting.partition("=")
        if not sign or not name:
            raise UserError(f'--tolerance: expected NAME=TOLERANCE, got "{setting}".')
        tolerance = Tolerance.parse(text, f"--tolerance {name}")
        if name == "default":
            self.default = tolerance
        else:
            self.metrics[name] = tolerance
            self.given.add(name)


@dataclass(frozen=True)
class Row:
    """A metric of a scenario in both runs; None: a run has no value."""

    scenario: str
    metric: str
    first: float | str | None
    second: float | str | None
    tolerance: str
    result: str
    reason: str = ""  # why it is out

    @property
    def difference(self) -> float | None:
        numbers = isinstance(self.first, int | float) and isinstance(self.second, int | float)
        return self.second - self.first if numbers else None

    @property
    def relative(self) -> float | None:
        """The difference as a share of the first value."""
        return self.difference / abs(self.first) if self.difference is not None and self.first else None


def read_summary(file: Path) -> dict:
    if file.suffix.lower() in SUFFIXES:
        raise UserError(f"{file} is a recording, not a summary: --align TRIGGER compares recordings over time.")
    try:
        summary = json.loads(file.read_text(encoding="utf-8"))
        if isinstance(summary["metrics"], dict) and isinstance(summary["scenario"], str) and summary["verdict"]:
            return summary
    except OSError as error:
        raise UserError(f"{file} cannot be read: {error.strerror}.") from None
    except (ValueError, KeyError, TypeError):
        pass
    raise UserError(f"{file} is no summary of a run; sextant-mil writes one to summary.json.")


def runs_of(path: Path) -> dict[str, dict]:
    """Summaries by scenario: of a file, of a result directory, or of the result directories in one."""
    if not path.exists():
        raise UserError(f"{path} does not exist.")
    files = [path] if path.is_file() else [path / "summary.json"]
    if not files[0].is_file():
        files = sorted(path.glob("*/summary.json"))
    if not files:
        raise UserError(f"{path} holds no result of sextant-mil: neither summary.json nor */summary.json.")
    found: dict[str, dict] = {}
    for file in files:
        summary = read_summary(file)
        if summary["scenario"] in found:
            raise UserError(f'{path} holds two results of the scenario "{summary["scenario"]}".')
        found[summary["scenario"]] = summary
    return found


def unit_of(metric: str) -> str:
    """As the end of its name says it; a name without a unit is one of its own."""
    return "rad_s" if metric.endswith("_rad_s") else metric.rpartition("_")[2]


def scales(metrics: dict[str, float | None]) -> dict[str, float]:
    """The largest magnitude of each unit."""
    found: dict[str, float] = {}
    for name, value in metrics.items():
        if value is not None and math.isfinite(value):
            found[unit_of(name)] = max(found.get(unit_of(name), 0.0), abs(value))
    return found


def fault_rows(scenario: str, first: dict, second: dict, tolerance: Tolerance) -> list[Row]:
    """The latched faults in their order and, where these are the same, the time of each."""
    if "faults" not in first or "faults" not in second:
        return []  # of an earlier version
    lists = [run["faults"] for run in (first, second)]
    names = [", ".join(entry["fault"] for entry in faults) or "none" for faults in lists]
    reason = "" if names[0] == names[1] else f"{names[1]} instead of {names[0]}"
    rows = [Row(scenario, "faults", *names, "", OUT if reason else SAME, reason)]
    if not reason:
        for one, other in zip(*lists, strict=True):
            times = ({FAULT_TIME: entry["t_s"]} for entry in (one, other))
            rows.append(replace(_metric(scenario, FAULT_TIME, *times, tolerance), metric=f"{OF_FAULT}{one['fault']}"))
    return rows


def _metric(scenario: str, name: str, first: dict, second: dict, tolerance: Tolerance, scale: float = 0.0) -> Row:
    one, other = first.get(name), second.get(name)
    reason = ""
    if name not in first or name not in second:
        reason = f"only the {'second' if name not in first else 'first'} run has this metric"
    elif (one is None) != (other is None):
        reason = f"only the {'second' if one is None else 'first'} run has a value"
    elif one is not None and not tolerance.allows(one, other, scale):
        reason = f"{other:.6g} instead of {one:.6g}: tolerance {tolerance.text}"
    ignored = tolerance.text == IGNORE
    result = IGNORED if ignored else OUT if reason else SAME
    return Row(scenario, name, one, other, tolerance.text, result, "" if ignored else reason)


def shift_s(rows: list[Row], tolerances: Tolerances) -> float | None:
    """By how much later every fault of B comes where some are out of tolerance; None: not by one time. [s]"""
    times = [row for row in rows if row.metric.startswith(OF_FAULT)]
    differences = [row.difference for row in times]
    if not any(row.result == OUT for row in times):
        return None
    middle, spread = (max(differences) + min(differences)) / 2, max(differences) - min(differences)
    limit = 2 * tolerances.of(FAULT_TIME).limit(abs(middle))
    return middle if spread <= limit < 2 * abs(middle) else None


def _run(scenario: str, first: dict, second: dict, tolerances: Tolerances) -> list[Row]:
    one, other = first["verdict"], second["verdict"]
    reason = "" if one == other else f"{other} instead of {one}"
    rows = [Row(scenario, "verdict", one, other, "", OUT if reason else SAME, reason)]
    rows += fault_rows(scenario, first, second, tolerances.of(FAULT_TIME))
    metrics = first["metrics"], second["metrics"]
    whole = scales(metrics[0])
    names = dict.fromkeys([*metrics[0], *metrics[1]])
    return rows + [_metric(scenario, n, *metrics, tolerances.of(n), whole.get(unit_of(n), 0.0)) for n in names]


def compare(first: dict[str, dict], second: dict[str, dict], tolerances: Tolerances) -> list[Row]:
    """A row for each metric of each scenario. One run is compared with one run even where the scenarios differ."""
    known = {metric for runs in (first, second) for run in runs.values() for metric in run["metrics"]}
    for name in tolerances.metrics:
        if name not in known and name not in BY_METRIC:
            raise UserError(f'no run has a metric "{name}", for which a tolerance is given; see the names in A.')
    if len(first) == len(second) == 1:
        (name, one), (other_name, other) = *first.items(), *second.items()
        return _run(name if name == other_name else f"{name} / {other_name}", one, other, tolerances)
    rows: list[Row] = []
    for name in dict.fromkeys([*first, *second]):
        if name in first and name in second:
            rows += _run(name, first[name], second[name], tolerances)
        else:
            reason = f"only the {'first' if name in first else 'second'} directory has this scenario"
            verdicts = [runs[name]["verdict"] if name in runs else None for runs in (first, second)]
            rows.append(Row(name, "verdict", *verdicts, "", OUT, reason))
    return rows
