"""Faults of plant and sensors that the campaigns inject, what the drive has to call each, and how a run is judged."""

import random
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass

from sextant_py.sweep_file import Settings

from .page import table

NAMED, OTHERWISE, HARMLESS, MISSED, REFUSED = "named", "by another name", "no effect", "missed", "refused"
KINDS = (NAMED, OTHERWISE, HARMLESS, MISSED, REFUSED)
SPEED_CHANGE = 0.5  # of the base speed, by which a shaft leaves its speed

Draw = Callable[[random.Random, Settings], Settings]


@dataclass(frozen=True)
class PlantFault:
    """A fault of plant or sensors, and the faults of the drive that name it rightly."""

    name: str
    kind: str
    names: tuple[str, ...]
    draw: Draw | None = None  # its magnitude, by the drive's configuration; None: it has none
    is_from_power_up: bool = False
    changes_speed: bool = False  # the shaft leaves its speed: else the fault shows nothing
    needs_speed: bool = False  # a shaft that is held at standstill shows nothing

    def leaves(self, speed: float) -> bool:
        """Whether the shaft has to leave that speed under way, so that there is something to see."""
        return self.changes_speed or (self.needs_speed and speed == 0)

    def begin_s(self, at_s: float) -> float:
        """When it begins, where one under way begins at at_s."""
        return 0.0 if self.is_from_power_up else at_s

    def settings(self, at_s: float) -> Settings:
        return {"plant.faults.kind": self.kind, "plant.faults.at_s": self.begin_s(at_s)}


def leaving_speed(speed: float, to: float, at_s: float, by_s: float) -> Settings:
    """A shaft that leaves its speed at at_s and has another one at by_s. [rad/s]"""
    points = [[0, speed], [at_s, speed], [by_s, to]]
    return {"load.speed_rad_s.shape": "linear", "load.speed_rad_s.points": points}


def of_a_trip(trip: list, names: tuple[str, ...], at_s: float, step_s: float) -> dict:
    """How a trip is called that follows a cause at at_s, and how late since it, or since torque was asked."""
    seen, tripped_s = trip
    early = tripped_s < at_s
    since = max(0.0, tripped_s - (at_s or step_s))
    return {
        "kind": NAMED if seen in names and not early else OTHERWISE,
        "seen": f"{seen} before" if early else seen,
        "late_ms": round(1e3 * since, 3),
    }


def injections_table(runs: list[dict], by: tuple[str, ...] = ("name",), with_latest: bool = True) -> str:
    """How the runs of each injection ended, by what tells the injections apart: its name first, then code."""
    kinds = [kind for kind in KINDS if kind != REFUSED or any(one["kind"] == REFUSED for one in runs)]
    groups: dict[tuple[str, ...], list[dict]] = {}
    for one in runs:
        groups.setdefault(tuple(one[key] for key in by), []).append(one)
    rows = []
    for (name, *more), own in groups.items():
        counts = Counter(one["kind"] for one in own)
        late = max((one["late_ms"] for one in own if one["late_ms"] is not None), default=None)
        latest = ["–" if late is None else f"{late:.4g}"] if with_latest else []
        seen = Counter(one["seen"] for one in own if one["kind"] in (NAMED, OTHERWISE))
        named = ", ".join(f"{fault} {count}" for fault, count in seen.most_common()) or "–"
        rows.append((name, *(f"`{one}`" for one in more), len(own), *(counts[kind] for kind in kinds), *latest, named))
    head = ("injection", *by[1:], "runs", *kinds, *(["latest [ms]"] if with_latest else []), "tripped as")
    return table(head, rows, left=(*range(len(by)), len(head) - 1))


def _drift(dice: random.Random, configuration: Settings) -> Settings:
    """From nothing to the over-current limit in half a second."""
    return {"plant.faults.drift_a_s": dice.choice((-1, 1)) * 2 * configuration["protection.over_current_a"]}


def _jump(dice: random.Random, configuration: Settings) -> Settings:
    limit = configuration["protection.speed_error_rad_s"]
    return {"plant.faults.jump_rad_s": dice.choice((-1, 1)) * dice.uniform(1.5, 4.0) * limit}


def _sag(dice: random.Random, configuration: Settings) -> Settings:
    limit = configuration["protection.dc_under_voltage_v"]
    return {"plant.faults.sag_v": dice.uniform(0.6, 0.95) * limit, "plant.faults.ramp_ms": dice.choice((0, 10, 50))}


SENSOR = ("CURRENT_SENSOR", "CURRENT_SUM")
FAULTS = (
    PlantFault("open phase", "open_phase", ("OPEN_PHASE",)),
    PlantFault("phase never connected", "open_phase", ("OPEN_PHASE",), is_from_power_up=True),
    PlantFault("current sensor stuck", "current_stuck", SENSOR),
    PlantFault("current sensor open", "current_zero", (*SENSOR, "OPEN_PHASE")),
    PlantFault("current sensor drifts", "current_drift", SENSOR, _drift),
    PlantFault("current sensors swapped", "phases_swapped", ("CURRENT_SENSOR",)),
    PlantFault("encoder stuck", "speed_frozen", ("SPEED_SENSOR",), changes_speed=True),
    PlantFault("encoder at zero", "speed_lost", ("SPEED_SENSOR",)),
    PlantFault("encoder jumps", "speed_jump", ("SPEED_SENSOR",), _jump),
    PlantFault("encoder reversed", "encoder_reversed", ("SPEED_SENSOR",), is_from_power_up=True),
    PlantFault("motor cables swapped", "cables_swapped", ("SPEED_SENSOR",), is_from_power_up=True, needs_speed=True),
    PlantFault("link under-voltage", "link_sag", ("DC_UNDER_VOLTAGE",), _sag),
)  # fmt: skip
