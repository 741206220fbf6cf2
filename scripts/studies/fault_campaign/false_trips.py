"""Hours of ordinary driving with the sensors as they are: every fault that latches is a false trip."""

import random
import tempfile
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from sextant_py import profile
from sextant_py.errors import UserError
from sextant_py.paths import ROOT
from sextant_py.short_run import run_of
from sextant_py.sweep_file import Settings

from studies.command import write_toml
from studies.torque_map import drive as torque_map_drive
from studies.torque_map import scale

SENSORS: Settings = scale.SENSORS["real"] | {
    "plant.sensors.encoder.lines": 1024,
    "plant.sensors.encoder.speed": "period",
    "plant.sensors.encoder.window_periods": 20,
}
LARGEST_TORQUE = 130.0  # of the random steps [N·m]
LARGEST_SPEED = 120.0  # of the shaft under them [rad/s]
TIME_LIMIT_S = 1200  # of one run [s]


@dataclass(frozen=True)
class Drive:
    """One run of a kind of driving."""

    kind: str
    seed: int
    duration_s: float


@dataclass
class Hours:
    """What a kind of driving has shown."""

    kind: str
    simulated_s: float = 0.0  # up to the first fault of each run [s]
    runs: int = 0
    faults: dict[str, int] = field(default_factory=Counter)
    cases: list[str] = field(default_factory=list)


Points = list[tuple[float, float]]


def _table(file: Path, points: Points) -> str:
    lines = ["time_s,value", *(f"{t:.6f},{value:.3f}" for t, value in points)]
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return str(file)


def _torque(directory: Path, points: Points) -> Settings:
    return {"profile.torque_nm.shape": "table", "profile.torque_nm.file": _table(directory / "torque.csv", points)}


def _demo(_: Drive, directory: Path) -> Settings:
    points = profile.load(ROOT / "configs/profiles/demo.csv").points
    return _torque(directory, [(point.time_s, point.torque_nm) for point in points])


def _nycc(_: Drive, __: Path) -> Settings:
    return {
        "cycle.file": str(ROOT / "configs/cycles/nycc.csv"),
        "cycle.table": str(ROOT / "configs/vehicles/passive_ev.csv"),
        "cycle.extrapolation": "linear",
    }


def random_steps(
    drive: Drive, directory: Path, largest_torque: float = LARGEST_TORQUE, largest_speed: float = LARGEST_SPEED,
    from_s: float = 0.1,
) -> Settings:  # fmt: skip
    """Steps of torque 2.5 to 300 ms apart, on a shaft that goes in straight lines between random speeds."""
    dice = random.Random(drive.seed)
    steps, speeds = [(0.0, 0.0)], [(0.0, 0.0)]
    t = from_s
    while t < drive.duration_s:
        torque = dice.uniform(-largest_torque, largest_torque)
        steps += [(t, steps[-1][1]), (t, torque)]
        t += dice.choice((0.005, 0.02, 0.1, 0.3)) * dice.uniform(0.5, 1.0)
    while speeds[-1][0] < drive.duration_s:
        speeds.append((speeds[-1][0] + dice.uniform(0.3, 2.0), dice.uniform(-largest_speed, largest_speed)))
    return {
        **_torque(directory, steps),
        "load.kind": "imposed_speed",
        "load.speed_rad_s.shape": "table",
        "load.speed_rad_s.file": _table(directory / "speed.csv", speeds),
    }


KINDS: dict[str, tuple[Callable[[Drive, Path], Settings], float]] = {
    "demo profile": (_demo, 10.0),
    "NYCC": (_nycc, 598.0),
    "random torque steps": (random_steps, 30.0),
}


def drives(hours: float) -> list[Drive]:
    """Runs of each kind that last for so long in all."""
    found = []
    for kind, (_, duration_s) in KINDS.items():
        runs = max(1, -int(-3600 * hours // duration_s))
        found += [Drive(kind, seed, duration_s) for seed in range(1, runs + 1)]
    return sorted(found, key=lambda drive: -drive.duration_s)


class Lab:
    """The drive of configs/ecu.toml in sextant-mil."""

    def __init__(self, mil: Path, directory: Path) -> None:
        self.mil = mil
        self.drive = torque_map_drive.load("shipped", mil, directory)
        # Without torque: a cycle brings one.
        own = {"name": "plain", "duration_s": 1}
        self.plain = write_toml(directory / "plain.toml", own | self.drive.base)

    def run(self, drive: Drive) -> tuple[Drive, dict]:
        with tempfile.TemporaryDirectory(prefix="sextant-trips-") as name:
            directory = Path(name)
            settings = {
                "duration_s": drive.duration_s,
                "plant.sensors.seed": drive.seed,
                **SENSORS,
                **KINDS[drive.kind][0](drive, directory),
            }
            ended = run_of(self.mil, self.plain, settings, TIME_LIMIT_S)
        if ended.summary is None:
            raise UserError(f"{drive.kind}, seed {drive.seed}: {ended.said}.")
        return drive, ended.summary


def add(hours: dict[str, Hours], drive: Drive, summary: dict) -> None:
    one = hours.setdefault(drive.kind, Hours(drive.kind))
    one.runs += 1
    faults = summary["faults"]
    one.simulated_s += faults[0]["t_s"] if faults else drive.duration_s
    if faults:
        first = faults[0]
        one.faults[first["fault"]] += 1
        one.cases.append(f"seed {drive.seed}: {first['fault']} at {first['t_s']:.6f} s")
