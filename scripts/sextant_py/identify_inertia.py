"""Inertia from a course of speed under known torque, by least squares.

The free shaft obeys, from the beginning of a window to its end,
  ∫T dt = J Δω + B ∫ω dt + T_c ∫sign(ω) dt + T_l ∫dt
with the drive's estimate T of the torque; B and T_c are friction, not below zero, T_l a constant load. The torque goes
up, down, down and up again by as much, so that the shaft turns in both directions, ends where it began, and friction
shows apart from inertia.

Friction of either kind that least squares make negative is left out and the rest fitted anew: least squares with these
bounds, by C. L. Lawson, R. J. Hanson, "Solving Least Squares Problems", 1974, chapter 23.
"""

import math
from dataclasses import dataclass

import numpy as np

from .errors import UserError

WINDOWS = 16  # over the course
UNKNOWNS = 4
FRICTION = (1, 2)  # of the unknowns
LEAST_TURNING = 0.1  # of the speed that is asked for, below which the shaft counts as held


@dataclass(frozen=True)
class Course:
    """A command of the torque: +T, −T twice as long, +T."""

    torque_nm: float
    begin_s: float  # the flux is there
    part_s: float

    @property
    def points(self) -> list[list[float]]:
        """Of profile.torque_nm, as steps."""
        t = [self.begin_s + k * self.part_s for k in (0, 1, 3, 4)]
        values = (self.torque_nm, -self.torque_nm, self.torque_nm, 0.0)
        return [[0.0, 0.0], *([round(at, 6), value] for at, value in zip(t, values, strict=True))]

    @property
    def end_s(self) -> float:
        return self.begin_s + 4 * self.part_s


@dataclass(frozen=True)
class Inertia:
    inertia: float  # J [kg·m²]
    sigma: float  # its standard deviation
    viscous: float  # B [N·m·s]
    viscous_sigma: float
    coulomb_nm: float  # T_c
    coulomb_sigma_nm: float
    load_nm: float  # T_l
    load_sigma_nm: float
    time_s: np.ndarray
    speed: np.ndarray  # measured [rad/s]
    fitted: np.ndarray  # by the torque and what was found [rad/s]
    torque_nm: np.ndarray

    @property
    def fastest(self) -> float:
        return float(np.max(np.abs(self.speed)))


def _least_squares(columns: np.ndarray, measured: np.ndarray, kept: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Values and their standard deviations, of the columns that are kept; 0 and that of no others."""
    used = columns[:, kept]
    scale = np.linalg.norm(used, axis=0)
    scaled = used / scale
    values, sigmas = np.zeros(kept.size), np.zeros(kept.size)
    values[kept] = np.linalg.lstsq(scaled, measured, rcond=None)[0] / scale
    rest = measured - columns @ values
    variance = float(rest @ rest) / (WINDOWS - UNKNOWNS)
    sigmas[kept] = np.sqrt(variance * np.diag(np.linalg.pinv(scaled.T @ scaled, hermitian=True))) / scale
    return values, sigmas


def _non_negative_friction(columns: np.ndarray, measured: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of J, B, T_c and T_l. What is left out keeps the deviation with which it was negative."""
    kept = np.ones(UNKNOWNS, dtype=bool)
    values, sigmas = _least_squares(columns, measured, kept)
    while np.any(values[list(FRICTION)] < 0):
        kept[[one for one in FRICTION if values[one] < 0]] = False
        values, fewer = _least_squares(columns, measured, kept)
        sigmas[kept] = fewer[kept]
    return values, sigmas


def fit(time: np.ndarray, speed: np.ndarray, torque: np.ndarray) -> Inertia:
    """Of samples [s], [rad/s]; the torque is the mean over the interval before each [N·m]."""
    from scipy.integrate import cumulative_trapezoid

    if time.size < 4 * WINDOWS:
        raise UserError(f"{time.size} samples do not tell the inertia; {4 * WINDOWS} are needed at least.")
    if not np.ptp(speed) > 0:
        raise UserError(
            f"the speed of the shaft stays at {speed[0]:.3g} rad/s under the torque of the course: the inertia needs a "
            "shaft that is free to turn."
        )
    ends = np.linspace(0, time.size - 1, WINDOWS + 1).round().astype(int)
    integrals = (cumulative_trapezoid(values, time, initial=0) for values in (speed, np.sign(speed)))
    sums = [speed, *integrals, time - time[0]]
    columns = np.column_stack([np.diff(one[ends]) for one in sums])
    impulse = np.concatenate([[0.0], np.cumsum(torque[1:] * np.diff(time))])
    measured = np.diff(impulse[ends])
    values, sigmas = _non_negative_friction(columns, measured)
    j, b, coulomb, load = (float(one) for one in values)
    if not (math.isfinite(j) and j > 0):
        raise UserError("the speed does not follow the torque as that of an inertia does: see the trace of the course.")
    fitted = (impulse - b * sums[1] - coulomb * sums[2] - load * sums[3]) / j
    fitted += float(np.mean(speed - fitted))
    j_sigma, *others = (float(one) for one in sigmas)
    pairs = [one for pair in zip((b, coulomb, load), others, strict=True) for one in pair]
    return Inertia(j, j_sigma, *pairs, time, speed, fitted, torque)


def check_turning(fastest: float, wanted: float) -> None:
    """Refuses a shaft that is held. [rad/s]"""
    if fastest < LEAST_TURNING * wanted:
        raise UserError(
            f"the shaft reaches {fastest:.3g} rad/s where {wanted:.3g} rad/s are due: this course needs a shaft "
            "that is free to turn, and machine.inertia_kg_m2 within ten times of it."
        )
