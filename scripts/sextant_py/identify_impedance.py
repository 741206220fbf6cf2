"""Leakage inductance, rotor resistance and magnetising inductance from the impedance at standstill, by least squares.

With a sine along phase a above a direct current the machine is linear and has two states: by the inverse-Γ circuit
  dψ_s/dt = u − R i,   dψ_R/dt = R_R (i − ψ_R/L_M),   i = (ψ_s − ψ_R)/σL_s
The voltage is constant within a control period T and the current is read at its beginning, so that the ratio of their
phasors at ω is C (e^{jωT} − e^{AT})⁻¹ ∫e^{At}dt B of this system exactly, later by the periods until a pattern acts;
a reading before the period is that of the period before, further on by the rest of its time. R
contains the slope resistance of the inverter. Dead time and threshold are a constant voltage: the current keeps its
sign.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from .errors import UserError
from .identify_machine import InverseGamma, without_slope

FEWEST = 2  # tones, of two numbers each, for four parameters


@dataclass(frozen=True)
class Block:
    """Phasors over whole cycles of a tone; their imaginary parts are a quarter of a cycle ahead of the sine."""

    cycle: int  # control periods of a cycle
    current_a: complex
    voltage_v: complex  # commanded
    mean_current_a: float
    link_v: float


@dataclass(frozen=True)
class Timing:
    """When voltage and current of a control period belong to."""

    period_s: float
    delay_periods: int = 0  # until a pattern acts
    lead_s: float = 0.0  # by which the currents are read before the period


@dataclass(frozen=True)
class Tone:
    """The mean of the blocks of one frequency."""

    omega: float  # [rad/s]
    impedance: complex  # voltage by current, as sampled [ohm]
    scatter: float  # relative standard deviation of the mean, of each component
    mean_current_a: float
    amplitude_a: float


@dataclass(frozen=True)
class Impedance:
    """What the tones tell; the deviations are relative standard deviations."""

    machine: InverseGamma  # r_s without the slope resistance
    deviations: InverseGamma
    tones: tuple[Tone, ...]
    timing: Timing
    slope_ohm: float
    rest: float  # relative standard deviation of a component about the fit

    @property
    def with_slope(self) -> InverseGamma:
        """As the inverter's terminals show it."""
        return replace(self.machine, r_s=self.machine.r_s + self.slope_ohm)


def sampled_impedance(machine: InverseGamma, omega: Iterable[float], timing: Timing) -> np.ndarray:
    """Voltage by current at those frequencies. [ohm]"""
    from scipy.linalg import expm

    a = np.zeros((3, 3))
    a[0, :2] = np.array([-1, 1]) * machine.r_s / machine.leakage
    a[1, :2] = np.array([1, -1]) * machine.r_rotor / machine.leakage
    a[1, 1] -= machine.r_rotor / machine.l_magnetising
    a[0, 2] = 1
    t = timing.period_s
    step, until_read = expm(a * t), expm(a * (t - timing.lead_s))
    found = []
    for w in omega:
        turn = np.exp(1j * w * t)
        before = np.linalg.solve(turn * np.eye(2) - step[:2, :2], step[:2, 2])
        psi = (until_read[:2, :2] @ before + until_read[:2, 2]) / turn
        found.append(turn**timing.delay_periods * machine.leakage / (psi[0] - psi[1]))
    return np.array(found)


def tones_of(blocks: list[Block], timing: Timing) -> list[Tone]:
    tones = []
    for cycle in dict.fromkeys(block.cycle for block in blocks):
        of_cycle = [block for block in blocks if block.cycle == cycle]
        ratios = np.array([one.voltage_v / one.current_a for one in of_cycle])
        mean = complex(np.mean(ratios))
        away = (ratios - mean) / abs(mean)
        scatter = math.sqrt(float(np.sum(np.abs(away) ** 2)) / (2 * max(1, ratios.size - 1)) / ratios.size)
        direct = float(np.mean([one.mean_current_a for one in of_cycle]))
        amplitude = float(np.mean([abs(one.current_a) for one in of_cycle]))
        tones.append(Tone(2 * math.pi / (cycle * timing.period_s), mean, scatter, direct, amplitude))
    return tones


def _residuals(logs: np.ndarray, tones: list[Tone], timing: Timing, known: tuple[float, float] | None) -> np.ndarray:
    fitted = sampled_impedance(InverseGamma(*np.exp(logs)), np.array([tone.omega for tone in tones]), timing)
    measured = np.array([tone.impedance for tone in tones])
    away = (fitted - measured) / np.abs(measured)
    rows = [away.real, away.imag]
    if known:
        rows.append([(logs[0] - math.log(known[0])) / known[1]])
    return np.concatenate(rows)


def fit(
    blocks: list[Block],
    timing: Timing,
    start: InverseGamma,
    slope_ohm: float = 0.0,
    r_s: tuple[float, float] | None = None,
) -> Impedance:
    """By relative deviations of the impedances. start: the drive's estimate. r_s: a measured stator resistance and its
    standard deviation [ohm]."""
    from scipy.optimize import least_squares

    tones = tones_of(blocks, timing)
    if len(tones) < FEWEST:
        raise UserError(f"{len(tones)} tones do not tell the machine; {FEWEST} frequencies are needed at least.")
    begin = np.log([start.r_s + slope_ohm, start.leakage, start.r_rotor, start.l_magnetising])
    first = least_squares(_residuals, begin, args=(tones, timing, None), x_scale=0.1, xtol=1e-12, ftol=1e-12)
    freedom = max(1, 2 * len(tones) - 4)
    within = math.sqrt(sum(tone.scatter**2 for tone in tones) / len(tones))
    rest = max(math.sqrt(2 * first.cost / freedom), within)
    known = None
    if r_s:
        total = r_s[0] + slope_ohm
        known = (total, max(1e-6, r_s[1] / total) / max(rest, 1e-9))
    done = least_squares(_residuals, first.x, args=(tones, timing, known), x_scale=0.1, xtol=1e-12, ftol=1e-12)
    if not done.success or not np.all(np.isfinite(done.x)):
        raise UserError(
            "the impedances are not those of an induction machine at standstill; see the tones in the trace."
        )
    sigma = rest * np.sqrt(np.diag(np.linalg.pinv(done.jac.T @ done.jac)))
    r, leakage, r_rotor, l_m = np.exp(done.x)
    machine = InverseGamma(without_slope(float(r), slope_ohm), float(leakage), float(r_rotor), float(l_m))
    deviations = InverseGamma(float(sigma[0] * r / (r - slope_ohm)), *(float(one) for one in sigma[1:]))
    return Impedance(machine, deviations, tuple(tones), timing, slope_ohm, rest)
