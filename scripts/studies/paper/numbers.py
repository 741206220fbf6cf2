"""Every number of docs/paper: its value, the command that gives it and how closely it must come back."""

import math
from dataclasses import dataclass, replace
from pathlib import Path

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
        entries = self.entries.items()
        content = {k: replace(n, value=_rounded(n.value, 6), tolerance=_rounded(n.tolerance, 3)) for k, n in entries}
        json_file.write(file, content)

    @staticmethod
    def load(file: Path) -> "Numbers":
        found = json_file.read(file, dict[str, Number], "paper_report")
        return Numbers({k: n if n.value is not None else replace(n, value=math.nan) for k, n in found.items()})


def _rounded(value: float | None, digits: int) -> float | None:
    return float(f"{value:.{digits}g}") if value is not None and math.isfinite(value) else None


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
