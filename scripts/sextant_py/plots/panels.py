"""Which signals a picture has, and which of them share a panel: those of one unit and one kind."""

import re
from dataclasses import dataclass, field

import numpy as np

from ..errors import UserError
from .points import bands
from .series import STATISTIC, Series, SeriesFile

QUANTITIES = {
    "N·m": "Torque",
    "Wb": "Flux linkage",
    "rad/s": "Speed",
    "A": "Current",
    "V": "Voltage",
    "W": "Power",
    "J": "Energy",
    "rad": "Angle",
    "°C": "Temperature",
}
PHASE = re.compile(r".+_[abc]")
AXIS = re.compile(r".+_(alpha|beta|d|q)")
ROLE = re.compile(r".+_(reference|requested)")
TIME_STAMP = "ns"
MOST_LEVELS = 8  # of a discrete signal that is drawn unasked: states and sectors
COUNTER = re.compile(r"(.*_)?(periods|counter|sequence|dropped)")


@dataclass
class Line:
    """A quantity of a file: its value, or its mean with the band of minimum and maximum."""

    name: str
    series: Series
    low: Series | None = None
    high: Series | None = None
    file: str = ""  # its label, where there are several

    @property
    def label(self) -> str:
        return f"{self.name}, {self.file}" if self.file else self.name

    @property
    def role(self) -> str:
        """Of a reference or a request, which other lines follow."""
        found = ROLE.fullmatch(self.series.stem)
        return found[1] if found else ""

    def points(self, most: int) -> tuple[np.ndarray, np.ndarray, np.ndarray | None, np.ndarray | None]:
        """Time, value and the band about it, where there is one: of the signals, or of blocks of samples."""
        value = self.series.values
        has_band = self.low is not None and self.high is not None
        low, high = (self.low.values, self.high.values) if has_band else (value, value)
        time_s, mean, low, high = bands(self.series.time_s, value, low, high, most)
        return (time_s, mean, low, high) if has_band or len(value) > most else (time_s, mean, None, None)


@dataclass
class Panel:
    """Lines over one time axis."""

    heading: str
    unit: str
    lines: list[Line] = field(default_factory=list)

    @property
    def is_discrete(self) -> bool:
        return bool(self.lines) and all(line.series.is_discrete for line in self.lines)


def kind_of(series: Series) -> str:
    """What is drawn apart from other signals of the same unit."""
    name = series.stem.rpartition("/")[2]
    if PHASE.fullmatch(name):
        return "phases"
    if AXIS.fullmatch(name):
        return "components"
    return "states" if series.is_discrete else ""


def heading(unit: str, kind: str) -> str:
    is_pure = unit in ("", "1")
    quantity = "pure numbers" if is_pure and kind != "states" else QUANTITIES.get(unit, "")
    what = ", ".join(part for part in (quantity, kind) if part)
    what = what[:1].upper() + what[1:]
    return what if is_pure else f"{what} [{unit}]"


def first_of_lines(panels: list[Panel]) -> int:
    """The place of the panel that has the texts of marks: bands of values have texts of their own."""
    return next((place for place, panel in enumerate(panels) if not panel.is_discrete), 0)


def merged(found: list[Series], label: str) -> list[Line]:
    """A line for each quantity; minimum, mean and maximum of one become a line with its band."""
    lines: list[Line] = []
    quantities: dict[str, dict[str, Series]] = {}
    for series in found:
        statistic = STATISTIC.fullmatch(series.name)
        quantities.setdefault(series.quantity, {})[statistic[2] if statistic else ""] = series
    for quantity, parts in quantities.items():
        if {"min", "max"} <= parts.keys():
            value = parts.get("mean") or parts.get("")
            band = parts["min"], parts["max"]
            if value is not None:
                lines.append(Line(quantity, value, *band, file=label))
                continue
        lines += [Line(series.name, series, file=label) for series in parts.values()]
    return lines


def changes(series: Series) -> bool:
    """A signal of more than one value."""
    return bool(np.any(series.values != series.values[0]))


def _is_shown_unasked(series: Series) -> bool:
    if series.unit == TIME_STAMP or COUNTER.fullmatch(series.name.rpartition("/")[2]):
        return False
    if series.is_discrete:
        return 1 < len(np.unique(series.values)) <= MOST_LEVELS
    return bool(series.unit) and bool(np.isfinite(series.values).any())


def choose(file: SeriesFile) -> list[Series]:
    """What is drawn where no signal is named: the drive's own, and others where it has none of their unit and kind."""
    shown = [series for name, series in file.series.items() if name in file.main and _is_shown_unasked(series)]
    own = {(series.unit, kind_of(series)) for series in shown if "/" not in series.name}
    return [series for series in shown if "/" not in series.name or (series.unit, kind_of(series)) not in own]


def arrange(files: list[SeriesFile], wanted: list[str]) -> list[Panel]:
    """The panels of the wanted signals, or of those that are chosen. A signal is drawn of each file that has it."""
    panels: dict[tuple[str, str], Panel] = {}
    missing: dict[str, UserError] = {}
    found_names: set[str] = set()
    chosen = [] if wanted else list(dict.fromkeys(series.name for file in files for series in choose(file)))
    for file in files:
        found = [file.series[name] for name in chosen if name in file.series]
        for name in wanted:
            try:
                found += file.find(name)
                found_names.add(name)
            except UserError as error:
                missing.setdefault(name, error)
        found = list({series.name: series for series in found}.values())
        for line in merged(found, file.label if len(files) > 1 else ""):
            key = line.series.unit, kind_of(line.series)
            panels.setdefault(key, Panel(heading(*key), key[0])).lines.append(line)
    for name, error in missing.items():
        if name not in found_names:
            raise error
    if not panels:
        raise UserError(f"{files[0].path} has no signal to draw; --list shows its signals.")
    order = [*QUANTITIES, ""]
    rank = {unit: place for place, unit in enumerate(order)}
    if wanted:
        return list(panels.values())
    return [panels[key] for key in sorted(panels, key=lambda key: (rank.get(key[0], len(order)), key[1]))]
