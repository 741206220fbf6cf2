"""The fault campaign of any drive, in sextant-mil: every fault of plant and sensors at several operating points, with
ideal and with real sensors or with those of the file, and driving without a fault."""

import math
import random
import tempfile
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

from sextant_py.control_methods import METHODS
from sextant_py.short_run import summary_of
from sextant_py.sweep_file import Settings

from studies.parallel import in_order, progress_of
from studies.plant_faults import FAULTS, HARMLESS, MISSED, REFUSED, SPEED_CHANGE, PlantFault, leaving_speed, of_a_trip
from studies.published import mean_and_due, published
from studies.torque_map import file as torque_map_file
from studies.torque_map.run import Lab
from studies.torque_map.scale import BASE_SPEED, SENSORS, SPEEDS

from . import false_trips

# Shares of base speed and torque limit.
PLACES = ((0.0, 0.1), (0.3, 0.4), (-0.6, -0.1), (0.7, 0.1), (1.5, 0.2))
AFTER_S = (0.3, 0.4)  # of the fault, from the torque step [s]
WATCHED_S = 0.9  # after the fault; an open phase at standstill waits for its current's zero crossing [s]
TOLERANCE = 0.05  # of the mean torque after a fault, as a share of the command, beside the floor of the scale
DRIVING_S = 30.0  # of a run without a fault [s]
STEADY = "no fault"  # the row of the same operating points without any
OWN = "own"  # the sensors of a file that sets their errors
SENSOR, SEED = "plant.sensors.", "plant.sensors.seed"
# With real sensors, where the file has no sensor of the shaft.
ENCODER: Settings = {
    f"{SENSOR}encoder.lines": 1024,
    f"{SENSOR}encoder.speed": "period",
    f"{SENSOR}encoder.window_periods": 20,
}


@dataclass
class Found:
    """What a campaign has shown: its runs, and driving without a fault."""

    runs: list[dict] = field(default_factory=list)
    hours: list[false_trips.Hours] = field(default_factory=list)


@dataclass(frozen=True)
class Case:
    """One run; fault: None is the same without any."""

    fault: PlantFault | None
    method: str
    seed: int
    place: int
    sensors: str

    @property
    def key(self) -> str:
        name = self.fault.name if self.fault else STEADY
        return f"{name}/{self.method}/{self.seed}/{self.place}/{self.sensors}"


def cases(methods: Iterable[str], seeds: int, sensors: Iterable[str] = tuple(SENSORS)) -> list[Case]:
    kinds = list(sensors)
    return [
        Case(fault, method, seed, place, kind)
        for method in methods
        for fault in (None, *FAULTS)
        for seed in range(1, seeds + 1)
        for place, (speed, _) in enumerate(PLACES)
        if speed or fault is None or not fault.needs_speed
        for kind in kinds
    ]


class Campaign:
    """The drive of a file."""

    def __init__(self, file: Path, mil: Path, directory: Path) -> None:
        self.drive = torque_map_file.load(file, mil, directory)
        self.scale = self.drive.scale
        self.lab = Lab(mil, self.drive, directory)
        # Errors of the sensors that the drive runs with: the last are the largest.
        has_own = any(key.startswith(SENSOR) and key != SEED for key in self.drive.base)
        self.sensors: dict[str, Settings] = {OWN: {}} if has_own else self.scale.sensors
        self.method = self.drive.configuration["control.controller"]
        # The map's speeds go beyond it, as those of the shipped drive do. [rad/s]
        self.base_speed = self.scale.speeds[-1] * BASE_SPEED / SPEEDS[-1]

    def place(self, case: Case) -> tuple[float, float]:
        """Speed [rad/s], and torque [N·m]."""
        speed, torque = PLACES[case.place]
        return speed * self.base_speed, torque * self.drive.configuration["command.torque_limit_nm"]

    def times(self, case: Case) -> tuple[float, float]:
        """Of the fault; and the end. [s]"""
        dice = random.Random(case.seed)
        at_s = self.scale.step_s + dice.uniform(*AFTER_S)
        return (case.fault.begin_s(at_s) if case.fault else at_s), at_s + WATCHED_S

    def settings(self, case: Case) -> Settings:
        (speed, torque), (at_s, end_s) = self.place(case), self.times(case)
        found: Settings = {
            "duration_s": end_s, "metrics.window_from_s": end_s - 0.3, "control.controller": case.method,
            "profile.torque_nm.shape": "steps", "profile.torque_nm.points": [[0, 0], [self.scale.step_s, torque]],
            "load.kind": "imposed_speed", "load.speed_rad_s.value": speed,
            SEED: case.seed, **self.sensors[case.sensors],
        }  # fmt: skip
        if case.fault is None:
            return found
        dice = random.Random(case.key)
        found |= case.fault.settings(at_s)
        found["plant.faults.phase"] = dice.choice("abc")
        if case.fault.changes_speed:
            slower = speed + math.copysign(SPEED_CHANGE * self.base_speed, -speed)
            found |= leaving_speed(speed, slower, at_s, end_s)
        return found | (case.fault.draw(dice, self.drive.configuration) if case.fault.draw else {})

    def run(self, case: Case) -> dict:
        record = self.lab.run_one(case.key, self.settings(case))
        found = {"name": case.fault.name if case.fault else STEADY, "method": case.method, "case": case.key}
        return found | {"seen": "", "late_ms": None} | self.judged(case, record)

    def judged(self, case: Case, record: dict) -> dict:
        if record["reason"]:
            return {"kind": REFUSED, "seen": record["reason"]}
        if record["faults"]:
            names = case.fault.names if case.fault else ()
            return of_a_trip(record["faults"][0], names, self.times(case)[0], self.scale.step_s)
        speed, torque = self.place(case)
        mean, due = mean_and_due(record, speed, torque)
        off = abs(mean - due) > max(self.scale.torque_floor, TOLERANCE * abs(torque))
        if off or published(record, speed, torque) is None:
            return {"kind": MISSED, "seen": f"{mean:.4g} N·m for {due:.4g} N·m"}
        return {"kind": HARMLESS}

    def run_all(self, plan: list[Case], jobs: int, name: str) -> list[dict]:
        return in_order(self.run, plan, jobs, progress_of(len(plan), name, "fault_campaign"))

    @property
    def encoder(self) -> Settings:
        """Of the drives without a fault, beside what the file says."""
        base = self.drive.base
        others = (f"{SENSOR}resolver.pole_pairs", f"{SENSOR}sin_cos.periods")
        has_own = any(map(base.get, others)) or any(key.startswith(f"{SENSOR}encoder.") for key in base)
        return {} if has_own else ENCODER

    def drive_on(self, method: str, seed: int) -> tuple[false_trips.Drive, dict]:
        """A run of random torque steps without a fault, with real sensors or those of the file."""
        one = false_trips.Drive(f"random torque steps, {method}", seed, DRIVING_S)
        with tempfile.TemporaryDirectory(prefix="sextant-trips-") as name:
            largest = 0.87 * self.drive.configuration["command.torque_limit_nm"]
            settings = {
                "duration_s": DRIVING_S, "metrics.window_from_s": 0, "control.controller": method,
                SEED: seed, **[*self.sensors.values()][-1], **self.encoder,
                **false_trips.random_steps(one, Path(name), largest, 0.86 * self.base_speed, self.scale.from_s),
            }  # fmt: skip
            return one, summary_of(self.lab.mil, self.lab.scenario, settings)

    def hours(self, methods: Iterable[str], hours: float, jobs: int) -> list[false_trips.Hours]:
        count = max(1, -int(-3600 * hours // DRIVING_S))
        plan = [(method, seed) for method in methods for seed in range(1, count + 1)]
        found: dict[str, false_trips.Hours] = {}
        for one, summary in in_order(lambda pair: self.drive_on(*pair), plan, jobs):
            false_trips.add(found, one, summary)
        return [*found.values()]


def chosen_methods(wanted: str | None, own: str) -> list[str]:
    return [own] if wanted is None else list(METHODS) if wanted == "all" else wanted.split(",")


def wrong(found: list[dict]) -> list[dict]:
    """Missed faults, refused runs, and trips without a fault."""
    bad = (MISSED, REFUSED)
    return [one for one in found if one["kind"] in bad or (one["name"] == STEADY and one["kind"] != HARMLESS)]
