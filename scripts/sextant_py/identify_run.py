"""Runs the courses of the control method commissioning with sextant-mil, and reads what they publish. identify_live.py
runs them with sextant-ecu."""

import math
import subprocess
import sys
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from .drive_file import machine_of, of_the_drive, read
from .errors import EndedError, UserError
from .identify_fit import Level
from .identify_impedance import Block, Timing
from .identify_inertia import Course, Inertia
from .identify_inertia import fit as fit_inertia
from .identify_machine import InverseGamma, TCircuit, estimate_of
from .identify_no_load import NoLoad, current_along
from .identify_no_load import fit as fit_no_load
from .short_run import SHORT, known_keys, scenario_text
from .sweep_file import Settings
from .sweep_point import clean_reason, read_summary
from .sweep_reader import set_words
from .telemetry_contract import enumerators

CONTROL = "control.commissioning."
LEVELS, TONES, NO_LOAD, INERTIA = "levels", "tones", "no_load", "inertia"
LEVEL_CHANNELS = ("level_current_a", "level_voltage_v", "level_link_v", "level_scatter_a", "level_drift_v")
TONE_CHANNELS = ("tone_periods", "tone_sine_a", "tone_cosine_a", "tone_sine_v", "tone_cosine_v")
CHANNELS = ("level", "level_speed_rad_s", *LEVEL_CHANNELS, *TONE_CHANNELS)
# Dead time by the control period that an unknown inverter has at most: two standard deviations of what the protections
# are told that they do not know of the voltage.
MOST_DEAD_TIME = 0.1
# Of the base speed. Without load the flux is measured by its voltage, beside which that of the inverter is to be small.
INERTIA_SPEED, NO_LOAD_SPEED = 0.25, 0.5
DRIVE_LIMIT = 1.55  # by the current of the flux, that the drive's limit has at least
SETTLES = 3  # time constants of the rotor until flux and current belong together
FALLS = 18  # the same until the flux has fallen, which takes six of three
LOWEST_SHARE = 0.2 * 0.95  # of the current limit, at the lowest level
END = "end_s"  # of a level, to a row of the trace [s]
ROW = 2e-3  # what the time of a row leaves open [s]
STEPS = 4  # of the converter, and standard deviations of noise, that the currents of phases b and c have at least
# Electrical angle by which a shaft may turn within the rotor's time constant: the rotor's branch of the impedance
# changes by its square. [rad]
STANDSTILL = 0.1


@dataclass(frozen=True)
class Plant:
    """The drive of a file with its plant: what is set beside the file, and the configuration in force."""

    given: list[str]  # words for the program that runs it
    configuration: Settings

    def run(self, course: str, duration_s: float, settings: Settings) -> Path:
        """Runs a course for so long. A trace with CHANNELS, a row about every millisecond."""
        raise NotImplementedError

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
    scenario: Path

    def run(self, course: str, duration_s: float, settings: Settings) -> Path:
        own: Settings = {
            "duration_s": round(duration_s, 6),
            "trace.interval_us": _interval(self, 1e-3),
            "trace.signals": [f"control/{name}" for name in CHANNELS],
        }
        return _run(self, course, settings | own)


def scenario_of(file: Path, mil: Path, directory: Path) -> Path:
    """The drive of the file as a scenario without torque."""
    found = read(file)
    given = {f"machine.{key}": value for key, value in machine_of(found, file).items()}
    kept, _ = of_the_drive(found, known_keys(mil, directory, given), file)
    scenario = directory / "identify.toml"
    scenario.write_text(scenario_text(given | kept, "identify"), encoding="utf-8")
    return scenario


def configuration_of(mil: Path, scenario: Path, given: list[str]) -> Settings:
    """In force."""
    out = scenario.parent / "short"
    command = [str(mil), str(scenario), *given, *set_words(SHORT), "--no-trace", "--out", str(out)]
    done = subprocess.run(command, capture_output=True, text=True)
    found = read_summary(out)
    if done.returncode == 2 or found is None:
        raise UserError(f"sextant-mil refuses the drive: {clean_reason(done.stderr)}")
    return found["configuration"]


def given_words(settings: Settings, own: list[str]) -> list[str]:
    """For sextant-mil: settings, and above them what the user sets."""
    return [*set_words(settings), *(word for text in own for word in ("--set", text))]


def plant_of(file: Path, mil: Path, directory: Path, settings: Settings, own: list[str]) -> MilPlant:
    """The drive of a file, with these settings and what the user sets."""
    scenario = scenario_of(file, mil, directory)
    given = given_words(settings, own)
    return MilPlant(given, configuration_of(mil, scenario, given), mil, scenario)


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


def is_bounded(plant: Plant) -> bool:
    """Whether file or user set the limit of the current, which else follows from the estimate."""
    key = f"{CONTROL}current_limit_a"
    return any(word.startswith(f"{key}=") for word in plant.given) or f"{key} = " in plant.scenario.read_text("utf-8")


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


def _run(plant: MilPlant, course: str, settings: Settings) -> Path:
    """The trace of a course."""
    out = plant.scenario.parent / course
    command = [str(plant.mil), str(plant.scenario), *plant.given, *set_words(settings), "--out", str(out)]
    shown = sys.stderr.isatty()  # sextant-mil shows how far it is
    if shown:
        print(f"identify: {course}, {settings['duration_s']:.3g} s", file=sys.stderr)
    done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=None if shown else subprocess.PIPE, text=True)
    summary = read_summary(out)
    if summary is None:
        raise EndedError(f"sextant-mil ended with status {done.returncode}: {clean_reason(done.stderr or '')}")
    if summary["faults"]:
        first = summary["faults"][0]
        raise tripped(first["fault"], course, f" at {first['t_s']:.3f} s")
    return out / "trace.h5"


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


def read_rows(file: Path, count: int) -> list[dict[str, float]]:
    """The channels of a trace behind each of so many levels, in order."""
    import h5py

    with h5py.File(file) as trace:
        values = {name: np.asarray(trace[f"control/{name}"]) for name in CHANNELS}
        time = trace["t_ns"][()]
    over = values["level"]
    if not over.size or over.max() < count:
        raise EndedError(f"{file}: the run ended before all {count} levels were over; read what the drive reports.")
    firsts = [int(np.argmax(over >= number)) for number in range(1, count + 1)]
    return [{name: float(values[name][row]) for name in CHANNELS} | {END: 1e-9 * time[row]} for row in firsts]


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


def magnetised_s(plant: MilPlant, course: str, told: Settings) -> float:
    """When the drive of a course that is told this has flux, with some time to settle. A drive that waits at standstill
    loses the direction of its flux, the more the longer, by what it does not know of the inverter. [s]"""
    timeout_s = 1e-3 * plant.configuration["drive.magnetise_timeout_ms"]
    settings = told | {
        "profile.torque_nm.points": [[0.0, 0.0], [round(timeout_s, 6), 0.0]],
        "duration_s": round(timeout_s, 6),
        "trace.interval_us": _interval(plant, 1e-3),
    }
    time, state = _shaft_run(plant, course, settings, ("state",))
    has_flux = state == enumerators("DriveStateKind").index("TORQUE")
    return 0.1 + float(time[np.argmax(has_flux)] if has_flux.any() else timeout_s)


def shaft_course(
    plant: Plant, machine: InverseGamma, inertia: float, share: float, begin_s: float
) -> tuple[Course, float]:
    """The course by which such an inertia reaches this share of the base speed, and that speed [rad/s].

    Its torque is 0.6 of what the limit of the current leaves beside the current of the flux:
      T = 3/2 p L_M i_d √(I² − i_d²)
    """
    configuration = plant.configuration
    pole_pairs = configuration["machine.poles"] / 2
    flux = configuration["control.flux_reference_wb"]
    i_d = flux / (machine.leakage + machine.l_magnetising)
    limit = configuration[f"{CONTROL}current_limit_a"]
    if limit < 1.1 * i_d:
        raise UserError(
            f"{CONTROL}current_limit_a of {limit:g} A leaves none for torque beside the {i_d:.3g} A of the flux: raise "
            f"it to {1.2 * i_d:.3g} A at least (--limit-a)."
        )
    torque = 0.6 * 1.5 * pole_pairs * machine.l_magnetising * i_d * math.sqrt(limit**2 - i_d**2)
    torque = min(torque, 0.9 * configuration["command.torque_limit_nm"])
    speed = share * configuration["plant.u_dc_v"] / math.sqrt(3) / flux / pole_pairs
    return Course(float(f"{torque:.4g}"), begin_s, max(0.02, inertia * speed / torque)), speed


def _shaft_run(plant: MilPlant, name: str, settings: Settings, columns: tuple[str, ...]) -> list[np.ndarray]:
    """Times [s] and columns of a run of field-oriented control on a free shaft.

    Flux and torque of the course keep the current below the limit. That of the drive must leave half of the flux's
    current for torque: a limit that was set and leaves less is refused, the one by the estimate is raised.
    """
    import h5py

    limit = plant.configuration[f"{CONTROL}current_limit_a"]
    gamma = plant.estimate.terminals
    inductances = [gamma.leakage + gamma.l_magnetising, settings.get("control.machine_estimate.l_m_h", math.inf)]
    flux_current = plant.configuration["control.flux_reference_wb"] / min(inductances)
    magnetising: Settings = {"control.foc.magnetising_current_a": limit} if is_bounded(plant) else {}
    if limit < DRIVE_LIMIT * flux_current and magnetising:
        raise UserError(
            f"{CONTROL}current_limit_a of {limit:g} A does not bound the course of {name}, whose flux takes "
            f"{flux_current:.3g} A: raise it to {DRIVE_LIMIT * flux_current:.3g} A at least (--limit-a), or leave "
            f"{name} out of --only."
        )
    common: Settings = magnetising | {
        "control.controller": "foc",
        "drive.magnetise_first": True,
        "drive.current_limit_a": max(limit, DRIVE_LIMIT * flux_current),
        "load.kind": "torque",
        "profile.torque_nm.shape": "steps",
        "trace.signals": list(columns),
    }
    with h5py.File(_run(plant, name, common | settings)) as trace:
        return [1e-9 * trace["t_ns"][()], *(trace[column][()].astype(float) for column in columns)]


def _interval(plant: Plant, wanted_s: float) -> float:
    """Of a trace: about so long, in whole control periods. [us]"""
    period_us = plant.configuration["drive.period_us"]
    return period_us * max(1, round(1e6 * wanted_s / period_us))


def measure_inertia(plant: MilPlant, told: Settings, course: Course) -> Inertia:
    """By a drive that is told what was found before."""
    settings = told | {
        "profile.torque_nm.points": course.points,
        "duration_s": round(course.end_s + 0.05, 6),
        "trace.interval_us": _interval(plant, course.part_s / 100),
    }
    time, speed, torque = _shaft_run(plant, INERTIA, settings, ("speed_rad_s", "torque_mean_nm"))
    within = (time >= course.begin_s - 0.1 * course.part_s) & (time <= course.end_s + 0.02)
    return fit_inertia(time[within], speed[within], torque[within])


def _flux_share(share: float) -> Settings:
    """The drive without torque has this share of the flux reference, to which it falls with 3 τ_r; all limits are those
    of the whole flux."""
    if share == 1:
        return {"drive.flux_optimum": "constant"}
    return {"drive.flux_optimum": "max_torque_per_ampere", "drive.flux_least_share": share}


def measure_no_load(plant: MilPlant, told: Settings, course: Course, share: float = 1.0) -> NoLoad:
    """At a share of the flux reference. The shaft coasts after the first part of the course, for as long as three time
    constants of the rotor by the estimate take, those of the flux where it falls, and 0.3 s more, which count."""
    coasts = course.begin_s + course.part_s
    settles = SETTLES if share == 1 else SETTLES + FALLS
    counts = coasts + settles * plant.estimate.terminals.tau_r
    settings = (
        told
        | _flux_share(share)
        | {
            "profile.torque_nm.points": [*course.points[:2], [round(coasts, 6), 0.0]],
            "duration_s": round(counts + 0.3, 6),
            "trace.interval_us": _interval(plant, 1e-3),
        }
    )
    columns = ("flux_mean_wb", "speed_rad_s", "flux_angle_rad", "i_a_a", "i_b_a", "i_c_a")
    time, *values = _shaft_run(plant, NO_LOAD, settings, columns)
    flux, speed, angle, *phases = (one[time >= counts] for one in values)
    return fit_no_load(flux, current_along(angle, phases), speed)
