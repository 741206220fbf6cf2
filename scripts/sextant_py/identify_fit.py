"""Dead time and stator resistance from levels of direct current, by least squares.

With a direct current i along phase a, which leaves by b and c, and the mean commanded voltage u along it
  u = c + R i + (4/3)(u_dc t_d/T + V_t) sign(i)
t_d is the dead time, V_t the threshold voltage of the inverter, T the control period; R is the stator's resistance and
the slope resistance of the inverter together, c what has not settled. V_t has to be known: a dead time that is longer
by V_t T/u_dc makes the same voltage at the same link.
"""

import math
from dataclasses import dataclass

import numpy as np

from .errors import UserError
from .identify_machine import without_slope

CERTAIN = 4.0  # standard deviations of the readings by which a current whose sign counts is off zero [-]
LESS = 0.1  # of the threshold voltage, that a leg may take less than it
FEWEST = 2  # levels of each sign that a line needs


@dataclass(frozen=True)
class Level:
    """Means over the time for which a level was held."""

    current_a: float
    voltage_v: float  # commanded
    link_v: float
    scatter_a: float  # standard deviation of the current's readings
    drift_v: float  # by how much the voltage rose from the first half to the second


@dataclass(frozen=True)
class Setup:
    """What the fit takes as known."""

    period_s: float
    leakage_h: float  # σL_s
    threshold_v: float = 0.0
    slope_ohm: float = 0.0


@dataclass(frozen=True)
class Found:
    """What the levels tell, each with its standard deviation."""

    dead_time_s: float
    dead_time_sigma_s: float
    r_s_ohm: float
    r_s_sigma_ohm: float
    offset_v: float  # c
    voltage_error_v: float  # of the stator voltage along the current, as the drive counts it
    link_v: float
    used: tuple[bool, ...]  # of the levels

    def voltage(self, current_a: np.ndarray, setup: Setup) -> np.ndarray:
        """The fit. [V]"""
        of_a_leg = self.link_v * self.dead_time_s / setup.period_s + setup.threshold_v
        return self.offset_v + (self.r_s_ohm + setup.slope_ohm) * current_a + 4 / 3 * of_a_leg * np.sign(current_a)


def least_current(level: Level, dead_time_s: float, setup: Setup) -> float:
    """Current along phase a, half of which flows in b and c, from which on no current of a period changes its sign.

    During the dead time of all legs the current changes by (2/3) u_dc t_d/σL_s; the readings scatter. [A]
    """
    ripple = 2 / 3 * level.link_v * max(0.0, dead_time_s) / setup.leakage_h
    return 2 * (ripple + CERTAIN * level.scatter_a)


def _solve(levels: list[Level], setup: Setup) -> Found:
    current = np.array([level.current_a for level in levels])
    link = np.array([level.link_v for level in levels])
    sign = np.sign(current)
    known = 4 / 3 * setup.threshold_v * sign + setup.slope_ohm * current
    measured = np.array([level.voltage_v for level in levels]) - known
    columns = np.column_stack([np.ones_like(current), current, 4 / 3 * link / setup.period_s * sign])
    scale = np.linalg.norm(columns, axis=0)
    scaled = columns / scale
    values = np.linalg.lstsq(scaled, measured, rcond=None)[0] / scale
    rest = measured - columns @ values
    drift = np.array([level.drift_v for level in levels])
    variance = float(rest @ rest) / (len(levels) - len(values)) + float(np.mean(drift**2))
    covariance = variance * np.linalg.inv(scaled.T @ scaled) / np.outer(scale, scale)
    sigma = np.sqrt(np.diag(covariance))
    mean_link = float(np.mean(link))
    # The drive counts the fundamental of a square wave of a leg's voltage.
    leg_sigma = mean_link * sigma[2] / setup.period_s
    error = math.hypot(4 / math.pi * leg_sigma, math.sqrt(variance))
    return Found(
        float(values[2]), float(sigma[2]), float(values[1]), float(sigma[1]), float(values[0]),
        error, mean_link, (True,) * len(levels),
    )  # fmt: skip


def _has_line(levels: list[Level]) -> bool:
    signs = [math.copysign(1, level.current_a) for level in levels]
    return min(signs.count(1.0), signs.count(-1.0)) >= FEWEST


def _check_threshold(found: Found, setup: Setup) -> None:
    """No dead time is below zero: a leg takes the threshold voltage at least."""
    missing = -found.link_v * found.dead_time_s / setup.period_s
    if setup.threshold_v > 0 and missing > LESS * setup.threshold_v:
        raise UserError(
            f"a leg of the inverter takes {setup.threshold_v - missing:.3g} V, less than the threshold voltage of "
            f"{setup.threshold_v:g} V (--threshold-v, drive.inverter.threshold_v): lower that."
        )


def fit(levels: list[Level], setup: Setup) -> Found:
    """Levels of which a current might change its sign within a period are left out, by the dead time of the fit."""
    used = list(levels)
    found = None
    while _has_line(used):
        found = _solve(used, setup)
        certain = [one for one in used if abs(one.current_a) > least_current(one, found.dead_time_s, setup)]
        if len(certain) == len(used):
            _check_threshold(found, setup)
            without_slope(found.r_s_ohm + setup.slope_ohm, setup.slope_ohm)
            kept = {id(one) for one in used}
            return Found(**{**vars(found), "used": tuple(id(one) in kept for one in levels)})
        used = certain
    dead_time = found.dead_time_s if found else 0.0
    needed = max((least_current(one, dead_time, setup) for one in levels), default=0.0)
    raise UserError(
        f"fewer than {FEWEST} levels of each sign have a current whose sign is certain, which takes more than "
        f"{needed:.3g} A here; raise control.commissioning.current_limit_a."
    )
