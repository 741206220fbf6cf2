"""How torque follows steps of its reference and of the load, and what the flux does (paper, 3.1, 3.2 and 3.4)."""

import math

import numpy as np

from .paper_lab import SAMPLED, Lab, Run, Settings, Trace
from .paper_numbers import Numbers

READINGS = {"centred": -30, "v1": 0}  # sector_start_deg
STEPS = (2, 5, 10, 15, 20, 25, 30, 40, 50, 65, 80, 100, 115, 130)
QUICK_STEPS = (5, 15, 30, 130)
LOAD_STEPS_S = (0.2, 0.5, 0.8, 1.1)  # of 3_1_constant_torque.toml
REVERSALS_S = (0, 0.2, 0.5, 0.8, 1.0)  # of 3_2_reversal.toml


def step_settings(torque: float, reading: str, magnetised: bool) -> Settings:
    """A step of 3.1 at time zero, and nothing after it."""
    settings = {
        "profile.torque_nm.value": torque,
        "control.sector_start_deg": READINGS[reading],
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
    cases = [(r, m) for r in READINGS for m in (False, True)]
    points = [(r, m, t) for r, m in cases for t in steps]
    runs = lab.run_all([("3_1_constant_torque", step_settings(t, r, m)) for r, m, t in points])
    for (reading, magnetised, torque), run in zip(points, runs, strict=True):
        start = "magnetised" if magnetised else "dead"
        meaning = f"95 % of a step of {torque} N·m, sectors {reading}, machine {start}"
        numbers.metric(f"response/{reading}/{start}/{torque}", run, "response_time_ms", "ms", 0.02, meaning)
        if not magnetised:
            name = f"surge/{reading}/{torque}"
            numbers.metric(name, run, "peak_current_a", "A", -0.01, f"largest phase current, {meaning}")
    if quick:
        return
    paper = crossing(20, 40, lambda t: response_ms(lab, t) < 3.7)
    command = "sextant-mil configs/scenarios/paper/3_1_constant_torque.toml --set profile.torque_nm.value=…, bisected"
    numbers.add(
        "response/step_of_3.7_ms", paper, "N·m", 0.3, "centred step from a dead machine that takes 3.7 ms", command
    )
    abb = crossing(30, 130, lambda t: response_ms(lab, t) < 5)
    numbers.add("response/step_of_5_ms", abb, "N·m", 0.5, "centred step from a dead machine that takes 5 ms", command)
    sampled = lab.run_all(
        [
            ("3_1_constant_torque", step_settings(t, "centred", False) | SAMPLED | {"control.period_us": 25})
            for t in QUICK_STEPS
        ]
    )
    for torque, run in zip(QUICK_STEPS, sampled, strict=True):
        meaning = f"95 % of a step of {torque} N·m, sampled at 25 us, dead machine"
        numbers.metric(f"response/sampled/dead/{torque}", run, "response_time_ms", "ms", 0.03, meaning)


def flux_numbers(numbers: Numbers, name: str, run: Run) -> None:
    """The start of the flux: when it stands, how it sags before, and where it is afterwards."""
    trace, command = run.trace, run.command
    low, high = trace["flux_min_wb"], trace["flux_max_wb"]
    outside = (low < 1.1 * 0.985) | (high > 1.1 * 1.015)
    stands = trace.t_s[np.nonzero(outside)[0][-1]] * 1e3
    numbers.add(f"flux/{name}/stands_ms", stands, "ms", 2, "flux within 1.5 % of 1.1 Wb from then on", command)
    first = trace.t_s[np.argmax(high > 0.9)]
    early = (trace.t_s > 0.001) & (trace.t_s < 0.1)
    after = trace.t_s > 0.12
    numbers.add(f"flux/{name}/early_max_wb", high[early].max(), "Wb", 0.005, "largest flux before 0.1 s", command)
    rising = (trace.t_s > max(first, 0.002)) & (trace.t_s < 0.1)
    sag = low[rising].min() if rising.any() else math.nan
    numbers.add(
        f"flux/{name}/sag_wb", sag, "Wb", 0.005, "least flux after it first passed 0.9 Wb, before 0.1 s", command
    )
    numbers.add(
        f"flux/{name}/at_4_ms_wb",
        float(np.interp(0.004, trace.t_s, trace["psi_s_wb"])),
        "Wb",
        0.005,
        "flux at 4 ms",
        command,
    )
    numbers.add(f"flux/{name}/min_wb", low[after].min(), "Wb", 0.002, "least flux after 0.12 s", command)
    numbers.add(f"flux/{name}/max_wb", high[after].max(), "Wb", 0.003, "largest flux after 0.12 s", command)
    numbers.metric(f"flux/{name}/surge_a", run, "peak_current_a", "A", -0.01, "largest phase current of the start")
    steady = float(trace["current_max_a"][after].max())
    numbers.add(f"flux/{name}/steady_a", steady, "A", -0.02, "largest current vector after 0.12 s", command)


def constant_torque(lab: Lab, sampled: bool = False) -> Run:
    return lab.run("3_1_constant_torque", SAMPLED if sampled else {}, trace=True)


def mean_change(trace: Trace, t_s: float, span_s: float = 0.02) -> float:
    """By how much the mean torque of the span after t_s differs from that of the span before. [N·m]"""
    after, before = trace.between(t_s, t_s + span_s), trace.between(t_s - span_s, t_s)
    return float(abs(after["torque_mean_nm"].mean() - before["torque_mean_nm"].mean()))


def load_step_numbers(numbers: Numbers, run: Run) -> None:
    trace, command = run.trace, run.command
    for t_s in LOAD_STEPS_S:
        meaning = f"change of the torque's mean over 20 ms at the load step of {t_s} s"
        numbers.add(f"load_step/{t_s}/mean_change_nm", mean_change(trace, t_s), "N·m", 0.01, meaning, command)
        low, high = trace.between(t_s, t_s + 0.02).error
        meaning = f"swing of the torque error in the 20 ms after the load step of {t_s} s"
        numbers.add(f"load_step/{t_s}/swing_nm", high.max() - low.min(), "N·m", 0.02, meaning, command)
    largest = max(numbers[f"load_step/{t_s}/mean_change_nm"] for t_s in LOAD_STEPS_S)
    numbers.add("load_step/largest_mean_change_nm", largest, "N·m", 0.01, "the largest of these", command)


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
    largest = max(mean_change(sampled.trace, t_s) for t_s in LOAD_STEPS_S)
    meaning = "largest change of the torque's mean over 20 ms at a load step"
    numbers.add("load_step/sampled/largest_mean_change_nm", largest, "N·m", 0.2, meaning, sampled.command)
    between = max(mean_change(sampled.trace, t_s + 0.15) for t_s in LOAD_STEPS_S)
    meaning = "the same half-way between the load steps"
    numbers.add("load_step/sampled/between_nm", between, "N·m", 0.2, meaning, sampled.command)


def steady_numbers(numbers: Numbers, name: str, run: Run) -> None:
    """Ripple, bias and frequencies of a run's window."""
    exact = "sampled" not in name
    wide = 0.02 if exact else 0.3
    numbers.metric(f"{name}/ripple_pp_nm", run, "torque_ripple_pp_nm", "N·m", wide, "ripple, peak to peak")
    numbers.metric(f"{name}/bias_nm", run, "torque_bias_nm", "N·m", wide, "mean torque error")
    numbers.metric(f"{name}/error_max_nm", run, "torque_error_max_nm", "N·m", wide, "largest torque error")
    numbers.metric(f"{name}/error_rms_nm", run, "torque_error_rms_nm", "N·m", wide, "RMS torque error")
    numbers.metric(f"{name}/pulse_hz", run, "torque_pulse_frequency_hz", "Hz", -0.01, "pulses of the torque comparator")
    numbers.metric(f"{name}/leg_hz", run, "switching_frequency_hz", "Hz", -0.01, "switching frequency of a leg")
    numbers.metric(f"{name}/response_ms", run, "response_time_ms", "ms", 0.03, "95 % of the step at time zero")
    numbers.metric(f"{name}/peak_current_a", run, "peak_current_a", "A", -0.02, "largest phase current of the run")


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
    wide = 0.5 if "sampled" in name else 0.03
    after = "torque error, 5 ms after each step on"
    numbers.add(f"{name}/low_nm", low[rows].min(), "N·m", wide, f"lowest {after}", run.command)
    numbers.add(f"{name}/high_nm", high[rows].max(), "N·m", wide, f"highest {after}", run.command)


def measure_reversal(lab: Lab, numbers: Numbers, quick: bool) -> None:
    run = reversal(lab)
    for t_s in (0,) if quick else REVERSALS_S:
        settings = {"metrics.step_s": t_s, "duration_s": t_s + 0.02} | (
            {"metrics.window_from_s": t_s} if t_s < 0.15 else {}
        )
        at = lab.run("3_2_reversal", settings)
        numbers.metric(f"3_2/response_ms/{t_s}", at, "response_time_ms", "ms", 0.02, f"95 % of the step at {t_s} s")
    error_numbers(numbers, "3_2", run)
    if not quick:
        error_numbers(numbers, "3_2/sampled", reversal(lab, sampled=True))
    speed = run.trace["omega_m_rad_s"]
    numbers.add("3_2/speed_min_rad_s", speed.min(), "rad/s", 0.5, "lowest speed", run.command)
    numbers.add("3_2/speed_max_rad_s", speed.max(), "rad/s", 0.5, "highest speed", run.command)
    numbers.metric("3_2/to_link_j", run, "energy_to_link_j", "J", -0.01, "energy fed back into the link")
    numbers.metric("3_2/from_link_j", run, "energy_from_link_j", "J", -0.01, "energy drawn from the link")


def measure_high_torque(lab: Lab, numbers: Numbers, quick: bool) -> None:
    run = lab.run("3_4_high_torque", trace=True)
    steady_numbers(numbers, "3_4", run)
    stands = run.trace.t_s[np.nonzero(run.trace["flux_min_wb"] < 1.08)[0][-1]]
    numbers.add("3_4/flux_stands_s", stands, "s", 0.02, "flux above 1.08 Wb from then on", run.command)
    if not quick:
        steady_numbers(numbers, "3_4/sampled", lab.run("3_4_high_torque", SAMPLED, trace=True))


def measure_negative(lab: Lab, numbers: Numbers, quick: bool) -> None:
    """Sectors that start on the vectors."""
    run = lab.run("sector_start_0", trace=True)
    flux_numbers(numbers, "v1", run)
    numbers.metric("sector_start_0/response_ms", run, "response_time_ms", "ms", 0.02, "95 % of 15 N·m")
    failed = lab.run("sector_start_0_negative", {"duration_s": 0.21} if quick else {}, trace=not quick)
    if not quick:
        numbers.metric(
            "sector_start_0/negative_bias_nm", failed, "torque_bias_nm", "N·m", 0.1, "torque error of -15 N·m"
        )
        numbers.metric("sector_start_0/negative_flux_wb", failed, "flux_max_wb", "Wb", 0.001, "largest flux at -15 N·m")
        numbers.metric(
            "sector_start_0/negative_leg_hz", failed, "switching_frequency_hz", "Hz", -0.1, "switching of a leg at it"
        )
        back = lab.run(
            "sector_start_0",
            {"profile.torque_nm.value": -15, "event_exact.initial_flux_wb": 1.1, "load.torque_nm.points": "[[0, 0]]"},
        )
        numbers.metric(
            "sector_start_0/reverse_bias_nm", back, "torque_bias_nm", "N·m", 0.5, "torque error of -15 N·m, magnetised"
        )
        numbers.metric(
            "sector_start_0/reverse_flux_wb", back, "flux_min_wb", "Wb", 0.05, "least flux at -15 N·m, magnetised"
        )
