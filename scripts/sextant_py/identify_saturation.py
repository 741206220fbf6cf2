"""Saturation of the main flux from the stator inductance at several fluxes without torque.

The law of `control.machine_estimate.saturation`,
  1/L_s(ψ) = (1 + (ψ/ψ_k)^S)/L_su,
is linear in 1/L_su and 1/(L_su ψ_k^S) for each S, a whole number: least squares of relative deviations, with the S that
leaves the least.
"""

import math
from dataclasses import dataclass

import numpy as np

from .identify_no_load import NoLoad

# Of the whole flux, at which a coasting shaft is measured; the last one is the whole, where L_m is that of the file.
SHARES = (0.45, 0.65, 0.8, 0.9, 1.0)
EXPONENTS = range(2, 21)
CERTAIN = 3  # standard deviations that the curve bends by at least
LEAST_BEND = 0.03  # (ψ/ψ_k)^S at the whole flux, below which no curve is told


@dataclass(frozen=True)
class Saturation:
    knee_wb: float
    knee_sigma_wb: float  # at this exponent
    exponent: int
    machine_flux_wb: float  # where the inductance is that of the machine's keys
    rest: float  # relative standard deviation of a measured inductance about the curve

    def ratio(self, flux: np.ndarray) -> np.ndarray:
        """L_s by that at `machine_flux_wb`."""
        return (1 + (self.machine_flux_wb / self.knee_wb) ** self.exponent) / (
            1 + (np.asarray(flux) / self.knee_wb) ** self.exponent
        )


@dataclass(frozen=True)
class _Line:
    """The fit with one exponent: 1/L_su, and what the iron adds at the whole flux, both by L_s there."""

    exponent: int
    linear: float
    bend: float
    covariance: np.ndarray
    rest: float


def _line(exponent: int, share: np.ndarray, inverse: np.ndarray, noise: float) -> _Line:
    rows = np.stack([np.ones_like(share), share**exponent], axis=1) / inverse[:, None]
    (linear, bend), *_ = np.linalg.lstsq(rows, np.ones_like(share), rcond=None)
    away = rows @ np.array([linear, bend]) - 1
    rest = max(noise, math.sqrt(float(away @ away) / max(1, share.size - 3)))
    return _Line(exponent, float(linear), float(bend), rest**2 * np.linalg.inv(rows.T @ rows), rest)


def fit(points: list[NoLoad]) -> Saturation | None:
    """Of measurements at rising fluxes, the last at the whole flux; None where the iron shows no certain saturation."""
    whole = points[-1]
    share = np.array([point.flux_wb for point in points]) / whole.flux_wb
    inverse = whole.l_s / np.array([point.l_s for point in points])
    noise = math.sqrt(sum(point.sigma**2 for point in points) / len(points))
    best = min((_line(exponent, share, inverse, noise) for exponent in EXPONENTS), key=lambda line: line.rest)
    deviation = math.sqrt(best.covariance[1, 1])
    if not best.linear > 0 or best.bend < max(CERTAIN * deviation, LEAST_BEND * best.linear):
        return None
    knee = whole.flux_wb * (best.linear / best.bend) ** (1 / best.exponent)
    slopes = np.array([1 / best.linear, -1 / best.bend]) / best.exponent
    sigma = knee * math.sqrt(float(slopes @ best.covariance @ slopes))
    return Saturation(knee, sigma, best.exponent, whole.flux_wb, best.rest)
