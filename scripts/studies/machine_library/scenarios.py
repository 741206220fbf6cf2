"""Scenarios on every machine: full torque and its reversal, starts through standstill, and a sag of the link."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import cycle

from sextant_py.sweep_file import Settings

from .points import STEP_S, Cell, Machine, Point, command_of
from .results import DERATED, RIGHT, TRIPPED, WRONG, ended
from .run import Lab

REVERSALS, STARTS, SAGS = "reversals", "starts", "sags"
NAMES = (REVERSALS, STARTS, SAGS)
PERIODS_US = (50, 125)
SILENT_MS = 10.0  # for so long torque may depart from what the drive publishes
DERATED_SHARE = 0.97  # of the command, below which the published torque counts as derating
FULL = float("inf")  # torque up to the limit that the drive has by default
QUICK_CASES = 24

# Shares of the base speed, each in both directions.
REVERSAL_SPEEDS = tuple(sign * speed for speed in (0.05, 0.25, 0.5, 0.75, 0.95, 1.1, 1.4, 2.0) for sign in (1, -1))
REVERSED_S = (STEP_S + 0.3, STEP_S + 0.6)
REVERSALS_END_S = STEP_S + 0.9

RAMPS = (0.3, 1.0, 3.0)  # base speeds a second
INSTANTS_S = (0.03, 0.1, 0.2, 0.4)  # of standstill; torque is asked from power-up
START_TORQUES = (1.0, -0.25, 0.25, -1.0)  # shares of the rated torque, in turn
STARTS_END_S = 1.5

SAG_SPEEDS = (0.3, -0.7, 1.0, -1.3, 1.8)  # shares of the base speed
SAG_SHARE = 0.7  # of the link, to which it falls at once
SAG_AT_S = STEP_S + 0.4
SAGS_END_S = STEP_S + 0.9


@dataclass(frozen=True)
class Case:
    """One run of a scenario; ramp and instant are those of a start."""

    scenario: str
    point: Point  # the speed is that at the beginning
    instant_s: float = 0.0

    @property
    def title(self) -> str:
        if self.scenario == REVERSALS:
            return f"{self.point.speed:g}"
        if self.scenario == SAGS:
            return f"{self.point.speed:g}, torque {self.point.torque:g}"
        return f"{self.point.speed:g} to {-self.point.speed:g}, through zero at {self.instant_s:g} s"

    def settings(self, machine: Machine, configuration: Settings) -> Settings:
        """What the run sets beside its point."""
        torque = command_of(self.point, machine, configuration)
        if self.scenario == SAGS:
            return {
                "duration_s": SAGS_END_S, "metrics.window_from_s": STEP_S, "plant.faults.kind": "link_sag",
                "plant.faults.at_s": SAG_AT_S, "plant.faults.sag_v": SAG_SHARE * machine.u_dc,
            }  # fmt: skip
        if self.scenario == REVERSALS:
            first, second = REVERSED_S
            return {
                "duration_s": REVERSALS_END_S, "metrics.window_from_s": STEP_S,
                "profile.torque_nm.points": [[0, 0], [STEP_S, torque], [first, -torque], [second, torque]],
            }  # fmt: skip
        speed = self.point.speed * machine.base_speed
        return {
            "duration_s": STARTS_END_S, "metrics.window_from_s": 0.0,
            "profile.torque_nm.points": [[0, torque]],
            "load.speed_rad_s.shape": "linear",
            "load.speed_rad_s.points": [[0, speed], [2 * self.instant_s, -speed], [STARTS_END_S, -speed]],
        }  # fmt: skip


def _reversals(cell: Cell) -> list[Case]:
    return [Case(REVERSALS, Point(cell, speed, FULL)) for speed in REVERSAL_SPEEDS]


def _starts(cell: Cell) -> list[Case]:
    torques, signs = cycle(START_TORQUES), cycle((1, -1, -1, 1, -1))
    return [
        Case(STARTS, Point(cell, next(signs) * ramp * instant, next(torques)), instant)
        for ramp in RAMPS
        for instant in INSTANTS_S
    ]


def _sags(cell: Cell) -> list[Case]:
    return [Case(SAGS, Point(cell, speed, torque)) for speed in SAG_SPEEDS for torque in (1.0, -1.0)]


OF_CELL = {REVERSALS: _reversals, STARTS: _starts, SAGS: _sags}


def cases(name: str, machines: Iterable[str], methods: Iterable[str], periods_us: Iterable[int]) -> list[Case]:
    """Of a scenario, over all machines, methods and periods."""
    machines, methods, of_cell = tuple(machines), tuple(methods), OF_CELL[name]
    cells = [Cell(machine, p, method, "ideal") for machine in machines for p in periods_us for method in methods]
    return [case for cell in cells for case in of_cell(cell)]


def spread(every: list, count: int) -> list:
    """So many at most, evenly from all."""
    count = min(count, len(every))
    return [every[n * len(every) // count] for n in range(count)]


def judge(record: dict, case: Case) -> dict:
    """What the run shows."""
    cell = case.point.cell
    found = {
        "scenario": case.scenario, "machine": cell.machine, "method": cell.method, "period_us": cell.period_us,
        "what": case.title, "kind": RIGHT, "why": "", "silent_ms": None,
    }  # fmt: skip
    if end := ended(record):
        return found | end
    found["silent_ms"] = silent = record["torque_silent_ms"]
    if record["verdict"] == "no_torque" or silent is None:
        return found | {"kind": WRONG, "why": "no torque, no fault"}
    if silent > SILENT_MS:
        return found | {"kind": WRONG, "why": f"{silent:.3g} ms another torque than is published"}
    published = min(record["torque_motoring_nm"], record["torque_regenerating_nm"])
    return found | ({"kind": DERATED} if published < DERATED_SHARE * abs(record["command_nm"]) else {})


def measure(lab: Lab, chosen: list[Case], jobs: int, step: Callable[[], None]) -> list[dict]:
    lab.configure((case.point for case in chosen), jobs)
    work: list[tuple[Point, Settings]] = []
    for case in chosen:
        configuration = lab.configuration(case.point)
        is_refused = isinstance(configuration, str)
        machine = lab.machines[case.point.cell.machine]
        work.append((case.point, {} if is_refused else case.settings(machine, configuration)))
    return [judge(*pair) for pair in zip(lab.run(work, jobs, step), chosen, strict=True)]


def not_right(rows: Iterable[dict]) -> list[dict]:
    return [row for row in rows if row["kind"] in (TRIPPED, WRONG)]
