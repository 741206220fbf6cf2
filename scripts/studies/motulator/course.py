"""The course of a run of either drive by control periods, and its figures, taken from both in the same way."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from sextant_py.signal_file import load


@dataclass(frozen=True)
class Course:
    """One entry a control period; torque within the period, the other quantities at its end."""

    end_s: np.ndarray
    torque_mean_nm: np.ndarray
    torque_min_nm: np.ndarray
    torque_max_nm: np.ndarray
    flux_wb: np.ndarray  # magnitude, mean of the period
    psi_s_wb: np.ndarray  # complex, stationary frame
    i_s_a: np.ndarray  # complex, stationary frame
    energy_j: np.ndarray  # into the machine, since some instant

    def within(self, begin_s: float, end_s: float) -> "Course":
        """The periods that lie in this span."""
        half = 0.5 * (self.end_s[1] - self.end_s[0])
        kept = (self.end_s > begin_s + half) & (self.end_s < end_s + half)
        return Course(*(values[kept] for values in self.__dict__.values()))


def of_trace(file: Path) -> Course:
    """Of a trace of sextant-mil with a row a control period."""
    signals = load(file)
    v = {name.removeprefix("plant/"): value for name, value in signals.values.items() if name.startswith("plant/")}
    return Course(
        signals.time_s,
        v["torque_mean_nm"],
        v["torque_min_nm"],
        v["torque_max_nm"],
        v["flux_mean_wb"],
        v["psi_s_alpha_wb"] + 1j * v["psi_s_beta_wb"],
        v["i_a_a"] + 1j * (v["i_b_a"] - v["i_c_a"]) / np.sqrt(3),
        v["energy_link_j"],
    )


def of_points(points: dict[str, np.ndarray], period_s: float) -> Course:
    """Of the points of motulator's solver, between which torque and power count as linear."""
    t = points["t_s"]
    first, last = (int(np.ceil(t[0] / period_s - 1e-6)), int(np.floor(t[-1] / period_s + 1e-6)))
    # The solver's steps meet the control instants but for rounding; of two points at one instant the later is meant.
    at = np.searchsorted(t, np.arange(first, last + 1) * period_s + 1e-3 * period_s) - 1
    begin, end = at[:-1], at[1:]

    def integral(values: np.ndarray) -> np.ndarray:
        return np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]) * np.diff(t))])

    def mean(values: np.ndarray) -> np.ndarray:
        return (integral(values)[end] - integral(values)[begin]) / (t[end] - t[begin])

    def extreme(reduce: np.ufunc, values: np.ndarray) -> np.ndarray:
        return reduce(reduce.reduceat(values, at)[:-1], values[end])

    power = 1.5 * np.real(points["u_s_v"] * np.conj(points["i_s_a"]))
    torque = points["torque_nm"]
    return Course(
        t[end],
        mean(torque),
        extreme(np.minimum, torque),
        extreme(np.maximum, torque),
        mean(np.abs(points["psi_s_wb"])),
        points["psi_s_wb"][end],
        points["i_s_a"][end],
        integral(power)[end],
    )


def ripple_rms(t_s: np.ndarray, torque_nm: np.ndarray) -> float:
    """RMS about the mean of a torque that is linear between its points. [N·m]"""
    dt = np.diff(t_s)
    mean = np.sum(0.5 * (torque_nm[1:] + torque_nm[:-1]) * dt) / np.sum(dt)
    a, b = torque_nm[:-1] - mean, torque_nm[1:] - mean
    return float(np.sqrt(np.sum((a * a + a * b + b * b) / 3 * dt) / np.sum(dt)))


def steady(course: Course, rotor_rad_s: float) -> dict[str, float]:
    """Mean values of a course in a steady state. rotor_rad_s: electrical speed of the rotor."""
    span = course.end_s[-1] - course.end_s[0]
    stator = float(np.sum(np.angle(course.psi_s_wb[1:] / course.psi_s_wb[:-1])) / span)
    return {
        "torque_nm": float(np.mean(course.torque_mean_nm)),
        "current_a": float(np.mean(np.abs(course.i_s_a))),
        "flux_wb": float(np.mean(course.flux_wb)),
        "stator_rad_s": stator,
        "slip_rad_s": stator - rotor_rad_s,
        "power_w": float((course.energy_j[-1] - course.energy_j[0]) / span),
    }


def peak_to_peak(course: Course) -> float:
    return float(np.max(course.torque_max_nm) - np.min(course.torque_min_nm))


def pulse_means(course: Course) -> tuple[np.ndarray, np.ndarray]:
    """Mean torque of two control periods, in which each leg switches on and off, and their middles. [s], [N·m]"""
    return course.end_s[:-1], 0.5 * (course.torque_mean_nm[:-1] + course.torque_mean_nm[1:])


def rise(course: Course, step_s: float, torque_nm: float, share: float = 0.95) -> float | None:
    """From the step until the mean torque of two control periods, drawn as straight lines between their middles, has
    covered this share of the step from zero; None where it never does. [ms]"""
    middle, mean = pulse_means(course)
    covered = mean / torque_nm
    beyond = np.flatnonzero((middle > step_s) & (covered >= share))
    if not len(beyond) or beyond[0] == 0:
        return None
    k = beyond[0]
    part = (share - covered[k - 1]) / (covered[k] - covered[k - 1])
    return float(1e3 * (middle[k - 1] + part * (middle[k] - middle[k - 1]) - step_s))


def overshoot(course: Course, step_s: float, torque_nm: float) -> float:
    """Largest mean of two control periods beyond the torque, by the torque. [%]"""
    middle, mean = pulse_means(course)
    return float(100 * max(0.0, np.max(mean[middle > step_s] / torque_nm) - 1))


def curve(course: Course, step_s: float) -> dict[str, list[float]]:
    """For a picture: ends of the periods after the step [ms], mean, least and largest torque in them [N·m]."""
    return {
        "end_ms": np.round(1e3 * (course.end_s - step_s), 6).tolist(),
        "mean": np.round(course.torque_mean_nm, 3).tolist(),
        "min": np.round(course.torque_min_nm, 3).tolist(),
        "max": np.round(course.torque_max_nm, 3).tolist(),
    }
