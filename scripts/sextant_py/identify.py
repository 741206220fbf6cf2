"""Measures inverter, machine and inertia through the drive's gates, and writes what the drive uses."""

import argparse
import math
from dataclasses import replace
from pathlib import Path

from . import identify_impedance, identify_iron, identify_saturated_tones, identify_saturation, mil_program
from .errors import run
from .identify_files import Results, report, told, write_files
from .identify_fit import Setup, fit
from .identify_inertia import Inertia, check_turning
from .identify_live import ECU, live_plant
from .identify_machine import inertia_of
from .identify_no_load import NoLoad
from .identify_picture import write_picture
from .identify_run import (
    CONTROL,
    MilPlant,
    Plant,
    check_room,
    check_shaft,
    configuration_of,
    given_words,
    measure_levels,
    measure_tones,
    plant_of,
    settled_by,
)
from .identify_shaft import (
    INERTIA,
    INERTIA_SPEED,
    NO_LOAD,
    NO_LOAD_SPEED,
    measure_inertia,
    measure_no_load,
    shaft_course,
    turning,
)
from .paths import OUT
from .program_arguments import parser_of
from .sweep_file import Settings

EXAMPLES = """examples:
  scripts/identify configs/ecu_foc.toml
  scripts/identify my_drive.toml --out out/mine       a file of sextant-ecu or sextant-mil
  scripts/identify my_drive.toml --only dead_time     dead time and stator resistance alone
  scripts/identify my_drive.toml --only dead_time,impedance,no_load,inertia
  scripts/identify my_drive.toml --limit-a 8          with less current than magnetising takes
  scripts/identify my_drive.toml --threshold-v 1.1    the voltage of a switch is known
  scripts/identify my_drive.toml --set plant.inverter.dead_time_us=2
  scripts/identify my_ecu.toml --live                 the live drive of sextant-ecu, with the power stage of the file
  scripts/identify my_ecu.toml --virtual-time         the same without bus and clock, to try it
  sextant-mil my_scenario.toml --set drive.inverter=DIR/inverter.toml --set control.machine_estimate=DIR/machine.toml

Without torque, on a shaft that stands still, the drive leads a current along phase a:
  dead_time   through direct levels of both signs, which tell dead time and stator resistance
  impedance   as sines of several frequencies above a direct current, which tell R_s, leakage inductance, rotor
              resistance and magnetising inductance
On a shaft that is free to turn, and only if it is named, field-oriented control by what was found before leads
  no_load     the shaft to half of the base speed and lets it coast, five times with rising flux, which tells the
              magnetising inductance at the whole flux and how the iron saturates up to it; needs impedance
  inertia     a torque up, down, down and up again, to a quarter of the base speed in both directions; with no_load it
              tells the iron loss too, by which the coasting shaft slows down the more, the more flux there is
With --live this program starts sextant-ecu with the file, once for each course, and commands it over CAN. A current
flows from the enable on; Ctrl-C disables the drive, which turns the gates off, and so do its protections and a command
that does not come; a shaft that turns coasts then, and behind a whole course the drive brakes it. Files of DIR that end
in _cycles.h5 have every control period, for sextant-ecu --replay.
DIR/inverter.toml gets the dead time and what may be wrong of the voltage, DIR/machine.toml the machine, DIR/iron.toml
the resistance of the iron loss, to be copied into [drive] or to be the base of a drive's file,
DIR/identify.png a panel of each. Files of a drive take them in by [drive] inverter = "inverter.toml" and
[control] machine_estimate = "machine.toml".

Dead time and threshold voltage are one number at one link voltage: without --threshold-v the dead time stands for both.
The resistance contains cables, and the slope resistance of the switches beyond drive.inverter.slope_ohm."""
DEAD_TIME, IMPEDANCE = "dead_time", "impedance"
STANDSTILL = (DEAD_TIME, IMPEDANCE)
PARTS = (*STANDSTILL, NO_LOAD, INERTIA)
FAR = 1.5  # ratio of the inertia to that of the course, beyond which a course by it follows


def parts(text: str) -> list[str]:
    chosen = text.split(",")
    for name in chosen:
        if name not in PARTS:
            raise argparse.ArgumentTypeError(f'there is no "{name}"; they are {", ".join(PARTS)}')
    return chosen


def parse_arguments(arguments: list[str]) -> argparse.Namespace:
    parser = parser_of(
        "identify",
        "Measures inverter, machine and inertia through the drive's gates, and writes what the drive uses.",
        EXAMPLES,
    )
    parser.add_argument("file", type=Path, metavar="CONFIG", help="a file of sextant-ecu or sextant-mil")
    parser.add_argument(
        "--only",
        type=parts,
        default=list(STANDSTILL),
        metavar="A,B",
        help=f"of {', '.join(PARTS)}; default: {','.join(STANDSTILL)}",
    )
    parser.add_argument("--out", type=Path, metavar="DIR", help="default: out/identify/NAME")
    parser.add_argument("--limit-a", type=float, metavar="A", help=f"limit of the current ({CONTROL}current_limit_a)")
    parser.add_argument(
        "--threshold-v", type=float, metavar="V", help="known voltage of a switch (drive.inverter.threshold_v)"
    )
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="as sextant-mil takes it")
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--live", action="store_true", help="the drive of sextant-ecu, on its bus and clock")
    where.add_argument("--virtual-time", action="store_true", help="the drive of sextant-ecu, in virtual time")
    parser.add_argument("--can", metavar="BUS", help="with --live: another bus than that of the file")
    parser.add_argument("--ecu", type=Path, metavar="PATH", help=f"{ECU} to use (default: that of build/release)")
    parser.add_argument("--mil", type=Path, metavar="PATH", help="sextant-mil to use (default: that of build/release)")
    options = parser.parse_args(arguments)
    if NO_LOAD in options.only and IMPEDANCE not in options.only:
        parser.error(f"--only: {NO_LOAD} needs {IMPEDANCE}, which tells the leakage inductance")
    check_place(parser, options)
    if options.threshold_v is not None and not (math.isfinite(options.threshold_v) and options.threshold_v >= 0):
        parser.error("--threshold-v: expected a voltage from 0 on")
    if options.limit_a is not None and not (math.isfinite(options.limit_a) and options.limit_a > 0):
        parser.error("--limit-a: expected a current above 0")
    return options


def check_place(parser: argparse.ArgumentParser, options: argparse.Namespace) -> None:
    """What the live drive measures, and which options are its own."""
    if options.live or options.virtual_time:
        if options.mil:
            parser.error("--mil: --live and --virtual-time run sextant-ecu; --ecu names it")
    elif options.ecu:
        parser.error("--ecu needs --live or --virtual-time")
    if options.can and not options.live:
        parser.error("--can needs --live")


def settings_of(options: argparse.Namespace) -> Settings:
    settings: Settings = {"control.controller": "commissioning", "drive.magnetise_first": False}
    if options.limit_a is not None:
        settings[f"{CONTROL}current_limit_a"] = options.limit_a
    return settings


def plants_of(file: Path, mil: Path, directory: Path, options: argparse.Namespace) -> tuple[MilPlant, MilPlant]:
    """The drive of a file at standstill, and that with a free shaft. A load torque is that of the latter, an imposed
    speed that of the former."""
    settings = settings_of(options) | {"plant.integrator": "fixed"}
    unheld = [text for text in options.set if not text.startswith(("load.speed_rad_s", "load.kind"))]
    free = plant_of(file, mil, directory, settings, unheld)
    check_shaft(free.configuration)
    at_rest = [text for text in options.set if not text.startswith("load.torque_nm")]
    held: Settings = {"load.kind": "imposed_speed", "load.speed_rad_s.value": 0}
    given = given_words(settings | held, at_rest)
    return replace(free, given=given, configuration=configuration_of(mil, free.file, given)), free


def setup_of(plant: Plant, options: argparse.Namespace) -> Setup:
    configuration = plant.configuration
    return Setup(
        plant.timing.period_s,
        plant.estimate.terminals.leakage,
        configuration["drive.inverter.threshold_v"] if options.threshold_v is None else options.threshold_v,
        configuration["drive.inverter.slope_ohm"],
    )


def identified(file: Path, mil: Path, directory: Path, options: argparse.Namespace) -> Results:
    """For the drive of a file, by sextant-mil."""
    plant, free = plants_of(file, mil, directory, options)
    return measured(plant, free, options)


def identified_live(file: Path, directory: Path, options: argparse.Namespace) -> Results:
    """For the drive of a file, by sextant-ecu."""
    ecu = mil_program.find(options.ecu, ECU)
    settings = settings_of(options) | ({"can.bus": options.can} if options.can else {})
    plant = live_plant(file, ecu, directory, settings, options.set, options.virtual_time)
    check_shaft(plant.configuration)
    return measured(plant, plant, options)


def measured(plant: Plant, free: Plant, options: argparse.Namespace) -> Results:
    """By the plant whose shaft rests and that whose shaft is free, what is chosen."""
    results = at_standstill(plant, options)
    if NO_LOAD in options.only:
        results = with_no_load(results, magnetising_at_no_load(free, results))
    if INERTIA in options.only:
        results = replace(results, inertia=inertia_of_shaft(free, results))
    return with_iron_loss(results, free.configuration["machine.poles"] / 2)


def at_standstill(plant: Plant, options: argparse.Namespace) -> Results:
    """The sines come first: they need no settled rotor flux, and tell its time constant, for which the levels wait. The
    levels tell R_s better, which the sines take as known then."""
    check_room(plant.configuration)
    setup, estimate = setup_of(plant, options), plant.estimate
    levels, found, impedance = [], None, None
    if IMPEDANCE in options.only:
        blocks = measure_tones(plant)
        impedance = identify_impedance.fit(blocks, plant.timing, estimate.terminals, setup.slope_ohm)
        setup = replace(setup, leakage_h=impedance.machine.leakage)
    if DEAD_TIME in options.only:
        levels = measure_levels(settled_by(plant, impedance.machine.tau_r) if impedance else plant)
        found = fit(levels, setup)
    if found and impedance:
        known = (found.r_s_ohm, found.r_s_sigma_ohm)
        impedance = identify_impedance.fit(blocks, plant.timing, impedance.machine, setup.slope_ohm, known)
    return Results(setup, levels, found, impedance, estimate.l_ls / estimate.l_lr)


def magnetising_at_no_load(plant: Plant, results: Results) -> list[NoLoad]:
    """At rising fluxes. The drive keeps L_m of its estimate: where iron saturates the sines show less than the flux
    needs."""
    known = {key: value for key, value in told(results).items() if not key.endswith(".l_m_h")}
    course, speed = shaft_course(plant, plant.estimate.terminals, inertia_of(plant.configuration), NO_LOAD_SPEED)
    settings = turning(plant, NO_LOAD, known)
    ready = plant.magnetising(NO_LOAD, settings)
    points = [measure_no_load(ready, settings, course, share) for share in identify_saturation.SHARES]
    check_turning(min(abs(point.speed) for point in points), speed)
    return points


def with_no_load(results: Results, points: list[NoLoad]) -> Results:
    """The tones on the curve of the iron, where it saturates."""
    whole, curve = points[-1], identify_saturation.fit(points)
    levels = results.found
    known = (levels.r_s_ohm, levels.r_s_sigma_ohm) if levels else None
    saturated = identify_saturated_tones.fit(results.impedance, whole, curve, known) if curve else None
    return replace(results, fluxes=points, saturation=curve, saturated=saturated)


def with_iron_loss(results: Results, pole_pairs: float) -> Results:
    """Where the shaft has coasted and its inertia is known."""
    if not (results.fluxes and results.inertia):
        return results
    return replace(results, iron=identify_iron.fit(results.fluxes, results.inertia, pole_pairs))


def inertia_of_shaft(plant: Plant, results: Results) -> Inertia:
    """By a second course where the first one was far from the speed that is due."""
    inertia = inertia_of(plant.configuration)
    machine = results.machine or plant.estimate.terminals
    settings = turning(plant, INERTIA, told(results))
    ready = plant.magnetising(INERTIA, settings)
    for _ in range(2):
        course, speed = shaft_course(plant, machine, inertia, INERTIA_SPEED)
        found = measure_inertia(ready, settings, course)
        check_turning(found.fastest, speed)
        if max(found.inertia / inertia, inertia / found.inertia) < FAR:
            break
        inertia = found.inertia
    return found


def main(arguments: list[str]) -> int:
    options = parse_arguments(arguments)
    mil = None if options.live or options.virtual_time else mil_program.find(options.mil)
    directory = options.out or OUT / "identify" / options.file.stem
    directory.mkdir(parents=True, exist_ok=True)
    if mil:
        results = identified(options.file, mil, directory, options)
    else:
        results = identified_live(options.file, directory, options)
    files = [*write_files(directory, options.file, results), write_picture(directory, results)]
    print(report(results))
    for file in files:
        print(file)
    return 0


if __name__ == "__main__":
    run("identify", main)
