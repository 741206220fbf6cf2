"""Machines of the library on a plant with the errors of configs/ecu_honest.toml, scaled to each, and a drive that is
told what `identify` finds there.
"""

import random
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from . import honest_drive, identify
from .errors import UserError
from .identify_files import told
from .machine_library_points import RANGE_SHARE, SPEEDS, TORQUES, Cell, Machine, Point
from .machine_library_run import Lab
from .sweep_file import Settings, toml_value
from .torque_map_file import LINK, OVER_CURRENT

PERIODS_US = (50, 125)
SENSORS = "honest"
FLUX_WB = 1.1  # reference of the drive of ecu_honest.toml
FASTEST_US = 100  # control period from which on the inverter is an ordinary one, with its longer dead time


def plan(machines: Iterable[Machine], methods: Iterable[str], periods_us: Iterable[int], seed: int, count: int):
    """In each cell that many speeds, as `points` of machine_library_points draws them."""
    found = []
    for machine in machines:
        for period in periods_us:
            for method in methods:
                cell = Cell(machine.id, period, method, SENSORS)
                dice = random.Random(f"{seed}/{cell.key}")
                for speed in dice.sample(SPEEDS, min(count, len(SPEEDS))):
                    sign = dice.choice((-1, 1))
                    found.append(Point(cell, dice.choice((-1, 1)) * speed or 0.0, sign * dice.choice(TORQUES)))
    return found


def plant(machine: Machine, period_us: int, configuration: Settings) -> Settings:
    """The errors of ecu_honest.toml: currents by the trip level, voltages of the link by it, fluxes by the reference,
    drops of the switches as volts."""
    trip = configuration["protection.over_current_a"]
    by = {"_a": trip / OVER_CURRENT, "_wb": configuration["control.flux_reference_wb"] / FLUX_WB}
    settings: Settings = {"plant.integrator": "fixed"}
    for key, value in honest_drive.plant_settings().items():
        if key.endswith("slope_ohm"):
            settings[key] = value * OVER_CURRENT / trip
        elif key.startswith("plant.sensors.voltage.") and key.endswith("_v"):
            settings[key] = value * machine.u_dc / LINK
        elif isinstance(value, float | int) and not key.endswith("integrator"):
            suffix = next((s for s in by if key.endswith(s)), "")
            settings[key] = value * by.get(suffix, 1)
    settings["plant.sensors.current.range_a"] = RANGE_SHARE * trip
    inverter = honest_drive.ORDINARY if period_us >= FASTEST_US else honest_drive.HARSH
    return settings | {"plant.inverter.dead_time_us": inverter.dead_us, "protection.over_current_a": trip}


def identified(lab: Lab, machine: Machine, period_us: int, errors: Settings, directory: Path) -> Settings:
    """What `identify` tells a drive with this machine, of which the drops of its switches are known."""
    known: Settings = {"drive.inverter.slope_ohm": errors["plant.inverter.slope_ohm"]}
    given = errors | known | {"drive.period_us": period_us}
    words = [str(lab.scenario(machine.id)), "--only", ",".join(honest_drive.ALL_PARTS)]
    words += ["--threshold-v", toml_value(errors["plant.inverter.threshold_v"])]
    words += [word for key, value in given.items() for word in ("--set", f"{key}={toml_value(value)}")]
    work = directory / f"identify_{machine.id}_{period_us}"
    work.mkdir(parents=True, exist_ok=True)
    options = identify.parse_arguments(words)
    return known | told(identify.identified(lab.scenario(machine.id), lab.mil, work, options))


def settings_of(lab: Lab, points: list[Point], directory: Path, jobs: int) -> tuple[dict, dict]:
    """By machine and period: plant and drive, and the sentences of those that identify does not finish."""
    found, refused = {}, {}
    pairs = {(p.cell.machine, p.cell.period_us): p for p in points if isinstance(lab.configuration(p), dict)}

    def one(point: Point) -> tuple[Settings | None, str]:
        machine = lab.machines[point.cell.machine]
        errors = plant(machine, point.cell.period_us, lab.configuration(point))
        try:
            return errors | identified(lab, machine, point.cell.period_us, errors, directory), ""
        except UserError as error:
            return None, f"identify: {error}"

    with ThreadPoolExecutor(jobs) as pool:
        for key, (settings, refusal) in zip(pairs, pool.map(one, pairs.values()), strict=True):
            if settings is None:
                refused[key] = refusal
            else:
                found[key] = settings
            machine, period = key
            print(f"machine_library: {machine}, {period} us: {refusal or honest_drive.shown(settings)}", flush=True)
    return found, refused
