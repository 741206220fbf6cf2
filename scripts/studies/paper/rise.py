"""How torque answers a reference that rises slowly from zero (paper, 3.3)."""

import numpy as np
from sextant_py.plots.trace import Trace

from .lab import SAMPLED, Lab, Run, Settings
from .numbers import Numbers
from .steps import READINGS, crossing

SLOPES = (20, 30, 40, 47.12, 60, 80, 120, 200, 400)  # [N·m/s]; 47.12 is a sine of 15 N·m and 0.5 Hz


def rise(lab: Lab, settings: Settings) -> Run:
    """The first 120 ms of 3.3, finely recorded."""
    fine = {"duration_s": 0.12, "metrics.window_from_s": 0.1, "drive.period_us": 5, "trace.interval_us": 5}
    return lab.run("3_3_smooth", fine | settings, trace=True)


def answers(trace: Trace) -> tuple[float, float]:
    """When torque begins, and when it first meets its reference. [ms]"""
    begins = trace.t_s[np.argmax(trace["torque_max_nm"] > 0.01)]
    reference = trace["torque_reference_nm"]
    at_begin_of_row = np.concatenate((reference[:1], reference[:-1]))
    meets = trace.t_s[np.argmax((trace["torque_max_nm"] > at_begin_of_row - 1e-3) & (trace.t_s > begins))]
    return begins * 1e3, meets * 1e3


def ramp(slope: float) -> Settings:
    values = {"shape": "linear", "points": f"[[0, 0], [0.2, {0.2 * slope:.6g}]]", "amplitude": 0}
    return {f"profile.torque_nm.{key}": value for key, value in values.items()}


def measure_dead_zone(lab: Lab, numbers: Numbers, quick: bool) -> None:
    for reading in READINGS:
        add_answers(numbers, f"dead_zone/sine/{reading}/{{}}_ms", rise(lab, sectors(reading)), "sine of 0.5 Hz")
    if quick:
        return
    sampled = rise(lab, SAMPLED | {"drive.period_us": 25, "trace.interval_us": 25})
    add_answers(numbers, "dead_zone/sine/sampled/{}_ms", sampled, "sine of 0.5 Hz, sampled at 25 us")
    for slope in SLOPES:
        add_answers(numbers, f"dead_zone/ramp/{{}}/{slope}", rise(lab, ramp(slope)), f"ramp of {slope} N·m/s")
    command = "sextant-mil configs/scenarios/paper/3_3_smooth.toml with a ramp, its slope bisected"
    n = numbers.at("dead_zone/slope_of_22_ms", command=command)
    for reading in READINGS:
        meaning = f"slope whose reference is met after 22 ms, sectors {reading}"
        n.add(reading, slope_met_after(lab, 22, reading), "N·m/s", 0.3, meaning)


def sectors(reading: str) -> Settings:
    return {"control.dtc.sector_start_deg": READINGS[reading]}


def add_answers(numbers: Numbers, name: str, run: Run, reference: str) -> None:
    begins, meets = answers(run.trace)
    numbers.add(name.format("begins"), begins, "ms", 0.05, f"torque begins, {reference}", run.command)
    numbers.add(name.format("meets"), meets, "ms", 0.1, f"torque meets its reference, {reference}", run.command)


def slope_met_after(lab: Lab, time_ms: float, reading: str) -> float:
    def is_later(slope: float) -> bool:
        return answers(rise(lab, ramp(slope) | sectors(reading)).trace)[1] > time_ms

    return crossing(30, 70, is_later, 9)


def measure_smooth(lab: Lab, numbers: Numbers, quick: bool) -> None:
    run = lab.run("3_3_smooth", trace=True)
    n, (low, high), t_s = numbers.at("3_3", run), run.trace.error, run.trace.t_s
    late = t_s > 0.05
    n.add("low_nm", low[late].min(), "N·m", 0.03, "lowest torque error after 50 ms")
    n.add("high_nm", high[late].max(), "N·m", 0.03, "highest torque error after 50 ms")
    beyond = np.nonzero((high > 1.0) & late)[0][0]
    speed = run.trace["omega_m_rad_s"][beyond]
    n.add("speed_of_peaks_rad_s", speed, "rad/s", 2, "speed at the first error above 1 N·m")
    stands = t_s[np.nonzero(run.trace["flux_min_wb"] < 1.08)[0]]
    early = stands[stands < 0.6].max()
    n.add("flux_stands_s", early, "s", 0.01, "flux above 1.08 Wb from then on, until the zero crossing")
    n.metric("error_rms_nm", "torque_error_rms_nm", "N·m", 0.01, "RMS torque error after 0.2 s")
    if not quick:
        n = numbers.at("3_3/sampled", lab.run("3_3_smooth", SAMPLED, trace=True))
        n.metric("error_rms_nm", "torque_error_rms_nm", "N·m", 0.1, "RMS torque error after 0.2 s")
        n.metric("error_max_nm", "torque_error_max_nm", "N·m", 0.5, "largest torque error")
