"""The New York City Cycle with the passive load of the paper's vehicle (paper, 3.5), and Table 6 on its first 100 s."""

import math
from dataclasses import dataclass

import numpy as np

from .paper_lab import SAMPLED, Lab, Run, Trace
from .paper_numbers import Numbers

EXTENSIONS = ("linear", "clip", "origin")
BANDS = (0.918, 0.6885, 0.459)
FIGURES = {  # by upper and lower band, as Table 6 has it; the captions disagree
    (0.918, 0.918): 19,
    (0.918, 0.6885): 20,
    (0.918, 0.459): 21,
    (0.6885, 0.918): 23,
    (0.6885, 0.6885): 22,
    (0.6885, 0.459): 24,
    (0.459, 0.918): 26,
    (0.459, 0.6885): 27,
    (0.459, 0.459): 25,
}
START_S = 0.05  # the start of the dead machine
TOLERATED_NM = 0.03  # beyond a band: the dwell's overshoot and what a row's reference rises by
REST_S, DRIVE_S = (14.0, 26.0), (57.0, 66.0)  # at rest, and driving at 14 to 37 rad/s
FIRST_S = (46.0, 57.0)  # the first departure of the vehicle


@dataclass(frozen=True)
class Excursion:
    """Rows in a row, less than 0.1 s apart, in which the torque error leaves its bands."""

    begin_s: float
    end_s: float
    beyond_nm: float  # the most by which it is outside
    current_a: float  # largest current vector from 0.1 s before to 0.5 s after


def excursions(trace: Trace, upper: float, lower: float, gap_s: float = 0.1) -> list[Excursion]:
    low, high = trace.error
    beyond = np.maximum(-upper - low, high - lower) - TOLERATED_NM
    rows = np.nonzero((beyond > 0) & (trace.t_s > START_S))[0]
    if not len(rows):
        return []
    groups = np.split(rows, np.nonzero(np.diff(trace.t_s[rows]) > gap_s)[0] + 1)
    return [
        Excursion(
            trace.t_s[g[0]],
            trace.t_s[g[-1]],
            float(beyond[g].max() + TOLERATED_NM),
            float(trace.between(trace.t_s[g[0]] - 0.1, trace.t_s[g[-1]] + 0.5)["current_max_a"].max()),
        )
        for g in groups
    ]


def surges(trace: Trace, current_a: float = 25) -> int:
    """Times at which the current vector rises above current_a after the start, at least 0.1 s apart."""
    rows = np.nonzero((trace["current_max_a"] > current_a) & (trace.t_s > START_S))[0]
    return 0 if not len(rows) else 1 + int(np.sum(np.diff(trace.t_s[rows]) > 0.1))


def cycle(lab: Lab, extension: str, sampled: bool = False) -> Run:
    return lab.run(f"3_5_nycc_{extension}", SAMPLED if sampled else {}, trace=True)


def cycle_numbers(numbers: Numbers, name: str, run: Run) -> None:
    wide = 1 if "sampled" in name else 0.02
    for metric, unit, tolerance, meaning in (
        ("torque_error_rms_nm", "N·m", wide, "RMS of the torque error"),
        ("torque_error_max_nm", "N·m", 5 * wide, "largest torque error after 0.2 s"),
        ("torque_bias_nm", "N·m", wide, "mean torque error"),
        ("torque_pulse_frequency_hz", "Hz", -0.02, "pulses of the torque comparator"),
        ("switching_frequency_hz", "Hz", -0.02, "switching frequency of a leg"),
        ("peak_current_a", "A", -0.02, "largest phase current, that of the start"),
        ("flux_min_wb", "Wb", 0.02, "least flux after 0.2 s"),
        ("energy_from_link_j", "J", -0.02, "energy drawn from the link"),
        ("energy_to_link_j", "J", -0.02, "energy fed back into the link"),
        ("energy_copper_j", "J", -0.02, "lost in the windings"),
        ("energy_shaft_j", "J", -0.02, "work on the shaft"),
    ):
        if not math.isnan(run[metric]):
            numbers.metric(f"{name}/{metric}", run, metric, unit, tolerance, f"{meaning}, NYCC 598 s")
    trace, command = run.trace, run.command
    net = run["energy_from_link_j"] - run["energy_to_link_j"]
    numbers.add(f"{name}/net_j", net, "J", -0.02, "from minus to the link", command)
    late = trace.t_s > 0.2
    surge = trace["current_max_a"][late].max()
    numbers.add(f"{name}/surge_worst_a", surge, "A", -0.03, "largest current vector after 0.2 s", command)
    meaning = "times at which the current vector passes 25 A after the start"
    numbers.add(f"{name}/surges", surges(trace), "1", 2, meaning, command)
    sagging = float(np.mean(trace["flux_mean_wb"] < 0.95 * 1.1) * 100)
    numbers.add(f"{name}/flux_low_percent", sagging, "%", 1, "share of the time with the flux below 95 %", command)
    rest = trace.between(*REST_S)
    numbers.add(f"{name}/rest_flux_min_wb", rest["flux_min_wb"].min(), "Wb", 0.02, "least flux at rest", command)
    numbers.add(f"{name}/rest_flux_max_wb", rest["flux_max_wb"].max(), "Wb", 0.02, "largest flux at rest", command)
    if "sampled" not in name:
        distortion_numbers(numbers, name, run)


def distortion_numbers(numbers: Numbers, name: str, run: Run) -> None:
    """Where torque leaves its band, and what is asked of it."""
    used = run["energy_shaft_j"] + run["energy_copper_j"] + run["energy_field_j"]
    balance = run["energy_from_link_j"] - run["energy_to_link_j"] - used
    closed = 100 * balance / run["energy_from_link_j"]
    command, reference = run.command, run.trace["torque_reference_nm"]
    numbers.add(f"{name}/balance_percent", closed, "%", 0.05, "energy unaccounted for, of that drawn", command)
    found = excursions(run.trace, 0.918, 0.918)
    worst = max((e.beyond_nm for e in found), default=0)
    longest = 1e3 * max((e.end_s - e.begin_s for e in found), default=0)
    meaning = "times at which the torque leaves its band"
    numbers.add(f"{name}/distortions", len(found), "1", 3, meaning, command)
    numbers.add(f"{name}/distortions_worst_nm", worst, "N·m", 0.05, "by how much, at most", command)
    numbers.add(f"{name}/distortions_longest_ms", longest, "ms", 20, "how long, at most", command)
    numbers.add(f"{name}/reference_min_nm", reference.min(), "N·m", 0.01, "least torque reference", command)
    numbers.add(f"{name}/reference_max_nm", reference.max(), "N·m", 0.01, "largest torque reference", command)
    negative = float(np.mean(reference < -1e-9) * 100)
    numbers.add(f"{name}/negative_percent", negative, "%", 0.2, "share of the time with negative torque", command)


def measure_cycle(lab: Lab, numbers: Numbers, quick: bool) -> None:
    cross_check(lab, numbers, "3_5_nycc_linear", 10)
    if quick:
        return
    for extension in EXTENSIONS:
        cycle_numbers(numbers, f"nycc/{extension}", cycle(lab, extension))
    cycle_numbers(numbers, "nycc/sampled", cycle(lab, "linear", sampled=True))
    cross_check(lab, numbers, "table6", 66)


def cross_check(lab: Lab, numbers: Numbers, scenario: str, duration_s: int) -> None:
    """What CVODE says of the first seconds, beside the fixed step."""
    fixed = lab.run(scenario, {"duration_s": duration_s})
    cvode = {"plant.integrator": "cvode", "plant.cvode.relative_tolerance": "1e-8", "duration_s": duration_s}
    exact = lab.run(scenario, cvode)
    for metric in (
        "torque_error_rms_nm",
        "torque_bias_nm",
        "torque_pulse_frequency_hz",
        "flux_mean_wb",
        "peak_current_a",
        "energy_copper_j",
    ):
        share = 100 * abs(fixed[metric] / exact[metric] - 1)
        meaning = f"{metric}: fixed step beside CVODE over {duration_s} s of {scenario}"
        numbers.add(f"cross_check/{scenario}/{metric}", share, "%", 0.5, meaning, exact.command)
    name = f"realtime/cvode/{scenario}_{duration_s}_s"
    numbers.add(name, exact["realtime_factor"], "1", None, "simulated by wall time, CVODE", exact.command)


def table6(lab: Lab, combinations: list[tuple[float, float]], settings: dict | None = None) -> list[Run]:
    bands = ({"control.torque_band_upper_nm": u, "control.torque_band_lower_nm": lo} for u, lo in combinations)
    return lab.run_all([("table6", b | (settings or {})) for b in bands], trace=True)


def swing(trace: Trace, span: tuple[float, float]) -> tuple[float, float]:
    """Lowest and highest torque error within the span. [N·m]"""
    low, high = trace.between(*span).error
    return float(low.min()), float(high.max())


def dead_time_s(trace: Trace) -> float:
    """How long no torque is made while the reference passes zero, in the first departure."""
    part = trace.between(*FIRST_S)
    idle = np.maximum(abs(part["torque_min_nm"]), abs(part["torque_max_nm"])) < 0.02
    return float(np.sum(np.diff(part.t_s, prepend=part.t_s[0])[idle]))


def measure_table6(lab: Lab, numbers: Numbers, quick: bool) -> None:
    combinations = [(0.918, 0.918), (0.459, 0.459)] if quick else list(FIGURES)
    for (upper, lower), run in zip(combinations, table6(lab, combinations), strict=True):
        name, command, trace = f"table6/{upper}/{lower}", run.command, run.trace
        for state, span in (("rest", REST_S), ("drive", DRIVE_S)):
            low, high = swing(trace, span)
            numbers.add(f"{name}/{state}_low_nm", low, "N·m", 0.03, f"lowest torque error, {state}", command)
            numbers.add(f"{name}/{state}_high_nm", high, "N·m", 0.03, f"highest torque error, {state}", command)
            mean = trace.between(*span)
            bias = float(np.mean(mean["torque_mean_nm"] - mean["torque_reference_nm"]))
            numbers.add(f"{name}/{state}_bias_nm", bias, "N·m", 0.02, f"mean torque error, {state}", command)
        numbers.metric(
            f"{name}/leg_hz", run, "switching_frequency_hz", "Hz", -0.02, "switching frequency of a leg, 100 s"
        )
        numbers.metric(
            f"{name}/pulse_hz", run, "torque_pulse_frequency_hz", "Hz", -0.02, "pulses of the comparator, 100 s"
        )
        numbers.metric(f"{name}/start_a", run, "peak_current_a", "A", -0.02, "largest phase current of the start")
        low, high = swing(trace, FIRST_S)
        numbers.add(
            f"{name}/first_error_nm",
            max(-low, high),
            "N·m",
            0.05,
            "largest torque error of the first departure",
            command,
        )
        first = trace.between(*FIRST_S)
        numbers.add(
            f"{name}/first_a",
            first["current_max_a"].max(),
            "A",
            -0.1,
            "largest current vector of the first departure",
            command,
        )
        numbers.add(
            f"{name}/first_dead_s", dead_time_s(trace), "s", 0.05, "time without torque in the first departure", command
        )
        numbers.add(
            f"{name}/first_flux_wb",
            first["flux_min_wb"].min(),
            "Wb",
            0.01,
            "least flux of the first departure",
            command,
        )
