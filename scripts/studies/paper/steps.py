"""How torque follows steps of its reference and of the load, and what the flux does (paper, 3.1, 3.2 and 3.4)."""

import math

import numpy as np
from sextant_py.plots.trace import Trace

from .lab import SAMPLED, Lab, Run, Settings
from .numbers import Numbers

READINGS = {"centred": -30, "v1": 0}  # sector_start_deg
STEPS = (2, 5, 10, 15, 20, 25, 30, 40, 50, 65, 80, 100, 115, 130)
QUICK_STEPS = (5, 15, 30, 130)
LOAD_STEPS_S = (0.2, 0.5, 0.8, 1.1)  # of 3_1_constant_torque.toml
REVERSALS_S = (0, 0.2, 0.5, 0.8, 1.0)  # of 3_2_reversal.toml


def step_settings(torque: float, reading: str, magnetised: bool) -> Settings:
    """A step of 3.1 at time zero, and nothing after it."""
    settings = {
        "profile.torque_nm.value": torque,
        "control.dtc.sector_start_deg": READINGS[reading],
        "duration_s": 0.04,
        "metrics.window_from_s": 0.03,
        "protection.over_current_a": 1000,
    }
    return settings | ({"event_exact.initial_flux_wb": 1.1} if magnetised else {})


def response_ms(lab: Lab, torque: float, reading: str = "centred", magnetised: bool = False) -> float:
    return lab.run("3_1_constant_torque", step_settings(torque, reading, magnetised))["response_time_ms"]


def crossing(low: float, high: float, is_below, rounds: int = 12) -> float:
    """Where is_below, true at low and false at high, changes."""
    for _ in range(rounds):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if is_below(middle) else (low, middle)
    return 0.5 * (low + high)


def measure_steps(lab: Lab, numbers: Numbers, quick: bool) -> None:
    steps = QUICK_STEPS if quick else STEPS
    points = [(r, m, t) for r in READINGS for m in (False, True) for t in steps]
    runs = lab.run_all([("3_1_constant_torque", step_settings(t, r, m)) for r, m, t in points])
    for (reading, magnetised, torque), run in zip(points, runs, strict=True):
        start = "magnetised" if magnetised else "dead"
        meaning = f"95 % of a step of {torque} N·m, sectors {reading}, machine {start}"
        n = numbers.at("", run)
        n.metric(f"response/{reading}/{start}/{torque}", "response_time_ms", "ms", 0.02, meaning)
        if not magnetised:
            n.metric(f"surge/{reading}/{torque}", "peak_current_a", "A", -0.01, f"largest phase current, {meaning}")
    if quick:
        return
    command = "sextant-mil configs/scenarios/paper/3_1_constant_torque.toml --set profile.torque_nm.value=…, bisected"
    n = numbers.at("response", command=command)
    for time_ms, low, high, tolerance in ((3.7, 20, 40, 0.3), (5, 30, 130, 0.5)):
        step = crossing(low, high, lambda t, limit=time_ms: response_ms(lab, t) < limit)
        meaning = f"centred step from a dead machine that takes {time_ms} ms"
        n.add(f"step_of_{time_ms}_ms", step, "N·m", tolerance, meaning)
    each = SAMPLED | {"drive.period_us": 25}
    points = [("3_1_constant_torque", step_settings(t, "centred", False) | each) for t in QUICK_STEPS]
    for torque, run in zip(QUICK_STEPS, lab.run_all(points), strict=True):
        meaning = f"95 % of a step of {torque} N·m, sampled at 25 us, dead machine"
        numbers.at("response/sampled/dead", run).metric(f"{torque}", "response_time_ms", "ms", 0.03, meaning)


def flux_numbers(numbers: Numbers, name: str, run: Run) -> None:
    """The start of the flux: when it stands, how it sags before, and where it is afterwards."""
    n, trace = numbers.at(f"flux/{name}", run), run.trace
    low, high, t_s = trace["flux_min_wb"], trace["flux_max_wb"], trace.t_s
    outside = (low < 1.1 * 0.985) | (high > 1.1 * 1.015)
    n.add("stands_ms", t_s[np.nonzero(outside)[0][-1]] * 1e3, "ms", 2, "flux within 1.5 % of 1.1 Wb from then on")
    first = t_s[np.argmax(high > 0.9)]
    early, after = (t_s > 0.001) & (t_s < 0.1), t_s > 0.12
    n.add("early_max_wb", high[early].max(), "Wb", 0.005, "largest flux before 0.1 s")
    rising = (t_s > max(first, 0.002)) & (t_s < 0.1)
    sag = low[rising].min() if rising.any() else math.nan
    n.add("sag_wb", sag, "Wb", 0.005, "least flux after it first passed 0.9 Wb, before 0.1 s")
    n.add("at_4_ms_wb", float(np.interp(0.004, t_s, trace["psi_s_wb"])), "Wb", 0.005, "flux at 4 ms")
    n.add("min_wb", low[after].min(), "Wb", 0.002, "least flux after 0.12 s")
    n.add("max_wb", high[after].max(), "Wb", 0.003, "largest flux after 0.12 s")
    n.metric("surge_a", "peak_current_a", "A", -0.01, "largest phase current of the start")
    n.add("steady_a", trace["current_max_a"][after].max(), "A", -0.02, "largest current vector after 0.12 s")


def constant_torque(lab: Lab, sampled: bool = False) -> Run:
    return lab.run("3_1_constant_torque", SAMPLED if sampled else {}, trace=True)


def mean_change(trace: Trace, t_s: float, span_s: float = 0.02) -> float:
    """By how much the mean torque of the span after t_s differs from that of the span before. [N·m]"""
    after, before = trace.between(t_s, t_s + span_s), trace.between(t_s - span_s, t_s)
    return float(abs(after["torque_mean_nm"].mean() - before["torque_mean_nm"].mean()))


def load_step_numbers(numbers: Numbers, run: Run) -> None:
    n = numbers.at("load_step", run)
    for t_s in LOAD_STEPS_S:
        meaning = f"change of the torque's mean over 20 ms at the load step of {t_s} s"
        n.add(f"{t_s}/mean_change_nm", mean_change(run.trace, t_s), "N·m", 0.01, meaning)
        low, high = run.trace.between(t_s, t_s + 0.02).error
        meaning = f"swing of the torque error in the 20 ms after the load step of {t_s} s"
        n.add(f"{t_s}/swing_nm", high.max() - low.min(), "N·m", 0.02, meaning)
    largest = max(numbers[f"load_step/{t_s}/mean_change_nm"] for t_s in LOAD_STEPS_S)
    n.add("largest_mean_change_nm", largest, "N·m", 0.01, "the largest of these")


def measure_constant_torque(lab: Lab, numbers: Numbers, quick: bool) -> None:
    run = constant_torque(lab)
    steady_numbers(numbers, "3_1", run)
    flux_numbers(numbers, "centred", run)
    load_step_numbers(numbers, run)
    if quick:
        return
    sampled = constant_torque(lab, sampled=True)
    steady_numbers(numbers, "3_1/sampled", sampled)
    flux_numbers(numbers, "sampled", sampled)
    n = numbers.at("load_step/sampled", sampled)
    largest = max(mean_change(sampled.trace, t_s) for t_s in LOAD_STEPS_S)
    meaning = "largest change of the torque's mean over 20 ms at a load step"
    n.add("largest_mean_change_nm", largest, "N·m", 0.2, meaning)
    between = max(mean_change(sampled.trace, t_s + 0.15) for t_s in LOAD_STEPS_S)
    n.add("between_nm", between, "N·m", 0.2, "the same half-way between the load steps")


def steady_numbers(numbers: Numbers, name: str, run: Run) -> None:
    """Ripple, bias and frequencies of a run's window."""
    n, wide = numbers.at(name, run), 0.3 if "sampled" in name else 0.02
    n.metric("ripple_pp_nm", "torque_ripple_pp_nm", "N·m", wide, "ripple, peak to peak")
    n.metric("bias_nm", "torque_bias_nm", "N·m", wide, "mean torque error")
    n.metric("error_max_nm", "torque_error_max_nm", "N·m", wide, "largest torque error")
    n.metric("error_rms_nm", "torque_error_rms_nm", "N·m", wide, "RMS torque error")
    n.metric("pulse_hz", "torque_pulse_frequency_hz", "Hz", -0.01, "pulses of the torque comparator")
    n.metric("leg_hz", "switching_frequency_hz", "Hz", -0.01, "switching frequency of a leg")
    n.metric("response_ms", "response_time_ms", "ms", 0.03, "95 % of the step at time zero")
    n.metric("peak_current_a", "peak_current_a", "A", -0.02, "largest phase current of the run")


def reversal(lab: Lab, sampled: bool = False) -> Run:
    return lab.run("3_2_reversal", SAMPLED if sampled else {}, trace=True)


def settled(trace: Trace, steps_s: tuple[float, ...], wait_s: float = 0.005) -> np.ndarray:
    """Rows that are no part of a step's answer."""
    wanted = np.ones(len(trace.t_s), dtype=bool)
    for t_s in steps_s:
        wanted &= ~((trace.t_s > t_s) & (trace.t_s <= t_s + wait_s))
    return wanted


def error_numbers(numbers: Numbers, name: str, run: Run) -> None:
    low, high = run.trace.error
    rows = settled(run.trace, REVERSALS_S)
    n, wide = numbers.at(name, run), 0.5 if "sampled" in name else 0.03
    n.add("low_nm", low[rows].min(), "N·m", wide, "lowest torque error, 5 ms after each step on")
    n.add("high_nm", high[rows].max(), "N·m", wide, "highest torque error, 5 ms after each step on")


def measure_reversal(lab: Lab, numbers: Numbers, quick: bool) -> None:
    run = reversal(lab)
    for t_s in (0,) if quick else REVERSALS_S:
        settings = {"metrics.step_s": t_s, "duration_s": t_s + 0.02}
        settings |= {"metrics.window_from_s": t_s} if t_s < 0.15 else {}
        n = numbers.at("3_2/response_ms", lab.run("3_2_reversal", settings))
        n.metric(f"{t_s}", "response_time_ms", "ms", 0.02, f"95 % of the step at {t_s} s")
    error_numbers(numbers, "3_2", run)
    if not quick:
        error_numbers(numbers, "3_2/sampled", reversal(lab, sampled=True))
    n, speed = numbers.at("3_2", run), run.trace["omega_m_rad_s"]
    n.add("speed_min_rad_s", speed.min(), "rad/s", 0.5, "lowest speed")
    n.add("speed_max_rad_s", speed.max(), "rad/s", 0.5, "highest speed")
    n.metric("to_link_j", "energy_to_link_j", "J", -0.01, "energy fed back into the link")
    n.metric("from_link_j", "energy_from_link_j", "J", -0.01, "energy drawn from the link")


def measure_high_torque(lab: Lab, numbers: Numbers, quick: bool) -> None:
    run = lab.run("3_4_high_torque", trace=True)
    steady_numbers(numbers, "3_4", run)
    stands = run.trace.t_s[np.nonzero(run.trace["flux_min_wb"] < 1.08)[0][-1]]
    numbers.at("3_4", run).add("flux_stands_s", stands, "s", 0.02, "flux above 1.08 Wb from then on")
    if not quick:
        steady_numbers(numbers, "3_4/sampled", lab.run("3_4_high_torque", SAMPLED, trace=True))


def measure_negative(lab: Lab, numbers: Numbers, quick: bool) -> None:
    """Sectors that start on the vectors."""
    run = lab.run("sector_start_0", trace=True)
    flux_numbers(numbers, "v1", run)
    numbers.at("sector_start_0", run).metric("response_ms", "response_time_ms", "ms", 0.02, "95 % of 15 N·m")
    if quick:
        return
    n = numbers.at("sector_start_0", lab.run("sector_start_0_negative", trace=True))
    n.metric("negative_bias_nm", "torque_bias_nm", "N·m", 0.1, "torque error of -15 N·m")
    n.metric("negative_flux_wb", "flux_max_wb", "Wb", 0.001, "largest flux at -15 N·m")
    n.metric("negative_leg_hz", "switching_frequency_hz", "Hz", -0.1, "switching of a leg at it")
    back = {"profile.torque_nm.value": -15, "event_exact.initial_flux_wb": 1.1, "load.torque_nm.points": "[[0, 0]]"}
    n = numbers.at("sector_start_0", lab.run("sector_start_0", back))
    n.metric("reverse_bias_nm", "torque_bias_nm", "N·m", 0.5, "torque error of -15 N·m, magnetised")
    n.metric("reverse_flux_wb", "flux_min_wb", "Wb", 0.05, "least flux at -15 N·m, magnetised")
