"""Constant torque at constant speed: ripple, the speed up to which it is the band, and pulse frequency (paper, 3)."""

import numpy as np

from .lab import SAMPLED, Lab, Settings
from .numbers import Numbers
from .steps import crossing

HB = 0.918
BANDS = (0.5, HB, 1.0)
TORQUES = (2, 5, 15, 30, 50, 80, 100, 130)
QUICK_TORQUES = (15, 130)
SPEEDS = tuple(range(0, 131, 5))
QUICK_SPEEDS = (10, 30, 70)
PAPER_KHZ = 39.73
HB_COMMAND = "sextant-mil configs/scenarios/paper/hb_0_918.toml"
HELD_NM = 0.96  # ripple up to which the band counts as held: HB and the dwell's share of it
POINTS = ((15, 10), (15, 27), (15, 50), (50, 30), (130, 30))  # torque, speed of the halving


def at(torque: float, speed: float, band: float = HB) -> Settings:
    return {
        "plant.integrator": "fixed",
        "profile.torque_nm.value": torque,
        "load.speed_rad_s.value": speed,
        "control.dtc.torque_band_upper_nm": band,
        "control.dtc.torque_band_lower_nm": band,
        "protection.over_current_a": 1000,
    }


def interpolated(half: float, full: float) -> float:
    """The paper's estimate at HB 0.918: a straight line between the frequencies at 0.5 and at 1 N·m."""
    return full + (half - full) * (1 - HB) / 0.5


def measure_halving(lab: Lab, numbers: Numbers, quick: bool) -> None:
    bands = {"hb_1": 1.0, "hb_0_5": 0.5, "hb_0_918": HB}
    runs = {name: lab.run(name) for name in bands}
    for name, run in runs.items():
        n = numbers.at(name, run)
        n.metric("ripple_pp_nm", "torque_ripple_pp_nm", "N·m", 0.02, "ripple at 15 N·m, 27 rad/s")
        n.metric("ripple_rms_nm", "torque_ripple_rms_nm", "N·m", 0.005, "the same, RMS")
        n.metric("bias_nm", "torque_bias_nm", "N·m", 0.01, "mean torque error")
        n.metric("pulse_hz", "torque_pulse_frequency_hz", "Hz", -0.01, "pulses of the comparator")
        n.metric("leg_hz", "switching_frequency_hz", "Hz", -0.01, "switching frequency of a leg")
    full, half, middle = runs.values()
    n = numbers.at("", command=f"{half.command}; {full.command}")
    for key in ("pp", "rms"):
        metric = f"torque_ripple_{key}_nm"
        n.add(f"halving/{key}", half[metric] / full[metric], "1", 0.01, "ripple at HB 0.5 by ripple at HB 1")
    pulse = "torque_pulse_frequency_hz"
    line = interpolated(half[pulse], full[pulse])
    n.add("interpolation/line_hz", line, "Hz", -0.01, "straight line at HB 0.918, 15 N·m, 27 rad/s")
    share = 100 * (line / middle[pulse] - 1)
    numbers.at("interpolation", middle).add("excess_percent", share, "%", 1, "line above what HB 0.918 has")
    if quick:
        return
    literal = lab.run("hb_0_918", {"control.dtc.comparator_reading": "memoryless", "plant.integrator": "fixed"})
    n = numbers.at("memoryless", literal)
    for metric, unit, wide in (
        ("torque_ripple_pp_nm", "N·m", 0.02),
        ("torque_bias_nm", "N·m", 0.02),
        (pulse, "Hz", -0.1),
    ):
        n.metric(metric, metric, unit, wide, f"{metric}, equations 2 to 4 to the letter")
    pairs = [(t, w, lab.run("hb_1", at(t, w, 0.5)), lab.run("hb_1", at(t, w, 1.0))) for t, w in POINTS]
    for torque, speed, half, full in pairs:
        ratio = half["torque_ripple_pp_nm"] / full["torque_ripple_pp_nm"]
        meaning = f"the same at {torque} N·m, {speed} rad/s"
        numbers.at("halving/at", half).add(f"{torque}/{speed}", ratio, "1", 0.02, meaning)
    run = lab.run("hb_0_918", sampled_at(15, 27) | {"trace.interval_us": 25}, trace=True)
    change = abs(np.diff(run.trace.between(0.5, 0.8)["torque_nm"])).max()
    numbers.at("sampled", run).add("largest_change_nm", change, "N·m", 0.3, "change of torque in 25 us, at most")
    for name, band in bands.items():
        n = numbers.at(f"{name}/sampled", lab.run("hb_0_918", sampled_at(15, 27, band)))
        n.metric("ripple_pp_nm", "torque_ripple_pp_nm", "N·m", 0.5, "sampled at 25 us")
        n.metric("pulse_hz", "torque_pulse_frequency_hz", "Hz", -0.05, "sampled at 25 us")
        n.metric("leg_hz", "switching_frequency_hz", "Hz", -0.05, "sampled at 25 us")


def sampled_at(torque: float, speed: float, band: float = HB) -> Settings:
    """From a dead machine: the window begins when the flux stands."""
    return at(torque, speed, band) | SAMPLED | {"duration_s": 0.8, "metrics.window_from_s": 0.5}


def holds(lab: Lab, torque: float, speed: float) -> bool:
    return lab.run("hb_0_918", at(torque, speed))["torque_ripple_pp_nm"] < HELD_NM


def measure_ripple(lab: Lab, numbers: Numbers, quick: bool) -> None:
    speeds = (10, 30) if quick else tuple(range(10, 121, 10))
    points = [(t, w) for t in (QUICK_TORQUES if quick else (15, 50, 130)) for w in speeds]
    ripple = "torque_ripple_pp_nm"
    runs = lab.run_all([("hb_0_918", at(t, w)) for t, w in points])
    for (torque, speed), run in zip(points, runs, strict=True):
        meaning = f"ripple at {torque} N·m, {speed} rad/s"
        tolerance = 0.02 if run[ripple] < 1 else 0.2
        numbers.at("ripple", run).metric(f"{torque}/{speed}", ripple, "N·m", tolerance, meaning)
    if quick:
        return
    sampled = lab.run_all([("hb_0_918", sampled_at(t, w)) for t, w in points])
    for (torque, speed), run in zip(points, sampled, strict=True):
        meaning = f"ripple at {torque} N·m, {speed} rad/s, sampled at 25 us"
        numbers.at("ripple_sampled", run).metric(f"{torque}/{speed}", ripple, "N·m", 0.5, meaning)
    for torque in TORQUES:
        measure_limit(lab, numbers, torque)
    excess = max(numbers[f"limit_speed/{t}"] - numbers[f"limit_speed_calculated/{t}"] for t in TORQUES)
    command = "the numbers of limit_speed and limit_speed_calculated"
    numbers.add("limit_speed_excess", excess, "rad/s", 2, "measured above calculated, at most", command)


def measure_limit(lab: Lab, numbers: Numbers, torque: float) -> None:
    limit = crossing(20, 100, lambda speed: holds(lab, torque, speed), 8)
    n = numbers.at("limit_speed", command=f"{HB_COMMAND} --set load.speed_rad_s.value=…, bisected")
    n.add(f"{torque}", limit, "rad/s", 2, f"speed up to which the ripple at {torque} N·m is below {HELD_NM} N·m")
    n = numbers.at("limit_speed_calculated", command="weakest_vector_speed of scripts/studies/paper/steady.py")
    meaning = f"speed at which the sector's weakest vector no longer raises {torque} N·m"
    n.add(f"{torque}", weakest_vector_speed(torque), "rad/s", 0.1, meaning)


def weakest_vector_speed(torque: float, psi: float = 1.1, u_dc: float = 530) -> float:
    """Speed at which the weakest voltage vector of a centred sector just holds the torque. [rad/s]

    From T = 3/2 p k ψ_r × ψ_s, k = L_m/(σ L_s L_r), and both flux equations in the stationary frame:
    dT/dt ∝ ψ_r' × ψ_s + ψ_r × (u − R_s i_s), least where u lies 150 degrees ahead of ψ_s.
    """
    r_s, r_r, pole_pairs, reactance = 0.435, 0.816, 2, 1 / (2 * np.pi * 50)  # paper, Table 2
    l_m, l_s = 26.13 * reactance, (26.13 + 0.754) * reactance
    determinant = l_s * l_s - l_m * l_m
    k = l_m / determinant
    # Steady state with ψ_s along the real axis: ψ_r = ψ_s L_m/(L_s + j ω_slip (L_s L_r − L_m²)/R_r).
    slip = crossing(0, 200, lambda w: steady_torque(w, psi, l_m, l_s, r_r, determinant, pole_pairs) < torque, 60)
    psi_r = psi * l_m / (l_s + 1j * slip * determinant / r_r)
    i_s = (l_s * psi - l_m * psi_r) / determinant
    i_r = (l_s * psi_r - l_m * psi) / determinant
    u = 2 / 3 * u_dc * np.exp(1j * np.deg2rad(150))

    def cross(a: complex, b: complex) -> float:
        return (np.conj(a) * b).imag

    def torque_slope(omega: float) -> float:
        psi_r_slope = -r_r * i_r + 1j * pole_pairs * omega * psi_r
        return 1.5 * pole_pairs * k * (cross(psi_r_slope, psi) + cross(psi_r, u - r_s * i_s))

    return crossing(0, 200, lambda w: torque_slope(w) > 0, 60)


def steady_torque(slip, psi, l_m, l_s, r_r, determinant, pole_pairs) -> float:
    psi_r = psi * l_m / (l_s + 1j * slip * determinant / r_r)
    i_s = (l_s * psi - l_m * psi_r) / determinant
    return 1.5 * pole_pairs * psi * i_s.imag


def measure_frequency(lab: Lab, numbers: Numbers, quick: bool) -> None:
    speeds = QUICK_SPEEDS if quick else SPEEDS
    points = [(15, w, b) for b in BANDS for w in speeds]
    if not quick:
        points += [(t, w, HB) for t in (5, 50, 130) for w in speeds]
    runs = lab.run_all([("hb_0_918", at(*p)) for p in points])
    for (torque, speed, band), run in zip(points, runs, strict=True):
        meaning = f"{torque} N·m, {speed} rad/s, HB {band:g} N·m"
        # At rest the flux wanders for seconds: no frequency to hold anybody to.
        tolerance = -0.015 if speed >= 10 else -0.2
        n, tail = numbers.at("", run), f"{torque}/{band:g}/{speed}"
        n.metric(f"pulse/{tail}", "torque_pulse_frequency_hz", "Hz", tolerance, f"pulses of the comparator, {meaning}")
        n.metric(f"leg/{tail}", "switching_frequency_hz", "Hz", tolerance, f"switching of a leg, {meaning}")
    if quick:
        return
    half, full = (np.array([numbers[f"pulse/15/{b:g}/{w}"] for w in speeds]) for b in (0.5, 1.0))
    line = interpolated(half, full) / 1e3 - PAPER_KHZ
    met = [k for k in range(len(speeds) - 1) if line[k] * line[k + 1] < 0]
    n = numbers.at("", command=f"{HB_COMMAND} --set plant.integrator=fixed --set load.speed_rad_s.value=…")
    for number, k in enumerate(met):
        speed = speeds[k] + (speeds[k + 1] - speeds[k]) * line[k] / (line[k] - line[k + 1])
        n.add(f"met/{number}", speed, "rad/s", 1, "15 N·m: the line between HB 0.5 and 1 passes 39.73 kHz")
    law = np.array([[numbers[f"pulse/15/{b:g}/{w}"] * b for b in BANDS] for w in speeds if 10 <= w <= 70])
    spread = 100 * (law.max(axis=1) / law.min(axis=1) - 1).max()
    n.add("law/spread_percent", spread, "%", 1, "frequency times HB over the three bands, 10 to 70 rad/s")
    legs = np.array([numbers[f"leg/15/{HB:g}/{w}"] / numbers[f"pulse/15/{HB:g}/{w}"] for w in speeds if w >= 10])
    n.add("legs/least_share", legs.min(), "1", 0.02, "switching of a leg by pulses, least over speed")
    n.add("legs/largest_share", legs.max(), "1", 0.02, "the same, largest")
    half, full = ([numbers[f"leg/15/{b:g}/{w}"] for w in speeds] for b in (0.5, 1.0))
    n.add("legs/highest_at_half_hz", max(half), "Hz", -0.02, "highest switching of a leg at HB 0.5")
    highest = max(map(interpolated, half, full))
    n.add("legs/highest_line_hz", highest, "Hz", -0.02, "highest straight line of a leg at HB 0.918")
