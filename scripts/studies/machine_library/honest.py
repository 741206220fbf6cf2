"""Machines of the library on a plant with the errors of configs/ecu_honest.toml, scaled to each, and a drive that is
told what `identify` finds there.
"""

from pathlib import Path

from sextant_py.errors import UserError
from sextant_py.identify_files import told
from sextant_py.sweep_file import Settings

from studies import honest_drive, identification
from studies.parallel import in_order
from studies.torque_map.scale import LINK, OVER_CURRENT

from .points import RANGE_SHARE, Machine, Point
from .run import Lab

PERIODS_US = (50, 125)
SENSORS = ("honest",)
FLUX_WB = 1.1  # reference of the drive of ecu_honest.toml
ORDINARY_US = 100  # control period from which on the inverter is an ordinary one, with its longer dead time


def plant(machine: Machine, period_us: int, configuration: Settings) -> Settings:
    """The errors of ecu_honest.toml: currents by the trip level, voltages of the link by it, fluxes by the reference,
    drops of the switches as volts."""
    trip = configuration["protection.over_current_a"]
    by = {
        "slope_ohm": OVER_CURRENT / trip,
        "_a": trip / OVER_CURRENT,
        "_wb": configuration["control.flux_reference_wb"] / FLUX_WB,
        "range_v": machine.u_dc / LINK,
        "noise_v": machine.u_dc / LINK,
    }
    settings: Settings = {}
    for key, value in honest_drive.plant_settings().items():
        factor = next((factor for ending, factor in by.items() if key.endswith(ending)), None)
        settings[key] = value if factor is None else value * factor
    settings["plant.sensors.current.range_a"] = RANGE_SHARE * trip
    inverter = honest_drive.ORDINARY if period_us >= ORDINARY_US else honest_drive.HARSH
    return settings | {"plant.inverter.dead_time_us": inverter.dead_us, "protection.over_current_a": trip}


def identified(lab: Lab, machine: Machine, period_us: int, errors: Settings, directory: Path) -> Settings:
    """What `identify` tells a drive with this machine, of which the drops of its switches are known."""
    known: Settings = {"drive.inverter.slope_ohm": errors["plant.inverter.slope_ohm"]}
    given = errors | known | {"drive.period_us": period_us}
    work, threshold_v = directory / f"identify_{machine.id}_{period_us}", errors["plant.inverter.threshold_v"]
    file, parts = lab.scenario(machine.id), honest_drive.ALL_PARTS
    return known | told(identification.identified(file, lab.mil, work, parts, given, threshold_v))


def settings_of(lab: Lab, points: list[Point], directory: Path, jobs: int) -> tuple[dict, dict]:
    """By machine and period: plant and drive, and the sentences of those that identify does not finish."""
    pairs = {(p.cell.machine, p.cell.period_us): p for p in points if isinstance(lab.configuration(p), dict)}

    def one(point: Point) -> tuple[Settings | None, str]:
        machine, period = lab.machines[point.cell.machine], point.cell.period_us
        errors = plant(machine, period, lab.configuration(point))
        settings, refusal = None, ""
        try:
            settings = errors | identified(lab, machine, period, errors, directory)
        except UserError as error:
            refusal = f"identify: {error}"
        print(f"machine_library: {machine.id}, {period} us: {refusal or honest_drive.shown(settings)}", flush=True)
        return settings, refusal

    ended = dict(zip(pairs, in_order(one, pairs.values(), jobs), strict=True))
    found = {key: settings for key, (settings, _) in ended.items() if settings is not None}
    return found, {key: refusal for key, (_, refusal) in ended.items() if refusal}
