"""What the silently wrong points of the torque map have in common, and why they are wrong."""

from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

from studies.page import table

from .points import Conditions
from .results import SILENT, Results

WEAKENING_RAD_S = 160  # smallest speed of the map at which the voltage of the link limits the flux


def _is_rotor_wrong(one: Conditions) -> bool:
    return (one.r_r, one.l_m) != (1, 1)


@dataclass
class Kind:
    """Silently wrong points of one kind, of several drives."""

    name: str
    holds: Callable[[Conditions, float], bool]  # by conditions and magnitude of the speed [rad/s]
    cause: str
    drive: str = ""  # name of the one drive that has it; empty: every one may
    points: Counter = field(default_factory=Counter)  # by name of the drive
    speeds: list[float] = field(default_factory=list)  # magnitudes [rad/s]
    deviations: list[float] = field(default_factory=list)  # [N·m]
    silences: list[float] = field(default_factory=list)  # [ms]


def kinds() -> list[Kind]:
    """In order: a point belongs to the first that holds. The last holds for every point."""
    return [
        Kind(
            f"$R_r$ or $L_m$ wrong, {WEAKENING_RAD_S} rad/s and more",
            lambda one, speed: _is_rotor_wrong(one) and speed >= WEAKENING_RAD_S,
            "the start identifies $R_s$ by some volts along a flux that makes 300 V across; torque adapts it in half a "
            "second",
        ),
        Kind(
            "$R_r$ or $L_m$ wrong, with sensors, below",
            lambda one, _: _is_rotor_wrong(one) and one.sensors != "ideal",
            "magnetising at standstill leaves 14 % of $L_m$ and 6 to 15 % of $R_r$ unknown; torque alone shows $R_r$",
        ),
        Kind(
            "$R_r$ or $L_m$ wrong, ideal sensors, below",
            lambda one, _: _is_rotor_wrong(one),
            "as above",
        ),
        Kind(
            "$R_r$ and $L_m$ exact, with sensors",
            lambda one, _: one.sensors != "ideal",
            "the start takes the flux that current errors make, $(R_s + k_r^2 R_r)\\,\\delta i/\\omega_r$, for an "
            "error of $R_r$ or $L_m$",
        ),
        Kind(
            "$R_r$ and $L_m$ exact, ideal sensors",
            lambda _one, _speed: True,
            "at standstill the start shares an error of $R_s$ between $R_s$ and $R_r$, and nothing shows it later",
        ),
    ]


def found(maps: Iterable[Results], out: list[Kind]) -> list[Kind]:
    """Those of the kinds that the drives have."""
    for results in maps:
        for one in results.maps:
            for torque, row, deviations in zip(results.torques, one.outcomes, one.deviations, strict=True):
                for speed, letter, deviation in zip(results.speeds, row, deviations, strict=True):
                    if letter != SILENT:
                        continue
                    kind = next(
                        kind
                        for kind in out
                        if kind.drive in ("", results.drive) and kind.holds(one.conditions, abs(speed))
                    )
                    kind.points[results.drive] += 1
                    kind.speeds.append(abs(speed))
                    kind.deviations.append(deviation or 0.0)
                    kind.silences.append(one.silent_ms.get(f"{speed:g}/{torque:g}", 0.0))
    return [kind for kind in out if kind.speeds]


def _speeds(kind: Kind) -> str:
    least, largest = min(kind.speeds), max(kind.speeds)
    return f"{least:g}" if least == largest else f"{least:g} to {largest:g}"


def kinds_table(maps: Iterable[Results], by: Callable[[], list[Kind]] = kinds) -> str:
    drives = list(maps)
    rows = [
        (
            kind.name,
            *(kind.points[results.drive] for results in drives),
            _speeds(kind),
            f"{max(kind.deviations):.3g}",
            f"{max(kind.silences):.3g}",
            kind.cause,
        )
        for kind in found(drives, by())
    ]
    labels = [results.label for results in drives]
    head = ["silently wrong", *labels, "speed [rad/s]", "by up to [N·m]", "for up to [ms]", "cause"]
    return table(head, rows, left=(0, len(head) - 1))
