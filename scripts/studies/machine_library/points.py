"""The points of the study over the library of machines: which they are, and what each sets in a scenario."""

import math
import random
import tomllib
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from sextant_py.errors import UserError
from sextant_py.paths import ROOT
from sextant_py.sweep_file import Settings, toml_value

from studies.command import chosen

MACHINES = ROOT / "configs" / "machines"
LIBRARY = MACHINES / "library.toml"
PERIODS_US = (25, 50, 100, 125, 250)
SENSORS = ("ideal", "12 bits")
SPEEDS = (0.0, 0.02, 0.1, 0.3, 0.5, 0.8, 1.0, 1.2, 1.5, 2.0)  # shares of the base speed
TORQUES = (0.1, 0.5, 1.0, 1.5)  # shares of the rated torque
POINTS_A_CELL = 3  # of a machine, a period, a method and kind of sensors
QUICK_POINTS_A_MACHINE = 6
STEP_S = 1.2  # of the torque, after the end of magnetising
FROM_S = 1.7  # beginning of the window of the mean torque
END_S = 2.1
LIMIT_SHARE = 0.98  # of the drive's torque limit, which a point's torque keeps
RANGE_SHARE = 1.25  # of the current sensors' range, by the over-current limit


@dataclass(frozen=True)
class Machine:
    """An entry of the library."""

    name: str
    file: Path
    power_w: float
    voltage: float  # line to line, RMS [V]
    frequency_hz: float
    rated_torque: float  # [N·m]
    base_speed: float  # mechanical, synchronous at rated frequency [rad/s]
    poles: int
    u_dc: float  # [V]

    @property
    def id(self) -> str:
        return self.file.stem

    def scenario(self) -> str:
        """The file that every point of the machine begins from: nothing but machine and link is set."""
        lines = [
            f"name = {toml_value(self.id)}", f"duration_s = {END_S}", f"machine = {toml_value(str(self.file))}",
            "[profile.torque_nm]", 'shape = "steps"', f"points = [[0, 0], [{STEP_S}, 0]]",
            "[load]", 'kind = "imposed_speed"',
            "[plant]", f"u_dc_v = {self.u_dc:g}", 'integrator = "exact"',
            "[metrics]", f"window_from_s = {FROM_S}",
        ]  # fmt: skip
        return "\n".join(lines) + "\n"


def read_library(file: Path = LIBRARY) -> list[Machine]:
    try:
        entries = tomllib.loads(file.read_text(encoding="utf-8"))["machine"]
        return [_machine(entry, file.parent / entry["file"]) for entry in entries]
    except OSError as error:
        raise UserError(f"{error.filename or file} cannot be read: {error.strerror}.") from None
    except (tomllib.TOMLDecodeError, KeyError, TypeError) as error:
        raise UserError(f"{file} is no library of machines: {error}.") from None


def chosen_machines(wanted: list[str] | None) -> list[Machine]:
    """Of the library, those of the option --machines."""
    library = read_library()
    names = chosen("--machines", wanted, [machine.id for machine in library])
    return [machine for machine in library if machine.id in names]


def _machine(entry: dict, file: Path) -> Machine:
    poles = tomllib.loads(file.read_text(encoding="utf-8"))["poles"]
    speed = entry["speed_rpm"] * math.pi / 30
    return Machine(
        entry["name"], file, entry["power_w"], entry["voltage_v"], entry["frequency_hz"],
        entry.get("torque_nm", entry["power_w"] / speed), 4 * math.pi * entry["frequency_hz"] / poles, poles,
        entry["u_dc_v"],
    )  # fmt: skip


@dataclass(frozen=True)
class Cell:
    machine: str
    period_us: int
    method: str
    sensors: str

    @property
    def key(self) -> str:
        return f"{self.machine}/{self.period_us}/{self.method}/{self.sensors}"


@dataclass(frozen=True)
class Point:
    cell: Cell
    speed: float  # share of the base speed, with its sign
    torque: float  # share of the rated torque, with its sign

    @property
    def key(self) -> str:
        return f"{self.cell.key}/{self.speed:g}/{self.torque:g}"


def cells(
    machines: Iterable[Machine],
    methods: Iterable[str],
    periods_us: Iterable[int],
    sensors: tuple[str, ...] = SENSORS,
) -> list[Cell]:
    methods, periods_us = tuple(methods), tuple(periods_us)
    return [Cell(m.id, p, method, s) for m in machines for p in periods_us for method in methods for s in sensors]


def points(chosen: Iterable[Cell], seed: int, count: int = POINTS_A_CELL) -> list[Point]:
    """In each cell that many speeds without a repetition, each in a random direction, with torques of both signs in
    turn; a cell's points do not depend on which other cells there are."""
    found = []
    for cell in chosen:
        dice = random.Random(f"{seed}/{cell.key}")
        sign = dice.choice((-1, 1))
        for speed in dice.sample(SPEEDS, min(count, len(SPEEDS))):
            found.append(Point(cell, dice.choice((-1, 1)) * speed or 0.0, sign * dice.choice(TORQUES)))
            sign = -sign
    return found


def quick_points(all_points: list[Point], seed: int) -> list[Point]:
    """A few of each machine."""
    dice, found = random.Random(seed), []
    for machine in dict.fromkeys(point.cell.machine for point in all_points):
        own = [point for point in all_points if point.cell.machine == machine]
        found += dice.sample(own, min(QUICK_POINTS_A_MACHINE, len(own)))
    return found


def cell_settings(cell: Cell) -> Settings:
    return {"control.controller": cell.method, "drive.period_us": cell.period_us}


def sensor_settings(sensors: str, over_current: float, u_dc: float) -> Settings:
    if sensors != "12 bits":
        return {}
    return {
        "plant.sensors.current.range_a": RANGE_SHARE * over_current,
        "plant.sensors.current.bits": 12,
        "plant.sensors.voltage.range_v": 2 * u_dc,
        "plant.sensors.voltage.bits": 12,
    }


def command_of(point: Point, machine: Machine, configuration: Settings) -> float:
    """The point's torque, within the limit that the drive has by default. [N·m]"""
    largest = LIMIT_SHARE * configuration["command.torque_limit_nm"]
    return max(-largest, min(largest, point.torque * machine.rated_torque))


def settings(point: Point, machine: Machine, configuration: Settings) -> Settings:
    """What the point adds to its machine's scenario; configuration: the one in force for its cell."""
    over_current = configuration["protection.over_current_a"]
    return {
        **cell_settings(point.cell),
        **sensor_settings(point.cell.sensors, over_current, machine.u_dc),
        "load.speed_rad_s.value": point.speed * machine.base_speed,
        "profile.torque_nm.points": [[0, 0], [STEP_S, command_of(point, machine, configuration)]],
    }
