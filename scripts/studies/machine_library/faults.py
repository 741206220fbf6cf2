"""Faults of phase, current sensor and encoder on machines of the library, under every method: what each is called."""

from collections.abc import Callable, Iterable

from sextant_py.sweep_file import Settings

from studies.plant_faults import FAULTS, HARMLESS, MISSED, REFUSED, SPEED_CHANGE, PlantFault, leaving_speed, of_a_trip

from .points import STEP_S, Cell, Machine, Point
from .results import is_right
from .run import Lab

AT_S = 1.7  # of a fault that comes under way
WINDOW: Settings = {"duration_s": 2.7, "metrics.window_from_s": 2.3}
PERIODS_US = (50, 125)
MACHINES = ("marathon_quarter_hp", "motulator_2k2", "modelica_24k", "mathworks_215hp")
QUICK_MACHINES = ("motulator_2k2",)
# Shares of base speed and rated torque: standstill, small torque, full torque in reverse, weakened flux.
PLACES = ((0.0, 0.5), (0.5, 0.1), (-0.8, 1.0), (1.5, 0.5))
QUICK_PLACES = ((0.5, 0.5),)
INJECTED = tuple(fault for fault in FAULTS if fault.draw is None)  # no magnitude is drawn here
Case = tuple[PlantFault, Point]


def cases(machines: Iterable[str], methods: Iterable[str], is_quick: bool) -> list[Case]:
    known = set(machines)
    chosen = [m for m in (QUICK_MACHINES if is_quick else MACHINES) if m in known]
    periods, places = ((125,), QUICK_PLACES) if is_quick else (PERIODS_US, PLACES)
    return [
        (fault, Point(Cell(machine, period, method, "ideal"), *place))
        for fault in INJECTED
        for method in methods
        for machine in chosen
        for period in periods
        for place in places
    ]


def judge(record: dict, fault: PlantFault, point: Point, machine: Machine) -> dict:
    """What the run shows."""
    cell = point.cell
    found = {
        "fault": fault.name, "method": cell.method, "machine": cell.machine, "period_us": cell.period_us,
        "speed": point.speed, "torque": point.torque, "kind": HARMLESS, "seen": "", "late_ms": None,
    }  # fmt: skip
    if record["refusal"]:
        return found | {"kind": REFUSED, "seen": record["refusal"]}
    if record["faults"]:
        begin_s = AT_S if fault.leaves(point.speed) else fault.begin_s(AT_S)
        return found | of_a_trip(record["faults"][0], fault.names, begin_s, STEP_S)
    right, said = is_right(record, point, machine)
    return found if right else found | {"kind": MISSED, "seen": said}


def measure(lab: Lab, chosen: list[Case], jobs: int, step: Callable[[], None]) -> list[dict]:
    lab.configure((point for _, point in chosen), jobs)
    work = []
    for fault, point in chosen:
        base = lab.machines[point.cell.machine].base_speed
        settings = WINDOW | fault.settings(AT_S)
        if fault.leaves(point.speed):
            speed = point.speed * base
            settings |= leaving_speed(speed, speed + SPEED_CHANGE * base, AT_S, WINDOW["metrics.window_from_s"])
        work.append((point, settings))
    records = lab.run(work, jobs, step)
    return [
        judge(record, fault, point, lab.machines[point.cell.machine])
        for record, (fault, point) in zip(records, chosen, strict=True)
    ]
