"""The points of the torque map: factors of the machine's parameters, and what surrounds the drive."""

import itertools
from collections.abc import Iterable
from dataclasses import dataclass

from sextant_py.sweep_file import Settings

from .drive import DEAD_TIME, DELAY, FACTORS, INDUCTANCE, Drive
from .scale import SENSORS

R_S, R_R, L_M = (0.5, 0.8, 1.0, 1.2, 1.5), (0.5, 1.0, 1.5), (0.7, 1.0, 1.3)
ESTIMATE = "control.machine_estimate."
# What the factors scale: the machine, which the controller believes nominal; or what it believes of a nominal machine.
DETUNES = ("machine", "estimate")


@dataclass(frozen=True)
class Conditions:
    """Everything but speed and torque."""

    r_s: float = 1.0
    r_r: float = 1.0
    l_m: float = 1.0
    detune: str = "machine"
    sensors: str = "ideal"
    delay: int = 0  # of actuation [periods]
    shaft: str = "imposed"  # speed, or "free"
    dead_time: float = 1.0  # that the drive is told of the inverter, by the one that its file says

    @property
    def key(self) -> str:
        around = f"{self.shaft}/{self.sensors}/{self.delay}/{self.dead_time:g}"
        return f"{around}/{self.detune}/{self.r_s:g},{self.r_r:g},{self.l_m:g}"

    @property
    def is_r_s_alone(self) -> bool:
        return (self.r_r, self.l_m, self.sensors) == (1, 1, "ideal")

    @property
    def label(self) -> str:
        names = {"r_s": "R_s", "r_r": "R_r", "l_m": "L_m"}
        parts = [f"${names[name]}$ ×{getattr(self, name):g}" for name in names if getattr(self, name) != 1]
        parts += ["believed"] if parts and self.detune == "estimate" else []
        parts += [f"dead time told ×{self.dead_time:g}"] if self.dead_time != 1 else []
        parts += ["sensors"] if self.sensors != "ideal" else []
        parts += ["delay"] if self.delay else []
        parts += ["free shaft"] if self.shaft == "free" else []
        return ", ".join(parts) or "exact parameters"


@dataclass(frozen=True)
class Point:
    conditions: Conditions
    speed: float  # mechanical [rad/s]
    torque: float  # commanded [N·m]

    @property
    def key(self) -> str:
        return f"{self.conditions.key}/{self.speed:g}/{self.torque:g}"


def axes(**around: object) -> list[Conditions]:
    """One factor at a time, the exact machine first."""
    one = [Conditions(**around)]
    one += [Conditions(r_s=f, **around) for f in R_S if f != 1]
    one += [Conditions(r_r=f, **around) for f in R_R if f != 1]
    return one + [Conditions(l_m=f, **around) for f in L_M if f != 1]


def corners(**around: object) -> list[Conditions]:
    ends = ((values[0], values[-1]) for values in (R_S, R_R, L_M))
    return [Conditions(*factors, **around) for factors in itertools.product(*ends)]


SENSORS_ALONE, DELAY_ALONE, FREE_ALONE = {"sensors": "real"}, {"delay": 1}, {"shaft": "free"}
ALL_AROUND = SENSORS_ALONE | DELAY_ALONE | FREE_ALONE


def default_sets() -> list[Conditions]:
    """Axes and corners, of the machine, of what is believed, and of the machine with all that surrounds it; the stator
    resistance with each of that alone."""
    sets = axes() + corners() + axes(detune="estimate")[1:] + corners(detune="estimate")
    sets += axes(**ALL_AROUND) + corners(**ALL_AROUND)
    for around in (SENSORS_ALONE, DELAY_ALONE, FREE_ALONE):
        sets += [one for one in axes(**around) if one.r_r == one.l_m == 1]
    return sets


def full_sets() -> list[Conditions]:
    grid = itertools.product(R_S, R_R, L_M, DETUNES, SENSORS, (0, 1), ("imposed", "free"))
    return [Conditions(*one) for one in grid if one[:3] != (1, 1, 1) or one[3] == "machine"]


def quick_sets() -> list[Conditions]:
    return [Conditions(), Conditions(r_s=0.5), Conditions(r_s=1.5), Conditions(**ALL_AROUND)]


def points(sets: Iterable[Conditions], speeds: Iterable[float], torques: Iterable[float]) -> list[Point]:
    return [Point(*one) for one in itertools.product(sets, speeds, torques)]


def machine_settings(drive: Drive, conditions: Conditions) -> Settings:
    """The machine, and what the drive believes: its file's estimate, by default the machine."""
    found: Settings = {}
    for factor, key in drive.factors.items():
        nominal, scale = drive.machine[key], getattr(conditions, factor)
        spellings = (FACTORS["l_m"], INDUCTANCE) if factor == "l_m" else (key,)
        told = (f"{ESTIMATE}{name}" for name in spellings if f"{ESTIMATE}{name}" in drive.base)
        estimate = next(told, f"{ESTIMATE}{key}")
        believed = drive.base.get(estimate, nominal)
        real, belief = (scale, 1.0) if conditions.detune == "machine" else (1.0, scale)
        found |= {f"machine.{key}": nominal * real, estimate: believed * belief}
    return found


def inverter_settings(drive: Drive, conditions: Conditions) -> Settings:
    """What the drive is told wrong of its inverter."""
    if conditions.dead_time == 1:
        return {}
    return {DEAD_TIME: round(drive.base[DEAD_TIME] * conditions.dead_time, 3)}


def load_settings(drive: Drive, point: Point) -> Settings:
    """The shaft: at the speed from the beginning; or free, brought there by the load, which then has the command."""
    if point.conditions.shaft == "imposed":
        return {"load.kind": "imposed_speed", "load.speed_rad_s.value": point.speed}
    scale = drive.scale
    push = -drive.machine["inertia_kg_m2"] * point.speed / (scale.step_s - scale.from_s)
    steps = [[0, 0], [scale.from_s, push], [scale.step_s, point.torque]]
    return {"load.kind": "torque", "load.torque_nm.shape": "steps", "load.torque_nm.points": steps}


def settings(drive: Drive, point: Point) -> Settings:
    """What the point adds to the drive's scenario."""
    scale = drive.scale
    return {
        "duration_s": scale.end_s,
        "metrics.window_from_s": scale.from_s if point.conditions.shaft == "imposed" else scale.step_s,
        "profile.torque_nm.shape": "steps",
        "profile.torque_nm.points": [[0, 0], [scale.step_s, point.torque]],
        **load_settings(drive, point),
        **machine_settings(drive, point.conditions),
        **inverter_settings(drive, point.conditions),
        **scale.sensors[point.conditions.sensors],
        DELAY: point.conditions.delay,
    }
