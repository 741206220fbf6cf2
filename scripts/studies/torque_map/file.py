"""The drive of any configuration for the torque map: a file of sextant-ecu or of sextant-mil, and its range of points.

Speeds and torques are those of the shipped drive, scaled by the speed at which the link is just enough for the flux,
and by the drive's torque limit; so are the errors of the sensors, by the over-current limit and the link.
"""

import math
from dataclasses import dataclass
from pathlib import Path

from sextant_py.drive_file import machine_of, of_the_drive, read
from sextant_py.short_run import SHORT, known_keys, summary_of
from sextant_py.sweep_file import Settings

from .drive import COMMON, SENSORS, Drive
from .points import QUICK_SPEEDS, QUICK_TORQUES, SPEEDS, TORQUES

# What the shipped drive has, by which the ranges of the map scale.
BASE_SPEED, TORQUE_LIMIT = 530 / math.sqrt(3) / 1.1 / 2, 150.0  # [rad/s], [N·m]
OVER_CURRENT, LINK = 250.0, 530.0  # [A], [V]
TORQUE_FLOOR = 2.0  # smallest deviation that counts [N·m]
NOT_EXACT = ("saturation.knee_wb", "iron_loss.eddy_ohm", "iron_loss.hysteresis_ohm")


@dataclass(frozen=True)
class Scale:
    """The range of the points of a drive."""

    speeds: tuple[float, ...]  # mechanical [rad/s]
    torques: tuple[float, ...]  # [N·m]
    quick_speeds: tuple[float, ...]
    quick_torques: tuple[float, ...]
    torque_floor: float  # [N·m]
    sensors: dict[str, Settings]
    from_s: float  # end of start and magnetising [s]
    step_s: float  # of the torque [s]
    end_s: float  # [s]


def _rounded(value: float) -> float:
    return float(f"{value:.4g}")


def _sensors(configuration: Settings) -> dict[str, Settings]:
    current = configuration["protection.over_current_a"] / OVER_CURRENT
    voltage = configuration["plant.u_dc_v"] / LINK
    by = {"_a": current, "_v": voltage}
    return {
        name: {key: _rounded(value * by.get(key[-2:], 1)) if key[-2:] in by else value for key, value in one.items()}
        for name, one in SENSORS.items()
    }


def scale_of(configuration: Settings) -> Scale:
    """From the configuration in force."""
    pole_pairs = configuration["machine.poles"] // 2
    flux_speed = configuration["plant.u_dc_v"] / math.sqrt(3) / configuration["control.flux_reference_wb"]
    speed = flux_speed / pole_pairs / BASE_SPEED
    limit = min(configuration["command.torque_limit_nm"], configuration["capability.torque_nm"])
    torque = limit / TORQUE_LIMIT
    # As long as magnetising may take, and a tenth of a second.
    from_s = max(0.15, 0.1 + 1e-3 * configuration["drive.magnetise_timeout_ms"])
    return Scale(
        tuple(_rounded(speed * value) for value in SPEEDS),
        tuple(_rounded(torque * value) for value in TORQUES),
        tuple(_rounded(speed * value) for value in QUICK_SPEEDS),
        tuple(_rounded(torque * value) for value in QUICK_TORQUES),
        _rounded(torque * TORQUE_FLOOR),
        _sensors(configuration),
        from_s,
        from_s + 0.2,
        from_s + 0.95,
    )


def load(file: Path, mil: Path, directory: Path) -> tuple[Drive, Scale]:
    """The drive of the file, and its range; writes its scenario into the directory."""
    found = read(file)
    machine = machine_of(found, file)
    given = {f"machine.{key}": value for key, value in machine.items()}
    known = known_keys(mil, directory, given)
    settings, left_out = of_the_drive(found, known, file)
    drive = Drive(f"file_{file.stem}", given | settings, machine, known)
    drive.title, drive.left_out = file.name, left_out
    drive.base |= {key: value for key, value in COMMON.items() if key in known and not key.startswith("protection.")}
    if any(drive.base.get(f"plant.{key}") for key in NOT_EXACT):
        drive.base["plant.integrator"] = "fixed"  # the exact transition is that of linear magnetics without loss
    scenario = directory / f"{drive.name}.toml"
    scenario.write_text(drive.scenario(), encoding="utf-8")
    scale = scale_of(summary_of(mil, scenario, SHORT)["configuration"])
    # Limits beyond which the map goes on purpose.
    drive.base["protection.over_speed_rad_s"] = _rounded(1.25 * scale.speeds[-1])
    scenario.write_text(drive.scenario(), encoding="utf-8")
    shown = summary_of(mil, scenario, SHORT)
    drive.configuration, drive.version, drive.commit = shown["configuration"], shown["version"], shown["commit"]
    drive.scale = scale
    return drive, scale
