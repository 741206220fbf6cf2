"""The New York City Cycle with the passive load of the paper's vehicle (paper, 3.5), and Table 6 on its first 100 s."""

import math
from dataclasses import dataclass

import numpy as np
from sextant_py.plots.trace import Trace

from .lab import SAMPLED, Lab, Run
from .numbers import Numbers, Scope

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
    n, trace, wide = numbers.at(name, run), run.trace, 1 if "sampled" in name else 0.02
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
            n.metric(metric, metric, unit, tolerance, f"{meaning}, NYCC 598 s")
    net = run["energy_from_link_j"] - run["energy_to_link_j"]
    n.add("net_j", net, "J", -0.02, "from minus to the link")
    surge = trace["current_max_a"][trace.t_s > 0.2].max()
    n.add("surge_worst_a", surge, "A", -0.03, "largest current vector after 0.2 s")
    n.add("surges", surges(trace), "1", 2, "times at which the current vector passes 25 A after the start")
    sagging = float(np.mean(trace["flux_mean_wb"] < 0.95 * 1.1) * 100)
    n.add("flux_low_percent", sagging, "%", 1, "share of the time with the flux below 95 %")
    rest = trace.between(*REST_S)
    n.add("rest_flux_min_wb", rest["flux_min_wb"].min(), "Wb", 0.02, "least flux at rest")
    n.add("rest_flux_max_wb", rest["flux_max_wb"].max(), "Wb", 0.02, "largest flux at rest")
    if "sampled" not in name:
        distortion_numbers(n, run)


def distortion_numbers(n: Scope, run: Run) -> None:
    """Where torque leaves its band, and what is asked of it."""
    used = run["energy_shaft_j"] + run["energy_copper_j"] + run["energy_field_j"]
    balance = run["energy_from_link_j"] - run["energy_to_link_j"] - used
    closed = 100 * balance / run["energy_from_link_j"]
    n.add("balance_percent", closed, "%", 0.05, "energy unaccounted for, of that drawn")
    found = excursions(run.trace, 0.918, 0.918)
    longest = 1e3 * max((e.end_s - e.begin_s for e in found), default=0)
    n.add("distortions", len(found), "1", 3, "times at which the torque leaves its band")
    n.add("distortions_worst_nm", max((e.beyond_nm for e in found), default=0), "N·m", 0.05, "by how much, at most")
    n.add("distortions_longest_ms", longest, "ms", 20, "how long, at most")
    reference = run.trace["torque_reference_nm"]
    n.add("reference_min_nm", reference.min(), "N·m", 0.01, "least torque reference")
    n.add("reference_max_nm", reference.max(), "N·m", 0.01, "largest torque reference")
    negative = float(np.mean(reference < -1e-9) * 100)
    n.add("negative_percent", negative, "%", 0.2, "share of the time with negative torque")


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
    n = numbers.at("", exact)
    for metric in ("torque_error_rms_nm", "torque_bias_nm", "torque_pulse_frequency_hz", "flux_mean_wb",
                   "peak_current_a", "energy_copper_j"):  # fmt: skip
        share = 100 * abs(fixed[metric] / exact[metric] - 1)
        meaning = f"{metric}: fixed step beside CVODE over {duration_s} s of {scenario}"
        n.add(f"cross_check/{scenario}/{metric}", share, "%", 0.5, meaning)
    name = f"realtime/cvode/{scenario}_{duration_s}_s"
    n.metric(name, "realtime_factor", "1", None, "simulated by wall time, CVODE")


def table6(lab: Lab, combinations: list[tuple[float, float]], settings: dict | None = None) -> list[Run]:
    bands = ({"control.dtc.torque_band_upper_nm": u, "control.dtc.torque_band_lower_nm": lo} for u, lo in combinations)
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
        n, trace = numbers.at(f"table6/{upper}/{lower}", run), run.trace
        for state, span in (("rest", REST_S), ("drive", DRIVE_S)):
            low, high = swing(trace, span)
            n.add(f"{state}_low_nm", low, "N·m", 0.03, f"lowest torque error, {state}")
            n.add(f"{state}_high_nm", high, "N·m", 0.03, f"highest torque error, {state}")
            mean = trace.between(*span)
            bias = float(np.mean(mean["torque_mean_nm"] - mean["torque_reference_nm"]))
            n.add(f"{state}_bias_nm", bias, "N·m", 0.02, f"mean torque error, {state}")
        n.metric("leg_hz", "switching_frequency_hz", "Hz", -0.02, "switching frequency of a leg, 100 s")
        n.metric("pulse_hz", "torque_pulse_frequency_hz", "Hz", -0.02, "pulses of the comparator, 100 s")
        n.metric("start_a", "peak_current_a", "A", -0.02, "largest phase current of the start")
        low, high = swing(trace, FIRST_S)
        first = trace.between(*FIRST_S)
        n.add("first_error_nm", max(-low, high), "N·m", 0.05, "largest torque error of the first departure")
        surge, flux = first["current_max_a"].max(), first["flux_min_wb"].min()
        n.add("first_a", surge, "A", -0.1, "largest current vector of the first departure")
        n.add("first_dead_s", dead_time_s(trace), "s", 0.05, "time without torque in the first departure")
        n.add("first_flux_wb", flux, "Wb", 0.01, "least flux of the first departure")
