"""Runs the cases with Sextant and with motulator, several at a time, and keeps their figures."""

import json
import os
import subprocess
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from sextant_py.errors import UserError
from sextant_py.paths import ROOT
from sextant_py.sweep_point import clean_reason, read_summary
from sextant_py.sweep_reader import set_words

from studies.parallel import in_order

from . import course as courses
from .cases import CURVE_S, END_S, SHOWN, STEP_S, WINDOW_S, Case, Plant, motulator_case, sextant_settings, steady_state

QUANTITIES = {
    "torque_nm": "T",
    "current_a": "|i_s|",
    "flux_wb": "|ψ_s|",
    "stator_rad_s": "ω_s",
    "slip_rad_s": "ω_slip",
    "power_w": "P",
}
LIMIT_PERCENT = 0.5
TIME_LIMIT_S = 1800  # of one run [s]


@dataclass
class Record:
    """One case: the figures of both drives, and what the machine's equations say."""

    period_us: float
    speed_rad_s: float
    torque_nm: float
    equations: dict
    sextant: dict
    motulator: dict

    @property
    def point(self) -> tuple[float, float]:
        return self.speed_rad_s, self.torque_nm

    def difference(self, quantity: str, of: str = "sextant", to: str = "motulator") -> float:
        """[%]"""
        reference = getattr(self, to)[quantity]
        return 100 * (getattr(self, of)[quantity] - reference) / abs(reference)

    @property
    def name(self) -> str:
        return named(self)


@dataclass
class Results:
    version: str
    commit: str
    motulator_version: str
    plant: dict
    records: list[Record]
    curves: dict = field(default_factory=dict)  # by period: that of each drive at the point SHOWN

    @property
    def periods_us(self) -> list[float]:
        return list(dict.fromkeys(record.period_us for record in self.records))

    def at(self, period_us: float) -> list[Record]:
        return [record for record in self.records if record.period_us == period_us]

    def apart(self) -> list[tuple[Record, str]]:
        """Cases and quantities that differ by more than the limit."""
        return [(r, q) for r in self.records for q in QUANTITIES if abs(r.difference(q)) > LIMIT_PERCENT]


def rounded(figures: dict) -> dict:
    return {name: None if value is None else float(f"{value:.7g}") for name, value in figures.items()}


def figures(course: courses.Course, case: Case, plant: Plant, ripple_rms_nm: float) -> dict:
    window = course.within(WINDOW_S, END_S)
    return rounded(
        courses.steady(window, plant.machine["n_p"] * case.speed_rad_s)
        | {
            "ripple_rms_nm": ripple_rms_nm,
            "ripple_pp_nm": courses.peak_to_peak(window),
            "rise_ms": courses.rise(course, STEP_S, case.torque_nm),
            "overshoot_percent": courses.overshoot(course, STEP_S, case.torque_nm),
        }
    )


class Bench:
    """sextant-mil with a scenario, and the Python of the peers' environment."""

    def __init__(self, mil: Path, scenario: Path, python: Path, plant: Plant) -> None:
        self.mil, self.scenario, self.python, self.plant = mil, scenario, python, plant
        self.motulator_version = ""
        self.curves: dict = {}

    def run(self, cases: list[Case], jobs: int, step: Callable[[], None]) -> list[Record]:
        return in_order(self._run, cases, jobs, step)

    def _run(self, case: Case) -> Record:
        with tempfile.TemporaryDirectory(prefix="sextant-motulator-") as directory:
            ours, our_ripple = self._sextant(case, Path(directory))
            theirs, their_ripple = self._motulator(case, Path(directory))
        if (case.speed_rad_s, case.torque_nm) == SHOWN:
            drives = {"sextant": ours, "motulator": theirs}
            shown = {name: courses.curve(course.within(*CURVE_S), STEP_S) for name, course in drives.items()}
            self.curves[f"{case.period_us:g}"] = shown
        return Record(
            case.period_us,
            case.speed_rad_s,
            case.torque_nm,
            rounded(steady_state(self.plant, case)),
            figures(ours, case, self.plant, our_ripple),
            figures(theirs, case, self.plant, their_ripple),
        )

    def _sextant(self, case: Case, directory: Path) -> tuple[courses.Course, float]:
        command = [self.mil, self.scenario, *set_words(sextant_settings(case)), "--out", directory]
        said = self._run_program("sextant-mil", command, case)
        summary = read_summary(directory)
        if summary is None or summary["faults"]:
            raise UserError(f"sextant-mil, {named(case)}: {clean_reason(said) or 'a fault'}; run it alone to see why.")
        return courses.of_trace(directory / "trace.h5"), summary["metrics"]["torque_ripple_rms_nm"]

    def _motulator(self, case: Case, directory: Path) -> tuple[courses.Course, float]:
        told, found = directory / "case.json", directory / "points.npz"
        told.write_text(json.dumps(motulator_case(self.plant, case)), encoding="utf-8")
        module = "studies.bench.motulator_run"
        self._run_program("motulator", [self.python, "-W", "ignore", "-m", module, told, found], case)
        with np.load(found) as file:
            points = dict(file)
        self.motulator_version = str(points["version"])
        t, torque = points["t_s"], points["torque_nm"]
        window = (t >= WINDOW_S) & (t <= END_S)
        return courses.of_points(points, case.period_us * 1e-6), courses.ripple_rms(t[window], torque[window])

    def _run_program(self, name: str, command: list, case: Case) -> str:
        """What it wrote to its standard error."""
        environment = os.environ | {"PYTHONPATH": str(ROOT / "scripts"), "PYTHONDONTWRITEBYTECODE": "1"}
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=TIME_LIMIT_S, env=environment)
        except subprocess.TimeoutExpired:
            raise UserError(f"{name}, {named(case)}: no result within {TIME_LIMIT_S} s; try fewer --jobs.") from None
        if done.returncode:
            why = clean_reason(done.stderr, name) or f"exit status {done.returncode}"
            raise UserError(f"{name}, {named(case)}, failed: {why}")
        return done.stderr


def named(case: Case | Record) -> str:
    return f"{case.period_us:g} µs, {case.speed_rad_s:g} rad/s, {case.torque_nm:g} N·m"
