"""The counts of the torque map that stand in docs/torque.md."""

from collections.abc import Callable
from pathlib import Path

from sextant_py.paths import ROOT

from studies.page import put_into

from .points import Conditions
from .results import SILENT, UNSEEN, Results

PAGE = ROOT / "docs" / "torque.md"


def _rotor(one: Conditions) -> bool:
    return (one.r_r, one.l_m) != (1, 1) and one.sensors == "ideal"


def _rotor_and_sensors(one: Conditions) -> bool:
    return (one.r_r, one.l_m) != (1, 1) and one.sensors != "ideal"


def _sensors(one: Conditions) -> bool:
    return (one.r_r, one.l_m) == (1, 1) and one.sensors != "ideal"


# By mark in the page: what is wrong, with any R_s; smallest and largest magnitude of the speed [rad/s].
COUNTS: dict[str, tuple[Callable[[Conditions], bool], float, float]] = {
    "rotor, 20 to 130 rad/s": (_rotor, 20, 130),
    "rotor, 160 to 400 rad/s": (_rotor, 160, 400),
    "rotor and sensors, 20 to 50 rad/s": (_rotor_and_sensors, 20, 50),
    "rotor and sensors, 75 to 130 rad/s": (_rotor_and_sensors, 75, 130),
    "rotor and sensors, 160 to 400 rad/s": (_rotor_and_sensors, 160, 400),
    "sensors": (_sensors, 0, 400),
}


def missed(results: Results, counts: Callable[[Conditions], bool], least: float, largest: float) -> str:
    """Points that miss the tolerance, of all."""
    letters = [
        letter
        for one in results.maps
        if counts(one.conditions)
        for row in one.outcomes
        for speed, letter in zip(results.speeds, row, strict=True)
        if least <= abs(speed) <= largest
    ]
    return f"{letters.count(SILENT):,} of {len(letters):,}"


def blocks(results: Results) -> dict[str, str]:
    """By mark of the page, the counts of these results."""
    counts = {name: missed(results, *group) for name, group in COUNTS.items()}
    return counts | {"unobservable": f"{results.counts[UNSEEN]:,}"}


def write(results: Results) -> Path:
    return put_into(PAGE, blocks(results))
