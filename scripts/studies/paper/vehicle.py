"""The New York City Cycle with a vehicle and its driver in place of the paper's look-up tables."""

import math
import tomllib

import numpy as np
from sextant_py.paths import ROOT
from sextant_py.plots.trace import Trace

from . import road_load
from .lab import SAMPLED, Lab, Run
from .numbers import Numbers, Scope

SCENARIO = "3_5_nycc_vehicle"
VEHICLE = ROOT / "configs/vehicles/micro_ev.toml"
MACHINE = ROOT / "configs/machines/paper_3hp.toml"
CYCLE = ROOT / "configs/cycles/nycc.csv"
KMH_PER_MPH = 1.609344
KINDS = {"exact": {}, "sampled": SAMPLED}
FROM_S = 0.2  # where the scenario's window of metrics begins
BRAKING_W = -20.0  # shaft power below which the vehicle brakes; at rest it is nearer to zero
METRICS = (
    ("speed_error_rms_rad_s", "rad/s", -0.05, "RMS of the speed error"),
    ("torque_error_max_nm", "N·m", -0.2, "largest torque error"),
    ("torque_error_rms_nm", "N·m", -0.05, "RMS of the torque error"),
    ("energy_from_link_j", "J", -0.02, "integral of the link's positive power"),
    ("energy_to_link_j", "J", -0.05, "integral of the link's negative power"),
    ("energy_shaft_j", "J", -0.02, "net work on the shaft"),
    ("energy_copper_j", "J", -0.05, "lost in the windings"),
    ("peak_current_a", "A", -0.05, "largest phase current"),
)


def wheel_radius_m() -> float:
    return float(tomllib.loads(VEHICLE.read_text(encoding="utf-8"))["wheel_radius_m"])


def vehicle_run(lab: Lab, kind: str) -> Run:
    return lab.run(SCENARIO, KINDS[kind], trace=True)


def speeds(trace: Trace) -> tuple[np.ndarray, np.ndarray]:
    """Of the cycle and of the vehicle at the end of each row. [km/h]"""
    t_s, mph = np.loadtxt(CYCLE, delimiter=",", skiprows=2, unpack=True)
    return np.interp(trace.t_s, t_s, KMH_PER_MPH * mph), 3.6 * wheel_radius_m() * trace["omega_m_rad_s"]


def shaft_power(trace: Trace) -> np.ndarray:
    """Mean of each row, with the speed half-way. [W]"""
    omega = trace["omega_m_rad_s"]
    return trace["torque_mean_nm"] * 0.5 * (omega + np.concatenate((omega[:1], omega[:-1])))


def braking_energies(trace: Trace) -> tuple[float, float, float]:
    """Taken from the shaft while braking; of it into the link, by rows that feed back and on balance. [J]"""
    braking = shaft_power(trace) < BRAKING_W
    seconds = np.diff(trace.t_s, prepend=trace.t_s[0])[braking]
    shaft, link = shaft_power(trace)[braking], trace["power_w"][braking]
    return tuple(-float(np.sum(seconds * power)) for power in (shaft, np.minimum(link, 0), link))


def magnetising(flux_wb: np.ndarray | float) -> tuple[np.ndarray | float, np.ndarray | float]:
    """Amplitude of the current that makes this stator flux without torque, and its loss. [A, W]"""
    machine = tomllib.loads(MACHINE.read_text(encoding="utf-8"))
    inductance = (machine["x_ls_ohm"] + machine["x_m_ohm"]) / (2 * math.pi * machine["reactance_frequency_hz"])
    current = flux_wb / inductance
    return current, 1.5 * machine["r_s_ohm"] * current**2


def fit_numbers(numbers: Numbers) -> None:
    load = road_load.fit()
    n = numbers.at("vehicle/fit", command="python -m studies.paper.road_load, in scripts/")
    for name, value, unit, tolerance, meaning in (
        ("radius_m", load.wheel_radius_m, "m", 1e-4, "wheel radius, from speed by rpm"),
        ("rolling", load.rolling_coefficient, "1", 1e-4, "rolling coefficient, not below zero"),
        ("drag_area_m2", load.drag_area_m2, "m²", 1e-3, "drag area"),
        ("rms_nm", load.rms_nm, "N·m", 0.01, "RMS of the residuals"),
        ("worst_nm", load.worst_nm, "N·m", 0.01, "largest residual"),
    ):
        n.add(name, value, unit, tolerance, f"{meaning}, Table 5")
    for k, (speed, torque, residual) in enumerate(zip(load.speed_m_s, load.torque_nm, load.residual_nm, strict=True)):
        state = f"steady state {k + 1} of Table 5"
        for name, value, unit, meaning in (
            ("speed_kmh", 3.6 * speed, "km/h", "speed"),
            ("torque_nm", torque, "N·m", "torque of the table"),
            ("fit_nm", torque - residual, "N·m", "torque of the fit"),
            ("residual_nm", residual, "N·m", "table minus fit"),
        ):
            n.add(f"{k + 1}/{name}", value, unit, 0.01, f"{meaning}, {state}")


def run_numbers(n: Scope, run: Run) -> None:
    for metric, unit, tolerance, meaning in METRICS:
        n.metric(metric, metric, unit, tolerance, f"{meaning}, NYCC with vehicle and driver, one motor")
    trace = run.trace
    wanted, reached = speeds(trace)
    error, radius = np.abs(reached - wanted), wheel_radius_m()
    rms = run["speed_error_rms_rad_s"] * radius
    n.add("speed_error_rms_m_s", rms, "m/s", -0.05, "RMS of the speed error, at the wheel")
    n.add("speed_error_max_kmh", error.max(), "km/h", 0.02, "largest speed error, rows of 10 ms")
    n.add("speed_error_max_s", trace.t_s[error.argmax()], "s", None, "when that is")
    late = trace.between(FROM_S, math.inf)
    worst = np.maximum(-late.error[0], late.error[1]).argmax()
    n.add("torque_error_max_s", late.t_s[worst], "s", None, "when the torque error is largest")
    net, shaft = run["energy_from_link_j"] - run["energy_to_link_j"], run["energy_shaft_j"]
    n.add("net_j", net, "J", -0.02, "from minus to the link")
    n.add("shaft_w", shaft / run["simulated_s"], "W", -0.02, "mean power on the shaft")
    n.add("efficiency_percent", 100 * shaft / net, "%", 1, "shaft / (from - to)")
    closed = 100 * (net - shaft - run["energy_copper_j"] - run["energy_field_j"]) / net
    n.add("balance_percent", closed, "%", 0.2, "neither shaft nor copper nor field, of (from - to)")
    account_numbers(n, late)


def account_numbers(n: Scope, trace: Trace) -> None:
    """What the trace says of braking and of the flux."""
    seconds, power = np.diff(trace.t_s, prepend=trace.t_s[0]), trace["power_w"]
    out, back = (float(np.sum(seconds * np.maximum(sign * power, 0))) for sign in (1, -1))
    n.add("from_10_ms_j", out, "J", -0.02, "drawn from the link, means of 10 ms")
    n.add("to_10_ms_j", back, "J", -0.05, "fed back into the link, means of 10 ms")
    shaft, fed_back, balance = braking_energies(trace)
    n.add("braking_j", shaft, "J", -0.02, f"taken from the shaft below {BRAKING_W:g} W")
    meaning = "rows of 10 ms that feed the link, by the energy taken from the shaft, while braking"
    n.add("recovered_percent", 100 * fed_back / shaft, "%", 2, meaning)
    meaning = "the same less what the other rows draw, while braking"
    n.add("recovered_net_percent", 100 * balance / shaft, "%", 2, meaning)
    lost = float(np.sum(seconds * magnetising(trace["flux_mean_wb"])[1]))
    n.add("magnetising_j", lost, "J", -0.05, "loss of the current that makes the flux")
    low = 100 * float(np.mean(trace["flux_mean_wb"] < 0.95 * 1.1))
    n.add("flux_low_percent", low, "%", 1, "share of the time with the flux below 95 %")


def measure_vehicle(lab: Lab, numbers: Numbers, quick: bool) -> None:
    """Road load of Table 5, and the cycle with it."""
    fit_numbers(numbers)
    current, loss = magnetising(1.1)
    n = numbers.at("vehicle", command="1.1 Wb / L_s and 3/2 R_s i², configs/machines/paper_3hp.toml")
    n.add("magnetising_a", current, "A", 0.01, "magnetising current at 1.1 Wb, amplitude")
    n.add("magnetising_w", loss, "W", 0.1, "its loss in the stator")
    if not quick:
        for kind in KINDS:
            run = vehicle_run(lab, kind)
            run_numbers(numbers.at(f"vehicle/{kind}", run), run)
