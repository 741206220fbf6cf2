"""The drive of any configuration for the torque map: a file of sextant-ecu or of sextant-mil."""

from pathlib import Path

from sextant_py.drive_file import machine_of, of_the_drive, read
from sextant_py.short_run import known_keys

from .drive import COMMON, Drive
from .scale import rounded, scale_of

NOT_EXACT = ("saturation.knee_wb", "iron_loss.eddy_ohm", "iron_loss.hysteresis_ohm")


def load(file: Path, mil: Path, directory: Path) -> Drive:
    """The drive of the file; writes its scenario into the directory."""
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
    drive.put_in_force(mil, directory)
    drive.scale = scale_of(drive.configuration)
    # Limits beyond which the map goes on purpose.
    drive.base["protection.over_speed_rad_s"] = rounded(1.25 * drive.scale.speeds[-1])
    drive.put_in_force(mil, directory)
    return drive
