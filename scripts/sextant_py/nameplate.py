"""Machine parameters, limits of the drive, configurations that run, and a report, from a name plate."""

import argparse
import re
from pathlib import Path

from . import nameplate_files, nameplate_page, nameplate_plate
from .control_methods import METHODS
from .errors import UserError, run
from .nameplate_limits import OVERLOAD, limits_of
from .nameplate_report import report
from .nameplate_spread import variants
from .paths import OUT
from .program_arguments import parser_of

EXAMPLES = """examples:
  scripts/nameplate --power-w 2200 --voltage-v 400 --connection star --current-a 5 --speed-rpm 1430 \\
    --frequency-hz 50 --power-factor 0.79                 what stands on every plate
  scripts/nameplate motor.toml --name pump                the same as keys of a file: power_w = 2200 …
  scripts/nameplate motor.toml --breakdown-ratio 2.9      with the data sheet's breakdown torque
  scripts/nameplate motor.toml --r-s-ohm 3.7              with a measured winding
  scripts/nameplate motor.toml --u-dc-v 560 --period-us 50
  sextant-mil out/nameplate/motor/half_speed.toml         rated torque at half of the rated speed
  scripts/identify out/nameplate/motor/drive.toml         then: dead time and R_s by measurement

DIR gets NAME.toml, the machine; drive.toml, the drive with its limits; ecu.toml for sextant-ecu and half_speed.toml for
sextant-mil, both based on it; report.html. Voltage and current are those of one connection: of a plate with 230/400 V,
8.7/5 A, delta has 230 V and 8.7 A. The rated point of the plate is that of the circuit; what else the plate leaves open
is assumed, and its range printed."""
NAME = re.compile(r"[A-Za-z0-9][\w-]*")


def parse_arguments(arguments: list[str]) -> argparse.Namespace:
    parser = parser_of("nameplate", __doc__, EXAMPLES)
    parser.add_argument("file", type=Path, nargs="?", metavar="FILE", help="the plate as TOML, keys as the options")
    plate = parser.add_argument_group("name plate")
    for entry in nameplate_plate.ENTRIES:
        unit = entry.unit.upper().replace("·", "_") or "N"
        plate.add_argument(entry.option, type=float, metavar=unit, help=entry.meaning)
    plate.add_argument("--connection", metavar="star|delta", help="as the machine is wired for voltage and current")
    drive = parser.add_argument_group("drive")
    drive.add_argument("--u-dc-v", type=float, metavar="V", help="voltage of the link (default: the rated, rectified)")
    drive.add_argument("--period-us", type=float, default=100, metavar="US", help="control period (default: 100)")
    drive.add_argument("--method", choices=METHODS, default="foc", help="control.controller (default: foc)")
    drive.add_argument(
        "--overload", type=float, default=OVERLOAD, metavar="N", help=f"torque limit by rated torque ({OVERLOAD:g})"
    )
    parser.add_argument("--name", metavar="NAME", help='of the machine (default: the file\'s, or "motor")')
    parser.add_argument("--out", type=Path, metavar="DIR", help="default: out/nameplate/NAME")
    options = parser.parse_args(arguments)
    options.name = options.name or (options.file.stem if options.file else "motor")
    for option, value, low, high in (
        ("--u-dc-v", options.u_dc_v, 1, 1e4),
        ("--period-us", options.period_us, 1, 1e5),
        ("--overload", options.overload, 1, 10),
    ):
        if value is not None and not low <= value <= high:
            parser.error(f"{option}: expected a number from {low:g} to {high:g}, got {value:g}")
    return options


def plate_of(options: argparse.Namespace) -> nameplate_plate.NamePlate:
    """The file's entries, and above them those of the command line."""
    given = nameplate_plate.read_file(options.file) if options.file else {}
    named = {key: getattr(options, key) for key in (*nameplate_plate.BY_KEY, "connection")}
    return nameplate_plate.checked(given | {key: value for key, value in named.items() if value is not None})


def main(arguments: list[str]) -> int:
    options = parse_arguments(arguments)
    if not NAME.fullmatch(options.name) or options.name in ("drive", "ecu", "half_speed"):
        raise UserError(
            f'the name "{options.name}" cannot be that of the machine\'s file: give --name with letters, digits, _ and '
            "-, and none of drive, ecu, half_speed."
        )
    of = variants(plate_of(options))
    limits = limits_of(of, options.period_us, options.u_dc_v, options.overload)
    directory = options.out or OUT / "nameplate" / options.name
    directory.mkdir(parents=True, exist_ok=True)
    files = nameplate_files.write(directory, options.name, of, limits, options.method, options.period_us)
    files.append(nameplate_page.write(directory, options.name, of, limits))
    print(report(of, limits))
    for file in files:
        print(file)
    return 0


if __name__ == "__main__":
    run("nameplate", main)
