"""The torque map on the honest plant: the drive of configs/ecu_honest.toml, told what `identify` finds there, by each
method; and its page.
"""

from dataclasses import dataclass, field, replace
from pathlib import Path

from sextant_py.sweep_file import Settings

from studies import honest_drive
from studies.page import filled

from . import figures
from . import file as torque_map_file
from . import kinds as torque_map_kinds
from . import measure as torque_map_measure
from . import page as torque_map_page
from .drive import Drive
from .kinds import WEAKENING_RAD_S, Kind
from .points import Conditions
from .results import Results
from .run import Lab
from .scale import SHIPPED

_MAGNITUDES = (0, 5, 10, 20, 50, 100, 200, 400)
SPEEDS = tuple(sorted({sign * speed for speed in _MAGNITUDES for sign in (-1, 1)}))  # mechanical [rad/s]
SHOWN_SPEEDS = (-200, -20, 0, 20, 200)  # ticks of the picture
TORQUES = (-130, -60, 0, 60, 130)  # [N·m]
TOLD, WARM = (0.9, 1.1), 1.2  # shares of the dead time, and of the resistances of a cold machine
SETS = (
    Conditions(),
    *(Conditions(dead_time=share) for share in TOLD),
    Conditions(r_s=WARM),
    Conditions(r_s=WARM, r_r=WARM),
    Conditions(shaft="free"),
)
TEMPLATE = Path(__file__).with_name("honest.md")
SLOW_RAD_S = 20  # up to which points count as near standstill


@dataclass(frozen=True)
class Variant:
    """A method, the parts of `identify` by which its drive is told, and what is set beside."""

    name: str
    label: str
    method: str
    parts: tuple[str, ...] = honest_drive.INVERTER_PARTS
    sets: tuple[Conditions, ...] = SETS
    more: Settings = field(default_factory=dict)


VARIANTS = (
    *(Variant(f"honest_{method}", method, method) for method in honest_drive.METHODS),
    Variant("honest_all", "foc, all identified", "foc", honest_drive.ALL_PARTS, SETS[:1]),
    Variant("honest_fixed", "foc, not adapted", "foc", sets=SETS[:1], more={"control.adapts_parameters": False}),
)
NAMES = tuple(variant.name for variant in VARIANTS)


def drive_of(variant: Variant, mil: Path, directory: Path) -> Drive:
    file = honest_drive.identified(honest_drive.ORDINARY, mil, directory, variant.parts)
    loaded = torque_map_file.load(file, mil, directory)
    base = loaded.base | {"control.controller": variant.method} | variant.more
    drive = replace(loaded, name=variant.name, title=variant.label, base=base)
    drive.write(directory)
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


def _kinds_above() -> list[Kind]:
    """Those above SLOW_RAD_S, of each drive: none has the cause of another."""

    def above(_one: Conditions, speed: float) -> bool:
        return speed > SLOW_RAD_S

    return [
        Kind(
            f"`dtc`, {WEAKENING_RAD_S} rad/s and more",
            lambda _one, speed: speed >= WEAKENING_RAD_S,
            "the method: the flux is weakened, and one vector of the table lasts a whole period of 125 µs",
            "honest_dtc",
        ),
        Kind(
            f"`dtc`, above {SLOW_RAD_S} and below {WEAKENING_RAD_S} rad/s",
            above,
            "on a free shaft alone, and hardly longer than what counts as brief; the cause is not known",
            "honest_dtc",
        ),
        Kind(
            f"`foc`, above {SLOW_RAD_S} rad/s",
            above,
            "on a free shaft alone, and hardly longer than what counts as brief; the cause is not known",
            "honest_foc",
        ),
        Kind(
            f"all identified, above {SLOW_RAD_S} rad/s",
            above,
            "the cause is not known",
            "honest_all",
        ),
        Kind(
            f"not adapted, above {SLOW_RAD_S} rad/s",
            above,
            "weakened flux saturates less, and $L_m$ is that of the whole; `foc`, which adapts it, is right",
            "honest_fixed",
        ),
    ]


def kinds() -> list[Kind]:
    """In order: a point belongs to the first that holds. The last holds for every point."""
    return [
        *_kinds_above(),
        Kind(
            f"dead time told wrong, up to {SLOW_RAD_S} rad/s",
            lambda one, _: one.dead_time != 1,
            "as with the one found",
        ),
        Kind(
            f"free shaft, up to {SLOW_RAD_S} rad/s",
            lambda one, _: one.shaft == "free",
            "magnetised at standstill, where the current alone shows the flux, "
            f"{SHIPPED.step_s - SHIPPED.from_s:g} s before the step",
        ),
        Kind(
            f"warm, up to {SLOW_RAD_S} rad/s",
            lambda one, _: (one.r_s, one.r_r) != (1, 1),
            "as with the resistances found",
        ),
        Kind(
            f"as found, up to {SLOW_RAD_S} rad/s",
            lambda _one, _speed: True,
            "noise, gains and offsets of the current sensors leave some percent of $R_r$ and $L_m$ open while the "
            "machine is magnetised, beside its saturation; half a second of torque adapts them",
        ),
    ]


def fields(maps: dict[str, Results]) -> dict[str, str]:
    """What the template names."""
    return {
        "files": ", ".join(f"`{name}.json`" for name in maps),
        "versions": "; ".join(sorted({f"{results.version}, {results.commit[:10]}" for results in maps.values()})),
        "plant": honest_drive.ORDINARY.label,
        "speeds": ", ".join(f"{value:g}" for value in _MAGNITUDES),
        "torques": ", ".join(f"{value:g}" for value in TORQUES if value >= 0),
        "warm": f"{WARM:g}",
        "counts": torque_map_page.counts_table(maps),
        "kinds": torque_map_kinds.kinds_table(maps.values(), kinds),
    }


def write(maps: dict[str, Results], directory: Path) -> list[Path]:
    """Picture and page; the files that are written."""
    picture, page = directory / "honest.png", directory / "honest.md"
    rows = [
        (results.label, [(results, one) for one in half])
        for results in maps.values()
        if len(results.maps) == len(SETS)
        for half in (results.maps[:3], results.maps[3:])
    ]
    figures.grid(rows, picture, SHOWN_SPEEDS)
    page.write_text(filled(TEMPLATE, fields(maps)), encoding="utf-8")
    return [picture, page]
