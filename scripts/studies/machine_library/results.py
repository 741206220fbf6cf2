"""What the records of the study over the library of machines mean."""

from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace

from studies.published import mean_and_due, published
from studies.torque_map.capability import largest_torque, limits_of
from studies.torque_map.drive import CURRENT_LIMIT

from .points import Machine, Point

TOLERANCE = 0.03  # of the mean torque, as a share of the rated torque
NEEDLESS = 0.9  # share of what the circuit allows, below which derating has no need
RIGHT, DERATED, REFUSED, TRIPPED, WRONG = "right", "derated", "refused", "tripped", "wrong"
OUTCOMES = (RIGHT, DERATED, REFUSED, TRIPPED, WRONG)


@dataclass
class Outcome:
    """Of one point; the texts of all are the page's evidence."""

    machine: str
    period_us: int
    method: str
    sensors: str
    speed: float  # share of the base speed
    torque: float  # share of the rated torque
    kind: str
    why: str = ""  # the sentence, the fault, or what was wrong
    is_needless: bool = False  # derated below what machine, link and current limit allow

    @property
    def is_right(self) -> bool:
        """Whether a user has the torque, or a reason why not before the start or on display."""
        return self.kind in (RIGHT, DERATED, REFUSED)


def is_right(record: dict, point: Point, machine: Machine) -> tuple[bool, str]:
    """Whether the mean torque is that of the command, within what the drive publishes; and both."""
    if record["torque_motoring_nm"] is None:
        return False, "the gates are off: no torque, no fault"
    mean, due = mean_and_due(record, point.speed, record["command_nm"])
    return abs(mean - due) <= TOLERANCE * machine.rated_torque, f"{mean:.4g} N·m for {due:.4g} N·m"


def allowed(configuration: dict, command: float, point: Point, machine: Machine) -> float:
    """By machine, link and current limit, up to the command. [N·m]"""
    limits = limits_of(configuration, CURRENT_LIMIT)
    sign = 1 if point.torque * point.speed >= 0 else -1
    most = largest_torque(limits, abs(point.speed) * machine.base_speed, sign)
    return min(most, abs(command))


def ended(record: dict) -> dict[str, str]:
    """Kind and reason of a run that was refused or tripped; empty for any other."""
    if record["refusal"]:
        return {"kind": REFUSED, "why": record["refusal"]}
    if record["faults"]:
        fault, at_s = record["faults"][0]
        return {"kind": TRIPPED, "why": f"{fault} at {at_s:.3f} s"}
    return {}


def outcome(record: dict, point: Point, machine: Machine, configuration: dict | str) -> Outcome:
    cell = point.cell
    found = Outcome(cell.machine, cell.period_us, cell.method, cell.sensors, point.speed, point.torque, WRONG)
    if end := ended(record):
        return replace(found, **end)
    right, said = is_right(record, point, machine)
    if not right:
        found.why = said
        return found
    command = record["command_nm"]
    available = published(record, point.speed, command) or 0.0
    found.kind = RIGHT
    if abs(command) > available + TOLERANCE * machine.rated_torque:
        found.kind, found.why = DERATED, f"{available:.4g} N·m of {abs(command):.4g} N·m"
        found.is_needless = isinstance(configuration, dict) and available < NEEDLESS * allowed(
            configuration, command, point, machine
        )
    return found


@dataclass
class Results:
    version: str
    commit: str
    seed: int
    command: str
    machines: list[dict]  # id, name, and what the table shows
    outcomes: list[Outcome]
    faults: list[dict] = field(default_factory=list)
    scenarios: list[dict] = field(default_factory=list)  # reversals and starts

    @property
    def not_right(self) -> list[Outcome]:
        return [one for one in self.outcomes if not one.is_right]


def grouped(outcomes: Iterable[Outcome], of: Callable[[Outcome], object]) -> dict[object, list[Outcome]]:
    """By what `of` takes of a point."""
    found: dict[object, list[Outcome]] = {}
    for one in outcomes:
        found.setdefault(of(one), []).append(one)
    return found


def causes(outcomes: Iterable[Outcome]) -> Counter:
    """Of the points that are not right: the fault, or the kind."""
    return Counter(one.why.split(" at ")[0] if one.kind == TRIPPED else one.kind for one in outcomes)
