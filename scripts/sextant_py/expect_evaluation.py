"""A recording evaluated by what a scenario expects: limits that hold, that do not, and that it leaves open."""

from dataclasses import dataclass
from pathlib import Path

from . import alignment
from .aligned_comparison import faults_of_result, trace_of
from .expect_bounds import Bounds, absence, bounds
from .expect_rows import rows_of
from .expect_scenario import Limit, Scenario, Window
from .recorded_faults import FAULT
from .signal_file import SignalFile

# Verdicts and exit statuses of sextant-mil (sextant/run/verdict.hpp).
STATUS = {"pass": 0, "nothing_expected": 0, "fail": 1, "tripped": 3}
EXPECTATION_MISSING = 9


@dataclass(frozen=True)
class LimitResult:
    limit: Limit
    bounds: Bounds
    holds: bool | None  # None: the recording leaves it open
    absence: str  # why the recording has nothing of the metric; else empty


@dataclass(frozen=True)
class Evaluation:
    scenario: Scenario
    limits: tuple[LimitResult, ...]
    faults: tuple[tuple[str, float], ...]  # name and time [s]
    fault_holds: bool | None  # the expected fault, or that there is none

    @property
    def verdict(self) -> str:
        """A fault that is not the expected one trips; what is left open does not hold."""
        if self.faults and self.fault_holds is False:
            return "tripped"
        if not self.scenario.expects_something:
            return "nothing_expected" if self.fault_holds else "fail"
        return "pass" if self.fault_holds and all(result.holds for result in self.limits) else "fail"

    def status(self, is_required: bool) -> int:
        if self.verdict == "nothing_expected" and is_required:
            return EXPECTATION_MISSING
        return STATUS[self.verdict]


def _contains(window: Window, t_s: float, unsure_s: float) -> bool | None:
    """Whether an instant lies within; one before zero counts as zero. None: it may."""
    end = float("inf") if window.to_s is None else window.to_s
    least, most = max(0.0, t_s - unsure_s), max(0.0, t_s + unsure_s)
    if window.from_s <= least and most <= end:
        return True
    return None if most >= window.from_s and least <= end else False


def _fault_holds(scenario: Scenario, faults: list[tuple[str, float]], unsure_s: float) -> bool | None:
    if not faults or scenario.fault is None:
        return not faults and scenario.fault is None
    name, t_s = faults[0]
    if name not in (scenario.fault, FAULT):
        return False
    within = _contains(scenario.fault_window, t_s, unsure_s)
    return None if within and name == FAULT else within  # without its name it may be another


def evaluate(scenario: Scenario, path: Path, trigger: str | None, at_s: float | None) -> Evaluation:
    """trigger: of scripts/scope, at which the scenario is at at_s; None: it began with the recording. [s]"""
    place = trace_of(path)
    file = SignalFile(place)
    zero_s, unsure_s = 0.0, 0.0
    if trigger is not None:
        instant_s, unsure_s = alignment.instant(place, file, trigger)
        zero_s = instant_s - (at_s if at_s is not None else scenario.step_s or 0.0)
    rows = rows_of(file, zero_s)
    listed, late_s = faults_of_result(path, file, zero_s)
    faults = [(fault["fault"], fault["t_s"]) for fault in listed]
    results = []
    for limit in scenario.limits:
        found = bounds(limit.metric, rows, limit.window, scenario.step_s, unsure_s, scenario.duration_s)
        results.append(LimitResult(limit, found, found.holds(limit.low, limit.high), absence(limit.metric, rows)))
    holds = _fault_holds(scenario, faults, unsure_s + late_s)
    return Evaluation(scenario, tuple(results), tuple(faults), holds)
