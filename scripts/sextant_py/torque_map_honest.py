"""The torque map on the honest plant: the drive of configs/ecu_honest.toml, told what `identify` finds there, by each
method; and its page.
"""

from dataclasses import dataclass, replace
from pathlib import Path

from . import honest_drive, torque_map_figures, torque_map_file, torque_map_kinds, torque_map_measure, torque_map_page
from .page import table
from .torque_map_drive import Drive
from .torque_map_kinds import Kind
from .torque_map_points import Conditions
from .torque_map_results import SILENT, MapOf, Results
from .torque_map_run import Lab

_MAGNITUDES = (0, 5, 10, 20, 50, 100, 200, 400)
SPEEDS = tuple(sorted({sign * speed for speed in _MAGNITUDES for sign in (-1, 1)}))  # mechanical [rad/s]
TORQUES = (-130, -60, 0, 60, 130)  # [N·m]
TOLD, WARM = (0.9, 1.1), 1.2  # shares of the dead time, and of the resistances of a cold machine
SETS = (
    Conditions(),
    *(Conditions(dead_time=share) for share in TOLD),
    Conditions(r_s=WARM),
    Conditions(r_s=WARM, r_r=WARM),
    Conditions(shaft="free"),
)
TEMPLATE = Path(__file__).with_name("torque_map_honest.md")
SLOW_RAD_S = 20  # up to which points count as near standstill


@dataclass(frozen=True)
class Variant:
    """A method, and the parts of `identify` by which its drive is told."""

    name: str
    method: str
    parts: tuple[str, ...] = honest_drive.INVERTER_PARTS
    sets: tuple[Conditions, ...] = SETS

    @property
    def label(self) -> str:
        return self.method if self.parts == honest_drive.INVERTER_PARTS else f"{self.method}, all identified"


VARIANTS = (
    *(Variant(f"honest_{method}", method) for method in honest_drive.METHODS),
    Variant("honest_all", "foc", honest_drive.ALL_PARTS, SETS[:1]),
)
NAMES = tuple(variant.name for variant in VARIANTS)


def drive_of(variant: Variant, mil: Path, directory: Path) -> Drive:
    file = honest_drive.identified(honest_drive.ORDINARY, mil, directory, variant.parts)
    loaded, _ = torque_map_file.load(file, mil, directory)
    base = loaded.base | {"control.controller": variant.method}
    drive = replace(loaded, name=variant.name, title=variant.label, base=base)
    (directory / f"{drive.name}.toml").write_text(drive.scenario(), encoding="utf-8")
    return drive


def measure(mil: Path, directory: Path, jobs: int, restart: bool) -> list[Results]:
    found = []
    for variant in VARIANTS:
        lab = Lab(mil, drive_of(variant, mil, directory), directory)
        results = torque_map_measure.measured(lab, [*variant.sets], [*SPEEDS], [*TORQUES], jobs, restart)
        results.capability = torque_map_measure.capability(lab, results.speeds)
        results.told = honest_drive.shown(lab.drive.base)
        found.append(results)
    return found


def kinds() -> list[Kind]:
    """In order: a point belongs to the first that holds."""
    return [
        Kind("all", lambda _one, _speed: True, "–"),
    ]


def sets_table(maps: dict[str, Results]) -> str:
    """Silently wrong points of each set, near standstill and above."""
    head = ["set", *(f"`{results.label}`, {end}" for results in maps.values() for end in ("slow", "fast", "N·m"))]
    rows = []
    for conditions in SETS:
        cells = [conditions.label if conditions != Conditions() else "as found"]
        for results in maps.values():
            one = results.find(conditions)
            cells += [*_counts(results, one), _largest(results, one)] if one else ["–"] * 3
        rows.append(cells)
    return table(head, rows)


def _counts(results: Results, one: MapOf) -> tuple[int, int]:
    columns = [
        (abs(speed) <= SLOW_RAD_S, [row[k] for row in one.outcomes].count(SILENT))
        for k, speed in enumerate(results.speeds)
    ]
    return sum(count for slow, count in columns if slow), sum(count for slow, count in columns if not slow)


def _largest(results: Results, one: MapOf) -> str:
    values = [
        value
        for letters, row in zip(one.outcomes, one.deviations, strict=True)
        for speed, letter, value in zip(results.speeds, letters, row, strict=True)
        if letter != SILENT and abs(speed) > SLOW_RAD_S and value is not None
    ]
    return f"{max(values):.3g}" if values else "–"


def fields(maps: dict[str, Results]) -> dict[str, str]:
    """What the template names."""
    return {
        "files": ", ".join(f"`{name}.json`" for name in maps),
        "versions": "; ".join(sorted({f"{results.version}, {results.commit[:10]}" for results in maps.values()})),
        "plant": honest_drive.ORDINARY.label,
        "speeds": ", ".join(f"{value:g}" for value in _MAGNITUDES),
        "torques": ", ".join(f"{value:g}" for value in TORQUES if value >= 0),
        "warm": f"{WARM:g}",
        "slow": f"{SLOW_RAD_S:g}",
        "counts": torque_map_page.counts_table(maps),
        "sets": sets_table(maps),
        "kinds": torque_map_kinds.kinds_table(maps.values(), kinds),
        "faults": torque_map_page.faults_table(maps),
        "told": "\n".join(f"- {results.label}: {results.told}" for results in maps.values()),
    }


def write(maps: dict[str, Results], directory: Path) -> list[Path]:
    """Picture and page; the files that are written."""
    picture, page = directory / "honest.png", directory / "honest.md"
    rows = [
        (results.label, found)
        for results in maps.values()
        for half in (SETS[:3], SETS[3:])
        if (found := [(results, one) for conditions in half if (one := results.find(conditions))])
    ]
    torque_map_figures.grid(rows, picture)
    page.write_text(torque_map_page.filled(TEMPLATE, fields(maps)), encoding="utf-8")
    return [picture, page]
