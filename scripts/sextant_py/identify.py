"""Measures inverter and stator of a machine at standstill through the drive's gates, and writes what the drive uses."""

import argparse
import math
import subprocess
import sys
from pathlib import Path

from . import mil_program, torque_map_file
from .errors import UserError, run
from .identify_files import report, write_files, write_picture
from .identify_fit import Found, Level, Setup, fit
from .paths import OUT
from .sweep_file import Settings
from .sweep_point import clean_reason, read_summary
from .torque_map_drive import SHORT, Drive, summary_of, words

EXAMPLES = """examples:
  scripts/identify configs/ecu_foc.toml
  scripts/identify my_drive.toml --out out/mine       a file of sextant-ecu or sextant-mil
  scripts/identify my_drive.toml --limit-a 8          with less current than magnetising takes
  scripts/identify my_drive.toml --threshold-v 1.1    the voltage of a switch is known
  scripts/identify my_drive.toml --set plant.inverter.dead_time_us=2
  sextant-mil my_scenario.toml --set drive.inverter=DIR/inverter.toml --set control.machine_estimate=DIR/machine.toml

The drive leads a direct current along phase a through levels of both signs, without torque, on a shaft that stands
still. DIR/inverter.toml gets the dead time and what may be wrong of the voltage, DIR/machine.toml the stator
resistance, DIR/identify.png the levels and their fit. Files of a drive take them in by
[drive] inverter = "inverter.toml" and [control] machine_estimate = "machine.toml".

Dead time and threshold voltage are one number at one link voltage: without --threshold-v the dead time stands for both.
The resistance contains cables, and the slope resistance of the switches beyond drive.inverter.slope_ohm."""
CONTROL = "control.commissioning."
CHANNELS = ("level", "level_current_a", "level_voltage_v", "level_link_v", "level_scatter_a", "level_drift_v")
# Dead time by the control period that an unknown inverter has at most: two standard deviations of what the protections
# are told that they do not know of the voltage.
MOST_DEAD_TIME = 0.1
LOWEST_SHARE = 0.2 * 0.95  # of the current limit, at the lowest level
STEPS = 4  # of the converter, and standard deviations of noise, that the currents of phases b and c have at least


def parse_arguments(arguments: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="identify",
        description="Measures dead time and stator resistance at standstill, and writes what the drive uses.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("file", type=Path, metavar="CONFIG", help="a file of sextant-ecu or sextant-mil")
    parser.add_argument("--out", type=Path, metavar="DIR", help="default: out/identify/NAME")
    parser.add_argument("--limit-a", type=float, metavar="A", help=f"limit of the current ({CONTROL}current_limit_a)")
    parser.add_argument(
        "--threshold-v", type=float, metavar="V", help="known voltage of a switch (drive.inverter.threshold_v)"
    )
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="as sextant-mil takes it")
    parser.add_argument("--mil", type=Path, metavar="PATH", help="sextant-mil to use (default: that of build/release)")
    options = parser.parse_args(arguments)
    if options.threshold_v is not None and not (math.isfinite(options.threshold_v) and options.threshold_v >= 0):
        parser.error("--threshold-v: expected a voltage from 0 on")
    if options.limit_a is not None and not (math.isfinite(options.limit_a) and options.limit_a > 0):
        parser.error("--limit-a: expected a current above 0")
    return options


def settings_of(options: argparse.Namespace) -> list[str]:
    """Words for sextant-mil: what the run is, then what the user sets."""
    run_keys: Settings = {
        "control.controller": "commissioning",
        "drive.magnetise_first": False,
        "load.kind": "imposed_speed",
        "load.speed_rad_s.value": 0,
        "plant.integrator": "fixed",
    }
    if options.limit_a is not None:
        run_keys[f"{CONTROL}current_limit_a"] = options.limit_a
    return [*words(run_keys), *(word for text in options.set for word in ("--set", text))]


def scenario_of(file: Path, mil: Path, directory: Path) -> Path:
    """The drive of the file as a scenario without torque."""
    found = torque_map_file.read(file)
    machine = {key.removeprefix("machine."): value for key, value in found.items() if key.startswith("machine.")}
    if not machine:
        raise UserError(f'{file} names no machine: [machine] with file = "…" or with its values is needed.')
    given = {f"machine.{key}": value for key, value in machine.items()}
    scenario = directory / "identify.toml"
    scenario.write_text(Drive("identify", given, machine, set()).scenario(), encoding="utf-8")
    known = set(summary_of(mil, scenario, SHORT)["configuration"])
    kept, _ = torque_map_file.of_the_drive(found, known, file)
    scenario.write_text(Drive("identify", given | kept, machine, known).scenario(), encoding="utf-8")
    return scenario


def configuration_of(mil: Path, scenario: Path, given: list[str]) -> Settings:
    """In force."""
    command = [str(mil), str(scenario), *given, *words(SHORT), "--no-trace", "--out", str(scenario.parent / "short")]
    done = subprocess.run(command, capture_output=True, text=True)
    found = read_summary(scenario.parent / "short")
    if done.returncode == 2 or found is None:
        raise UserError(f"sextant-mil refuses the drive: {clean_reason(done.stderr)}")
    return found["configuration"]


def unknown_voltage(configuration: Settings) -> Settings:
    """What the drive does not know of its inverter yet, at least: the fundamental of a square wave of what such a dead
    time takes from a leg."""
    key = "drive.inverter.voltage_error_v"
    prior = 4 / math.pi * MOST_DEAD_TIME / 2 * configuration["plant.u_dc_v"]
    return {key: round(max(prior, configuration[key]), 3)}


def leakage_of(configuration: Settings) -> float:
    """σL_s as the controller takes it. [H]"""

    def key(name: str) -> float | None:
        estimate = configuration.get(f"control.machine_estimate.{name}")
        return configuration.get(f"machine.{name}") if estimate is None else estimate

    def inductance(name: str) -> float:
        value = key(f"l_{name}_h")
        return key(f"x_{name}_ohm") / (2 * math.pi * key("reactance_frequency_hz")) if value is None else value

    l_m = inductance("m")
    return inductance("ls") + l_m - l_m**2 / (inductance("lr") + l_m)


def check_room(configuration: Settings) -> None:
    """Refuses levels that the converters of the currents do not resolve."""
    sensor = "plant.sensors.current."
    bits, span = configuration[f"{sensor}bits"], configuration[f"{sensor}range_a"]
    step = 2 * span / 2**bits if bits and span else 0.0
    needed = STEPS * (step + configuration[f"{sensor}noise_a"])
    limit = configuration[f"{CONTROL}current_limit_a"]
    lowest = LOWEST_SHARE * limit / 2
    if lowest < needed:
        raise UserError(
            f"{CONTROL}current_limit_a of {limit:g} A leaves {lowest:.3g} A in phases b and c at the lowest level, and "
            f"the current sensors, with steps of {step:.3g} A, need {needed:.3g} A: raise it to "
            f"{2 * needed / LOWEST_SHARE:.3g} A at least (--limit-a)."
        )


def duration_of(configuration: Settings) -> float:
    """Of all levels and of the ramps between them. [s]"""
    settle, hold = (1e-3 * configuration[f"{CONTROL}{key}_ms"] for key in ("settle", "hold"))
    levels = 2 * configuration[f"{CONTROL}levels"]
    ramps = 0.3 * settle  # up to the highest level and to its opposite: a tenth for each such current
    periods = (3 * levels + 10) * 1e-6 * configuration["drive.period_us"]  # rounded up
    return levels * (settle + hold) + ramps + periods + 0.003


def measure(mil: Path, scenario: Path, given: list[str], configuration: Settings) -> list[Level]:
    """Runs the levels."""
    period_us = configuration["drive.period_us"]
    length: Settings = unknown_voltage(configuration) | {
        "duration_s": round(duration_of(configuration), 6),
        "trace.interval_us": period_us * max(1, round(1000 / period_us)),
        "trace.signals": [f"control/{name}" for name in CHANNELS],
    }
    out = scenario.parent / "run"
    command = [str(mil), str(scenario), *given, *words(length), "--out", str(out)]
    shown = sys.stderr.isatty()  # sextant-mil shows how far it is
    done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=None if shown else subprocess.PIPE, text=True)
    summary = read_summary(out)
    if summary is None:
        raise UserError(f"sextant-mil ended with status {done.returncode}: {clean_reason(done.stderr or '')}")
    if summary["faults"]:
        first = summary["faults"][0]
        raise UserError(
            f"the drive tripped with {first['fault']} at {first['t_s']:.3f} s, before every level was measured; "
            "docs/commissioning.md says what may be wrong."
        )
    return read_levels(out / "trace.h5", 2 * configuration[f"{CONTROL}levels"])


def read_levels(file: Path, count: int) -> list[Level]:
    """So many levels of a trace, in order."""
    import h5py
    import numpy as np

    with h5py.File(file) as trace:
        values = {name: np.asarray(trace[f"control/{name}"]) for name in CHANNELS}
    over = values["level"]
    if not over.size or over[-1] < count:
        raise UserError(f"{file}: the run ended before all {count} levels were over; read what sextant-mil reports.")
    firsts = [int(np.argmax(over >= number)) for number in range(1, count + 1)]
    return [Level(*(float(values[name][row]) for name in CHANNELS[1:])) for row in firsts]


def identified(file: Path, mil: Path, directory: Path, options: argparse.Namespace) -> tuple[list[Level], Setup, Found]:
    """Levels, what was known and what was found, for the drive of a file."""
    scenario = scenario_of(file, mil, directory)
    given = settings_of(options)
    configuration = configuration_of(mil, scenario, given)
    check_room(configuration)
    setup = Setup(
        1e-6 * configuration["drive.period_us"],
        leakage_of(configuration),
        configuration["drive.inverter.threshold_v"] if options.threshold_v is None else options.threshold_v,
        configuration["drive.inverter.slope_ohm"],
    )
    levels = measure(mil, scenario, given, configuration)
    return levels, setup, fit(levels, setup)


def main(arguments: list[str]) -> int:
    options = parse_arguments(arguments)
    mil = mil_program.find(options.mil)
    directory = options.out or OUT / "identify" / options.file.stem
    directory.mkdir(parents=True, exist_ok=True)
    levels, setup, found = identified(options.file, mil, directory, options)
    inverter, machine = write_files(directory, options.file, found, setup)
    picture = write_picture(directory, levels, found, setup)
    print(report(levels, found, setup))
    for file in (inverter, machine, picture):
        print(file)
    return 0


if __name__ == "__main__":
    run("identify", main)
