"""Every number of docs/paper: its value, the command that gives it and how closely it must come back."""

import json
import math
from dataclasses import asdict, dataclass
from pathlib import Path

from sextant_py.errors import UserError

from studies import json_file

from .lab import Run


@dataclass(frozen=True)
class Number:
    value: float  # NaN: there is none, as the response of a torque that never arrives
    unit: str
    tolerance: float | None  # in the number's unit; None: depends on the machine, is not compared
    meaning: str
    command: str


class Numbers:
    """Numbers by name."""

    def __init__(self, entries: dict[str, Number] | None = None) -> None:
        self.entries = entries or {}

    def __getitem__(self, name: str) -> float:
        return self.entries[name].value

    def __contains__(self, name: str) -> bool:
        return name in self.entries

    def add(self, name: str, value: float, unit: str, tolerance: float | None, meaning: str, command: str) -> float:
        """tolerance: a share of the value where it is below zero: -0.01 is 1 %."""
        if name in self.entries:
            raise ValueError(f"{name} is there twice")
        if tolerance is not None and tolerance < 0:
            tolerance = -tolerance * abs(value) if math.isfinite(value) else 0.0
        self.entries[name] = Number(float(value), unit, tolerance, meaning, command)
        return value

    def at(self, name: str, run: Run | None = None, command: str = "") -> "Scope":
        """Where the numbers of one run, or of one command, are added."""
        return Scope(self, name, run, command or (run.command if run else ""))

    def under(self, prefix: str) -> dict[str, float]:
        """Values whose name begins with the prefix, by the rest of it, in the order in which they were added."""
        return {name[len(prefix) :]: n.value for name, n in self.entries.items() if name.startswith(prefix)}

    def save(self, file: Path) -> None:
        content = {name: asdict(number) for name, number in self.entries.items()}
        for entry in content.values():
            entry["value"] = float(f"{entry['value']:.6g}") if math.isfinite(entry["value"]) else None
            entry["tolerance"] = (
                entry["tolerance"] if entry["tolerance"] is None else float(f"{entry['tolerance']:.3g}")
            )
        json_file.write(file, content)


@dataclass(frozen=True)
class Scope:
    """Numbers of one run or command, whose names begin alike."""

    numbers: Numbers
    name: str
    run: Run | None
    command: str

    def add(self, key: str, value: float, unit: str, tolerance: float | None, meaning: str) -> float:
        name = "/".join(part for part in (self.name, key) if part)
        return self.numbers.add(name, value, unit, tolerance, meaning, self.command)

    def metric(self, key: str, metric: str, unit: str, tolerance: float | None, meaning: str) -> float:
        """A metric of the run. tolerance: as of Numbers.add."""
        return self.add(key, self.run[metric], unit, tolerance, meaning)


def load(file: Path) -> Numbers:
    try:
        content = json.loads(file.read_text(encoding="utf-8"))
        entries = {}
        for name, entry in content.items():
            value = math.nan if entry["value"] is None else float(entry["value"])
            entries[name] = Number(**(entry | {"value": value}))
    except FileNotFoundError:
        raise UserError(f"{file} does not exist; scripts/paper_report writes it.") from None
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        raise UserError(f"{file} is not what scripts/paper_report writes: {error}.") from None
    return Numbers(entries)


def differences(committed: Numbers, measured: Numbers) -> list[str]:
    """A sentence for every measured number that is not the committed one."""
    found = []
    for name, now in measured.entries.items():
        then = committed.entries.get(name)
        if then is None:
            found.append(f"{name}: measured, but not among the committed numbers")
            continue
        if then.tolerance is None or (math.isnan(then.value) and math.isnan(now.value)):
            continue
        if not abs(now.value - then.value) <= then.tolerance:
            found.append(
                f"{name}: {then.value:g} {then.unit} is committed, {now.value:.6g} is measured, "
                f"tolerance {then.tolerance:g}; {then.command}"
            )
    return found
