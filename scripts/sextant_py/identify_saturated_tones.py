"""Leakage inductance and rotor resistance from the tones, where the iron is known to saturate.

A tone above a direct current moves the flux along the curve, whose chord and slope differ. In the Γ circuit, with
m(ψ) = ψ/L_s(ψ) and the current i given,
  ψ_R = ψ + L_σ (m(ψ) − i),   dψ_R/dt = R_R (i − m(ψ))
so that over a cycle ψ is the periodic solution of
  d/dt (ψ + L_σ m(ψ) − L_σ i) + R_R (m(ψ) − i) = 0,   u = R i + dψ/dt
by Newton's method at the points of a cycle, with the derivative of the trigonometric polynomial through them (L. N.
Trefethen, Spectral Methods in MATLAB, Philadelphia 2000, chapter 3). The fundamental of u by that of i takes the place
of the linear machine's impedance; what sampling does to that is taken from the linear machine.
"""

import math
from dataclasses import replace

import numpy as np

from .identify_impedance import Impedance, Timing, Tone, sampled_impedance
from .identify_machine import InverseGamma
from .identify_no_load import NoLoad
from .identify_saturation import Saturation

POINTS = 65  # of a cycle; an odd number, whose polynomial has no part at half of the sampling rate
ITERATIONS = 40
ENDS_AT = 1e-12  # change of the flux, by the whole


def _derivative() -> np.ndarray:
    """Of a periodic function at POINTS of a cycle of 2π."""
    k = np.arange(POINTS)
    away = k[:, None] - k[None, :]
    with np.errstate(divide="ignore"):
        matrix = 0.5 * (-1.0) ** away / np.sin(math.pi * away / POINTS)
    np.fill_diagonal(matrix, 0.0)
    return matrix


class Iron:
    """The magnetising current of a flux, and its slope."""

    def __init__(self, no_load: NoLoad, curve: Saturation) -> None:
        self.whole, self.l_s, self.curve = no_load.flux_wb, no_load.l_s, curve

    def current(self, flux: np.ndarray) -> np.ndarray:
        """[A]"""
        return flux / (self.l_s * self.curve.ratio(np.abs(flux)))

    def slope(self, flux: np.ndarray) -> np.ndarray:
        """[A/Wb]"""
        y = (np.abs(flux) / self.curve.knee_wb) ** self.curve.exponent
        return (1 + self.curve.exponent * y / (1 + y)) / (self.l_s * self.curve.ratio(np.abs(flux)))

    def flux(self, current: float) -> float:
        """Of a direct current. [Wb]"""
        most = 4 * self.whole
        fluxes = np.linspace(0, most, 4001)
        return float(np.interp(abs(current), self.current(fluxes), fluxes)) * (1 if current >= 0 else -1)


def impedance(iron: Iron, tone: Tone, resistance: float, leakage: float, rotor: float) -> complex:
    """Voltage by current at the fundamental, of the Γ circuit. [ohm]"""
    angle = 2 * math.pi * np.arange(POINTS) / POINTS
    current = tone.mean_current_a + tone.amplitude_a * np.sin(angle)
    derivative = tone.omega * _derivative()
    flux = np.full(POINTS, iron.flux(tone.mean_current_a))
    fixed = leakage * derivative @ current + rotor * current
    for _ in range(ITERATIONS):
        slope = iron.slope(flux)
        magnetising = iron.current(flux)
        left = derivative @ (flux + leakage * magnetising) + rotor * magnetising - fixed
        change = np.linalg.solve(derivative * (1 + leakage * slope)[None, :] + np.diag(rotor * slope), left)
        flux = flux - change
        if np.max(np.abs(change)) < ENDS_AT * iron.whole:
            break
    turn = np.exp(-1j * angle)
    return resistance + 1j * tone.omega * complex(np.sum(turn * flux) / np.sum(turn * current))


def _linear(machine: InverseGamma, omega: float) -> complex:
    """Of the machine without saturation. [ohm]"""
    branch = 1 / (1 / (1j * omega * machine.l_magnetising) + 1 / machine.r_rotor)
    return machine.r_s + 1j * omega * machine.leakage + branch


def fit(found: Impedance, no_load: NoLoad, curve: Saturation, r_s: tuple[float, float] | None) -> Impedance:
    """The machine at the flux of `no_load`. found: by linear tones; r_s: a measured stator resistance and its standard
    deviation [ohm]."""
    from scipy.optimize import least_squares

    iron, timing = Iron(no_load, curve), found.timing
    sampling = _sampling(found.with_slope, found.tones, timing)
    measured = np.array([tone.impedance for tone in found.tones])

    def residuals(logs: np.ndarray) -> np.ndarray:
        fitted = sampling * np.array([impedance(iron, tone, *np.exp(logs)) for tone in found.tones])
        away = (fitted - measured) / np.abs(measured)
        rows = [away.real, away.imag]
        if r_s:
            total = r_s[0] + found.slope_ohm
            rows.append([(logs[0] - math.log(total)) * total / max(1e-6, r_s[1]) * rest])
        return np.concatenate(rows)

    rest = found.rest
    start = found.machine.with_stator_inductance(no_load.l_s)
    k = start.l_magnetising / no_load.l_s
    begin = np.log([found.with_slope.r_s, start.leakage / k, start.r_rotor / k**2])
    first = least_squares(residuals, begin, x_scale=0.1, xtol=1e-10, ftol=1e-10)
    tones = 2 * len(found.tones)
    rest = max(math.sqrt(float(np.sum(first.fun[:tones] ** 2)) / max(1, tones - 3)), 1e-6)
    done = least_squares(residuals, first.x, x_scale=0.1, xtol=1e-10, ftol=1e-10)
    sigma = rest * np.sqrt(np.diag(np.linalg.pinv(done.jac.T @ done.jac)))
    total, leakage, r_rotor = (float(one) for one in np.exp(done.x))
    k = no_load.l_s / (no_load.l_s + leakage)
    r_stator = total - found.slope_ohm
    machine = InverseGamma(r_stator, k * leakage, k**2 * r_rotor, k * no_load.l_s)
    deviations = InverseGamma(float(sigma[0]) * total / r_stator, float(sigma[1]), float(sigma[2]), no_load.sigma)
    return replace(found, machine=machine, deviations=deviations, rest=rest)


def _sampling(machine: InverseGamma, tones: tuple[Tone, ...], timing: Timing) -> np.ndarray:
    """What constant voltages and the instants of the readings do to the impedance of a linear machine. [-]"""
    omega = np.array([tone.omega for tone in tones])
    return sampled_impedance(machine, omega, timing) / np.array([_linear(machine, w) for w in omega])
