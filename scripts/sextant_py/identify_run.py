"""Runs the courses of `identify` with sextant-mil, and reads what those of the control method commissioning publish.
identify_live.py runs them with sextant-ecu."""

import math
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Self

import numpy as np

from . import printed_configuration
from .drive_file import machine_of, of_the_drive, read
from .errors import EndedError, UserError
from .identify_fit import Level
from .identify_impedance import Block, Timing
from .identify_machine import TCircuit, estimate_of
from .reports import FOLLOWING_STATES
from .short_run import known_keys, scenario_text
from .sweep_file import Settings
from .sweep_point import clean_reason, read_summary
from .sweep_reader import flat, set_words
from .telemetry_contract import enumerators

CONTROL = "control.commissioning."
LEVELS, TONES = "levels", "tones"
LEVEL_CHANNELS = ("level_current_a", "level_voltage_v", "level_link_v", "level_scatter_a", "level_drift_v")
TONE_CHANNELS = ("tone_periods", "tone_sine_a", "tone_cosine_a", "tone_sine_v", "tone_cosine_v")
CHANNELS = ("level", "level_speed_rad_s", *LEVEL_CHANNELS, *TONE_CHANNELS)
# Dead time by the control period that an unknown inverter has at most: two standard deviations of what the protections
# are told that they do not know of the voltage.
MOST_DEAD_TIME = 0.1
LOWEST_SHARE = 0.2 * 0.95  # of the current limit, at the lowest level
END = "end_s"  # of a level, to a row of the trace [s]
ROW = 2e-3  # what the time of a row leaves open [s]
STEPS = 4  # of the converter, and standard deviations of noise, that the currents of phases b and c have at least
# Electrical angle by which a shaft may turn within the rotor's time constant: the rotor's branch of the impedance
# changes by its square. [rad]
STANDSTILL = 0.1


Steps = Sequence[tuple[float, float]]  # torque [N·m] from a time [s] on


@dataclass(frozen=True)
class Plant:
    """The drive of a file with its plant: what is set beside the file, and the configuration in force."""

    given: list[str]  # words for the program that runs it
    configuration: Settings
    file: Path  # that the program reads

    def run(self, course: str, duration_s: float, settings: Settings) -> Path:
        """Runs a course without torque for so long. A trace with CHANNELS, a row about every millisecond."""
        raise NotImplementedError

    def magnetising(self, course: str, settings: Settings) -> Self:
        """The plant that knows what `follow` needs of a drive with these settings that builds up its flux."""
        return self

    def follow(
        self, course: str, torque: Steps, duration_s: float, settings: Settings, columns: Sequence[str]
    ) -> tuple[np.ndarray, list[np.ndarray]]:
        """Runs a course of torque for so long, from when the drive has flux; times from then on [s], and columns of
        the drive's telemetry, a row about every millisecond."""
        raise NotImplementedError

    def sets(self, key: str) -> bool:
        """Whether file or user set a key, which else has its default."""
        return any(word.startswith(f"{key}=") for word in self.given) or key in read(self.file)

    @property
    def estimate(self) -> TCircuit:
        return estimate_of(self.configuration)

    @property
    def timing(self) -> Timing:
        return Timing(
            1e-6 * self.configuration["drive.period_us"],
            self.configuration["drive.actuation_delay_periods"],
            1e-6 * self.configuration.get("drive.sampling_lead_us", 0.0),
        )

    @property
    def slowest_shaft(self) -> float:
        """Speed from which on the shaft counts as turning. [rad/s]"""
        pole_pairs = self.configuration["machine.poles"] / 2
        return STANDSTILL / self.estimate.terminals.tau_r / pole_pairs


@dataclass(frozen=True)
class MilPlant(Plant):
    """As a scenario of sextant-mil."""

    mil: Path
    flux_s: float = 0.0  # when it has flux

    def run(self, course: str, duration_s: float, settings: Settings) -> Path:
        return self._traced(course, duration_s, settings, [f"control/{name}" for name in CHANNELS])

    def magnetising(self, course: str, settings: Settings) -> Self:
        """By a run without torque. A drive that waits at standstill loses the direction of its flux, the more the
        longer, by what it does not know of the inverter."""
        timeout_s = 1e-3 * self.configuration["drive.magnetise_timeout_ms"]
        at_zero = replace(self, flux_s=0.0)
        time, (state,) = at_zero.follow(course, [(timeout_s, 0.0)], timeout_s, settings, ("state",))
        has_flux = np.isin(state, following_states())
        return replace(self, flux_s=float(time[np.argmax(has_flux)] if has_flux.any() else timeout_s))

    def follow(
        self, course: str, torque: Steps, duration_s: float, settings: Settings, columns: Sequence[str]
    ) -> tuple[np.ndarray, list[np.ndarray]]:
        own: Settings = {
            "load.kind": "torque",
            "profile.torque_nm.shape": "steps",
            "profile.torque_nm.points": [[0.0, 0.0], *([round(self.flux_s + t, 6), value] for t, value in torque)],
        }
        time, found = read_columns(
            self._traced(course, self.flux_s + duration_s, settings | own, list(columns)), columns
        )
        return time - self.flux_s, found

    def _traced(self, course: str, duration_s: float, settings: Settings, signals: list[str]) -> Path:
        period_us = self.configuration["drive.period_us"]
        own: Settings = {
            "duration_s": round(duration_s, 6),
            "trace.interval_us": period_us * max(1, round(1e3 / period_us)),
            "trace.signals": signals,
        }
        out = self.file.parent / course
        command = [str(self.mil), str(self.file), *self.given, *set_words(settings | own), "--out", str(out)]
        shown = sys.stderr.isatty()  # sextant-mil shows how far it is
        if shown:
            print(f"identify: {course}, {duration_s:.3g} s", file=sys.stderr)
        done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=None if shown else subprocess.PIPE, text=True)
        summary = read_summary(out)
        if summary is None:
            raise EndedError(f"sextant-mil ended with status {done.returncode}: {clean_reason(done.stderr or '')}")
        if summary["faults"]:
            first = summary["faults"][0]
            raise tripped(first["fault"], course, f" at {first['t_s']:.3f} s")
        return out / "trace.h5"


def scenario_of(file: Path, mil: Path, directory: Path) -> Path:
    found = read(file)
    given = {f"machine.{key}": value for key, value in machine_of(found, file).items()}
    kept, _ = of_the_drive(found, known_keys(mil, directory, given), file)
    scenario = directory / "identify.toml"
    scenario.write_text(scenario_text(given | kept, "identify"), encoding="utf-8")
    return scenario


def configuration_of(program: Path, file: Path, given: list[str]) -> Settings:
    """In force."""
    return flat(printed_configuration.tables_of(program, file, given, "the drive"))


def given_words(settings: Settings, own: list[str]) -> list[str]:
    """For sextant-mil: settings, and above them what the user sets."""
    return [*set_words(settings), *(word for text in own for word in ("--set", text))]


def plant_of(file: Path, mil: Path, directory: Path, settings: Settings, own: list[str]) -> MilPlant:
    """The drive of a file, with these settings and what the user sets."""
    scenario = scenario_of(file, mil, directory)
    given = given_words(settings, own)
    return MilPlant(given, configuration_of(mil, scenario, given), scenario, mil)


def unknown_voltage(configuration: Settings) -> Settings:
    """What the drive does not know of its inverter yet, at least: the fundamental of a square wave of what such a dead
    time takes from a leg."""
    key = "drive.inverter.voltage_error_v"
    prior = 4 / math.pi * MOST_DEAD_TIME / 2 * configuration["plant.u_dc_v"]
    return {key: round(max(prior, configuration[key]), 3)}


def check_shaft(configuration: Settings) -> None:
    """Refuses a load behind a driveline, beside which the motor's shaft cannot be held."""
    key = "plant.driveline.inertia_kg_m2"
    if configuration[key]:
        raise UserError(
            f"{key} is {configuration[key]:g}: the measurement holds the motor's shaft, and its inertia is that of one "
            f"rigid shaft; take the load off with --set {key}=0."
        )


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


def _times(configuration: Settings) -> tuple[float, float, float]:
    """Settling, holding and control period. [s]"""
    settle, hold = (1e-3 * configuration[f"{CONTROL}{key}_ms"] for key in ("settle", "hold"))
    return settle, hold, 1e-6 * configuration["drive.period_us"]


def duration_of_levels(configuration: Settings) -> float:
    """Of all levels and of the ramps between them. [s]"""
    settle, hold, period = _times(configuration)
    levels = 2 * configuration[f"{CONTROL}levels"]
    ramps = 0.3 * settle  # up to the highest level and to its opposite: a tenth for each such current
    periods = (3 * levels + 10) * period  # rounded up
    return levels * (settle + hold) + ramps + periods + 0.003


def duration_of_tones(configuration: Settings) -> float:
    """Of all tones, and of the direct current before. [s]"""
    settle, hold, period = _times(configuration)
    count, blocks = configuration[f"{CONTROL}tones"], configuration[f"{CONTROL}blocks"]
    lowest, highest = (configuration[f"{CONTROL}{end}_tone_hz"] for end in ("lowest", "highest"))
    total = 1.2 * settle
    for tone in range(count):
        cycle = 1 / (lowest * (highest / lowest) ** (tone / (count - 1))) + period
        total += (math.ceil(settle / cycle + 0.01) + 1 + blocks * (math.ceil(hold / cycle + 0.01) + 1)) * cycle
    return total + 10 * period + 0.003


def tripped(fault: str, course: str, when: str = "") -> UserError:
    return UserError(
        f"the drive tripped with {fault}{when}, before the course of {course} was over; docs/commissioning.md says "
        "what may be wrong."
    )


def measure(plant: Plant, course: str) -> list[dict[str, float]]:
    """The channels behind each level of a course."""
    configuration = plant.configuration
    has_tones = course == TONES
    length = duration_of_tones(configuration) if has_tones else duration_of_levels(configuration)
    settings: Settings = unknown_voltage(configuration) | {f"{CONTROL}course": course}
    if has_tones:
        count = configuration[f"{CONTROL}tones"] * configuration[f"{CONTROL}blocks"]
    else:
        count = 2 * configuration[f"{CONTROL}levels"]
    trace = plant.run(course, length, settings)
    rows = undisturbed(read_rows(trace, count), gaps_of(trace), course, configuration)
    fastest = max(abs(row["level_speed_rad_s"]) for row in rows)
    if fastest > plant.slowest_shaft:
        raise EndedError(
            f"the shaft turns at {fastest:.3g} rad/s while the {course} are measured, which need one that stands still "
            f"(below {plant.slowest_shaft:.2g} rad/s): hold it, or let it come to rest."
        )
    return rows


def settled_by(plant: Plant, tau_r: float) -> Plant:
    """The plant whose levels settle for seven of these time constants at least, unless the user sets the time. [s]"""
    key = f"{CONTROL}settle_ms"
    needed = round(7e3 * tau_r, 3)
    if plant.configuration[key] >= needed or any(word.startswith(f"{key}=") for word in plant.given):
        return plant
    settle: Settings = {key: needed}
    return replace(plant, given=[*plant.given, *set_words(settle)], configuration=plant.configuration | settle)


def measure_levels(plant: Plant) -> list[Level]:
    return [Level(*(row[name] for name in LEVEL_CHANNELS)) for row in measure(plant, LEVELS)]


def measure_tones(plant: Plant) -> list[Block]:
    return [
        Block(
            round(row["tone_periods"]),
            complex(row["tone_sine_a"], row["tone_cosine_a"]),
            complex(row["tone_sine_v"], row["tone_cosine_v"]),
            row["level_current_a"],
            row["level_link_v"],
        )
        for row in measure(plant, TONES)
    ]


def following_states() -> list[int]:
    """Of the telemetry, in which the torque answers to the command."""
    names = enumerators("DriveStateKind")
    return [names.index(name) for name in FOLLOWING_STATES]


def read_columns(file: Path, columns: Sequence[str]) -> tuple[np.ndarray, list[np.ndarray]]:
    """Times [s] and columns of a trace."""
    import h5py

    with h5py.File(file) as trace:
        return 1e-9 * trace["t_ns"][()], [trace[column][()].astype(float) for column in columns]


def read_rows(file: Path, count: int) -> list[dict[str, float]]:
    """The channels of a trace behind each of so many levels, in order."""
    time, found = read_columns(file, [f"control/{name}" for name in CHANNELS])
    values = dict(zip(CHANNELS, found, strict=True))
    over = values["level"]
    if not over.size or over.max() < count:
        raise EndedError(f"{file}: the run ended before all {count} levels were over; read what the drive reports.")
    firsts = [int(np.argmax(over >= number)) for number in range(1, count + 1)]
    return [{name: float(values[name][row]) for name in CHANNELS} | {END: time[row]} for row in firsts]


def gaps_of(file: Path) -> np.ndarray:
    """Beginnings of gaps in a trace: control periods that the drive missed, or that were not recorded. [s]"""
    import h5py

    with h5py.File(file) as trace:
        time = trace["t_ns"][()]
        interval, period = (int(trace.attrs[f"{name}_ns"]) for name in ("interval", "control_period"))
    return 1e-9 * time[:-1][2 * np.diff(time) > 2 * interval + period]


def undisturbed(
    rows: list[dict[str, float]], gaps: np.ndarray, course: str, configuration: Settings
) -> list[dict[str, float]]:
    """The levels that settled and were held without a gap, through which the power stage holds the last pattern or
    turns the gates off, and behind which the rotor settles anew."""
    settle, hold, period = _times(configuration)
    kept = []
    for row in rows:
        cycle = row["tone_periods"] * period
        held = math.ceil(hold / cycle) * cycle if cycle else hold
        begin = row[END] - held - settle - ROW
        if not np.any((gaps >= begin) & (gaps <= row[END])):
            kept.append(row)
    if 2 * len(kept) < len(rows):
        raise EndedError(
            f"the drive missed control periods in {len(rows) - len(kept)} of {len(rows)} levels of the course of "
            f"{course}; docs/realtime.md says what to change, and a longer drive.period_us takes less time, where a "
            "[control.dtc] of the file allows it."
        )
    return kept
