"""Faults of phase, current sensor and encoder on machines of the library, under every method: what each is called."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from .machine_library_points import STEP_S, Cell, Machine, Point
from .machine_library_results import is_right
from .machine_library_run import Lab
from .sweep_file import Settings

AT_S = 1.7  # of a fault that comes under way
WINDOW: Settings = {"duration_s": 2.7, "metrics.window_from_s": 2.3}
PERIODS_US = (50, 125)
MACHINES = ("marathon_quarter_hp", "motulator_2k2", "modelica_24k", "mathworks_215hp")
QUICK_MACHINES = ("motulator_2k2",)
# Shares of base speed and rated torque: standstill, small torque, full torque in reverse, weakened flux.
PLACES = ((0.0, 0.5), (0.5, 0.1), (-0.8, 1.0), (1.5, 0.5))
QUICK_PLACES = ((0.5, 0.5),)


@dataclass(frozen=True)
class Fault:
    """What happens, and the faults of the drive that name it rightly."""

    name: str
    names: tuple[str, ...]
    set: Callable[[float, float], Settings]  # by the speed and the base speed [rad/s]
    at_s: float = AT_S


def _kind(kind: str, at_s: float = AT_S) -> Settings:
    return {"plant.faults.kind": kind, "plant.faults.at_s": at_s}


def _rising(speed: float, base: float) -> Settings:
    """A shaft that leaves its speed after the fault: an encoder stuck at a constant speed reads the truth."""
    points = [[0, speed], [AT_S, speed], [WINDOW["metrics.window_from_s"], speed + 0.5 * base]]
    return {"load.speed_rad_s.shape": "linear", "load.speed_rad_s.points": points}


FAULTS = (
    Fault("open phase", ("OPEN_PHASE",), lambda *_: _kind("open_phase")),
    Fault("phase never connected", ("OPEN_PHASE",), lambda *_: _kind("open_phase", 0), 0),
    Fault("current sensor stuck", ("CURRENT_SENSOR", "CURRENT_SUM"), lambda *_: _kind("current_stuck")),
    Fault("current sensors swapped", ("CURRENT_SENSOR",), lambda *_: _kind("phases_swapped")),
    Fault("encoder stuck", ("SPEED_SENSOR",), lambda speed, base: _kind("speed_frozen") | _rising(speed, base)),
    Fault("encoder at zero", ("SPEED_SENSOR",), lambda *_: _kind("speed_lost")),
    Fault("encoder reversed", ("SPEED_SENSOR",), lambda *_: _kind("encoder_reversed", 0), 0),
    Fault("motor cables swapped", ("SPEED_SENSOR",), lambda *_: _kind("cables_swapped", 0), 0),
)  # fmt: skip
NAMED, OTHERWISE, HARMLESS, MISSED, REFUSED = "named", "by another name", "no effect", "missed", "refused"
KINDS = (NAMED, OTHERWISE, HARMLESS, MISSED, REFUSED)
Case = tuple[Fault, Point]


def cases(machines: Iterable[str], methods: Iterable[str], is_quick: bool) -> list[Case]:
    known = set(machines)
    chosen = [m for m in (QUICK_MACHINES if is_quick else MACHINES) if m in known]
    periods, places = ((125,), QUICK_PLACES) if is_quick else (PERIODS_US, PLACES)
    return [
        (fault, Point(Cell(machine, period, method, "ideal"), *place))
        for fault in FAULTS
        for method in methods
        for machine in chosen
        for period in periods
        for place in places
    ]


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


def judge(record: dict, fault: Fault, point: Point, machine: Machine) -> dict:
    """What the run shows."""
    cell = point.cell
    found = {
        "fault": fault.name, "method": cell.method, "machine": cell.machine, "period_us": cell.period_us,
        "speed": point.speed, "torque": point.torque, "kind": HARMLESS, "seen": "", "late_ms": None,
    }  # fmt: skip
    if record["refusal"]:
        return found | {"kind": REFUSED, "seen": record["refusal"]}
    if record["faults"]:
        return found | of_a_trip(record["faults"][0], fault.names, fault.at_s, STEP_S)
    right, said = is_right(record, point, machine)
    return found if right else found | {"kind": MISSED, "seen": said}


def measure(lab: Lab, chosen: list[Case], jobs: int, step: Callable[[], None]) -> list[dict]:
    lab.configure((point for _, point in chosen), jobs)
    work = []
    for fault, point in chosen:
        base = lab.machines[point.cell.machine].base_speed
        work.append((point, WINDOW | fault.set(point.speed * base, base)))
    records = lab.run(work, jobs, step)
    return [
        judge(record, fault, point, lab.machines[point.cell.machine])
        for record, (fault, point) in zip(records, chosen, strict=True)
    ]
