"""What the records of the torque map mean: the outcome of every point, and the file from which the page is made."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field

from studies.published import published

from .points import Conditions, Point
from .scale import TORQUE_FLOOR

TOLERANCE_SHARE = 0.05
R_S_TOLERANCE_NM = 1.5  # where the stator resistance alone is wrong
REACTION_MS = 10.0  # longest time of a deviation without derating or trip
UNOBSERVABLE_RAD_S = 10.0  # speed up to which errors of R_r and L_m may be invisible

RIGHT, DERATED, BRIEF, TRIPPED, OFF, UNSEEN, SILENT, FAILED = "r", "d", "b", "t", "o", "u", "s", "f"
MEANING = {
    RIGHT: "right",
    DERATED: "right, at the published torque below the command",
    BRIEF: "deviated for 10 ms at most",
    TRIPPED: "tripped in time",
    OFF: "gates off, no torque published or commanded",
    UNSEEN: "wrong in the unobservable region",
    SILENT: "silently wrong",
    FAILED: "no result",
}


def tolerance(torque: float, least: float = TORQUE_FLOOR) -> float:
    return max(least, TOLERANCE_SHARE * abs(torque))


def may_be_unseen(point: Point) -> bool:
    detuned = point.conditions.r_r != 1 or point.conditions.l_m != 1
    return detuned and abs(point.speed) <= UNOBSERVABLE_RAD_S


def outcome(record: dict, point: Point, floor: float = TORQUE_FLOOR) -> str:
    """floor: the smallest deviation that counts [N·m]."""
    if record["reason"]:
        return FAILED
    wrong = UNSEEN if may_be_unseen(point) else SILENT
    silent_ms, faults = record["torque_silent_ms"], record["faults"]
    offered = published(record, point.speed, point.torque) or 0.0
    if silent_ms is not None and silent_ms > REACTION_MS:
        return wrong
    if faults:
        return TRIPPED
    if silent_ms is None:  # the gates were never on
        return OFF if min(abs(point.torque), offered) <= floor else wrong
    if silent_ms > 0:
        return BRIEF
    return DERATED if abs(point.torque) > offered + tolerance(point.torque, floor) else RIGHT


def rounded(value: float | None) -> float | None:
    return None if value is None else float(f"{value:.3g}")


@dataclass
class MapOf:
    """One set of conditions: rows of torques, columns of speeds."""

    conditions: Conditions
    outcomes: list[str]  # a letter for each speed
    deviations: list[list[float | None]]  # largest, before a trip [N·m]
    silent_ms: dict[str, float] = field(default_factory=dict)  # by "speed/torque", of wrong points
    faults: dict[str, int] = field(default_factory=dict)  # first faults

    @property
    def counts(self) -> Counter:
        return Counter("".join(self.outcomes))


@dataclass
class Results:
    """The map of one drive."""

    drive: str
    label: str
    version: str
    commit: str
    speeds: list[float]
    torques: list[float]
    maps: list[MapOf]
    capability: dict = field(default_factory=dict)
    left_out: list[str] = field(default_factory=list)
    told: str = ""  # of what was identified

    @property
    def counts(self) -> Counter:
        return sum((one.counts for one in self.maps), Counter())

    @property
    def points(self) -> int:
        return sum(self.counts.values())

    def find(self, conditions: Conditions) -> MapOf | None:
        return next((one for one in self.maps if one.conditions == conditions), None)


def map_of(
    conditions: Conditions, speeds: list[float], torques: list[float], records: dict[str, dict],
    floor: float = TORQUE_FLOOR,
) -> MapOf:  # fmt: skip
    one = MapOf(conditions, [], [])
    faults: Counter = Counter()
    for torque in torques:
        found = [(point, records[point.key]) for point in (Point(conditions, speed, torque) for speed in speeds)]
        letters = [outcome(record, point, floor) for point, record in found]
        one.outcomes.append("".join(letters))
        one.deviations.append([rounded(record.get("torque_deviation_nm")) for _, record in found])
        faults.update(record["faults"][0][0] for _, record in found if record.get("faults"))
        for letter, (point, record) in zip(letters, found, strict=True):
            if letter in (SILENT, UNSEEN) and record["torque_silent_ms"] is not None:
                one.silent_ms[f"{point.speed:g}/{point.torque:g}"] = rounded(record["torque_silent_ms"])
    one.faults = dict(faults.most_common())
    return one


def beyond_r_s(results: Results) -> list[tuple[Conditions, float, float, float]]:
    """Points of a wrong stator resistance alone that deviate by more than 1.5 N·m and 5 %: conditions, speed, torque,
    deviation."""
    found = []
    for one in results.maps:
        if not one.conditions.is_r_s_alone:
            continue
        for torque, row in zip(results.torques, one.deviations, strict=True):
            limit = tolerance(torque, R_S_TOLERANCE_NM)
            found += [
                (one.conditions, speed, torque, value)
                for speed, value in zip(results.speeds, row, strict=True)
                if value is not None and value > limit
            ]
    return found


def trips(maps: Iterable[MapOf]) -> Counter:
    return sum((Counter(one.faults) for one in maps), Counter())
