"""The equivalent circuit of a name plate.

The circuit is that of the project's machine: T-equivalent, R_s, L_ls, L_m, L_lr, R_r, without iron. Losses of iron,
friction and stray, P_o, are taken at the lines: beside the circuit the lines carry P_o in phase with the voltage. With
the voltage U and the circuit's current I = I_N − P_o/(3U) as phasors of the equivalent star:

- The power gives R_s: P_in = P_o + 3 R_s I² + P/(1 − s), the segregation of losses of IEEE 112, method B.
- The voltage across the stator flux is U' = U − R_s I. Its parts of the current, I_a along U' and I_r behind it, lie on
  the circle of Heyland (I. Boldea, S. A. Nasar, The Induction Machines Design Handbook, 2nd edition, chapter 7;
  J. Pyrhönen, T. Jokinen, V. Hrabovcová, Design of Rotating Electrical Machines, 2nd edition, chapter 7), whose ends
  are I_0 = U'/(ω L_s) and I_0/σ. With the relative slip x = ω_slip σ τ_r of
  include/sextant/core/steady_state.hpp
      I_0 = I_r − x I_a,   σ = x I_0/(I_a + x I_r)
  and the slip of the plate gives the rotor's time constant τ_r = L_r/R_r = x/(σ ω_slip).

One degree is left, x: the breakdown torque at the rated flux is (1 + x²)/(2 x) times the rated one. It follows from the
ratio of the breakdown torque at rated voltage, else from that of the starting current, else from USUAL_BREAKDOWN. A
starting current is larger than by the leakage of rated operation, because it saturates the teeth and the rotor bars
carry it at their tops (J. Pedra, F. Córcoles, Estimation of induction motor double-cage model parameters from
manufacturer data, IEEE Transactions on Energy Conversion 19(2), 2004; J. Pedra, On the determination of induction
motor parameters from manufacturer data for electromagnetic transient programs, IEEE Transactions on Power Systems
23(4), 2008).

L_ls = L_lr: at the terminals only L_s, σ, τ_r and R_s show (G. R. Slemon, Modelling of induction machines for electric
drives, IEEE Transactions on Industry Applications 25(6), 1989), and by them alone the drive acts.
"""

import cmath
import math
from collections.abc import Callable
from dataclasses import dataclass

from .errors import UserError
from .nameplate_plate import NamePlate

# Share of R_s in the losses beside the rotor's, and its range: of all losses the stator's winding has 25 to 40 %, the
# rotor 15 to 25, iron 15 to 25, friction 5 to 15, stray 10 to 20 %; small machines have more in the winding (A. H.
# Bonnett, An overview of how AC induction motor performance has been affected by the October 24, 1997 implementation of
# the Energy Policy Act of 1992, IEEE Transactions on Industry Applications 36(1), 2000).
STATOR_SHARE, STATOR_SHARE_RANGE = 0.6, (0.3, 1.0)
# Breakdown by rated torque where nothing is said: between the least of the standards, 1.6 to 2 (IEC 60034-12, design N;
# NEMA MG 1, design B, 1.75 to 3), and the 5 that the stiffest published circuit has.
USUAL_BREAKDOWN, USUAL_BREAKDOWN_RANGE = 2.9, (1.7, 5.0)
LEAST_SLIP, MOST_SLIP = 1e-3, 0.98  # x in a search; at 1 the rated torque is the breakdown torque
# Of what a rated point allows, an assumed ratio keeps away from the ends: from that of no leakage by a share of the
# ratios, from that of no magnetising current by a share of x.
ROOM, MOST_ASSUMED = 0.1, 0.75
BREAKDOWN_RANGE = (0.9, 1.1)  # a data sheet's by the machine's: IEC 60034-1, tolerances
STARTING_RANGE = (1.0, 1.4)  # the data sheet's by that of the leakage of rated operation


@dataclass(frozen=True)
class Circuit:
    """In the equivalent star."""

    r_s: float  # [ohm]
    r_r: float  # [ohm]
    l_ls: float  # [H]
    l_lr: float  # [H]
    l_m: float  # [H]
    pole_pairs: int

    @property
    def l_s(self) -> float:
        return self.l_ls + self.l_m

    @property
    def l_r(self) -> float:
        return self.l_lr + self.l_m

    @property
    def sigma(self) -> float:
        return 1 - self.l_m**2 / (self.l_s * self.l_r)

    @property
    def tau_r(self) -> float:
        """[s]"""
        return self.l_r / self.r_r

    def current(self, voltage: float, omega_s: float, slip: float) -> complex:
        """Of a phase, to the voltage as the real axis. RMS [A]"""
        rotor = complex(self.r_r / slip, omega_s * self.l_lr) if slip else None
        magnetising = 1j * omega_s * self.l_m
        parallel = magnetising if rotor is None else magnetising * rotor / (magnetising + rotor)
        return voltage / (complex(self.r_s, omega_s * self.l_ls) + parallel)

    def torque(self, voltage: float, omega_s: float, slip: float) -> float:
        """Of the air gap at a phase voltage, RMS. [N·m]"""
        current = self.current(voltage, omega_s, slip)
        return 3 * (voltage * current.real - self.r_s * abs(current) ** 2) * self.pole_pairs / omega_s

    def breakdown(self, voltage: float, omega_s: float) -> tuple[float, float]:
        """Slip and torque, by the source that R_r/s is fed from: s_b = R_r/|Z_th + jωL_lr|. [-], [N·m]"""
        stator, magnetising = complex(self.r_s, omega_s * self.l_ls), 1j * omega_s * self.l_m
        source = stator * magnetising / (stator + magnetising) + 1j * omega_s * self.l_lr
        slip = self.r_r / abs(source)
        return slip, self.torque(voltage, omega_s, slip)


def losses_of(plate: NamePlate, stator_share: float) -> tuple[float, float]:
    """R_s [ohm] and P_o [W]. The share counts where the plate says neither."""
    total = plate.stator_side_losses_w
    if plate.star_r_s_ohm is None:
        other = (1 - stator_share) * total if plate.other_losses_w is None else plate.other_losses_w
        return (total - other) / (3 * abs(_circuit_current(plate, other)) ** 2), other
    # P_o changes the circuit's current, which R_s needs: a contraction by some 1e-2 each time.
    other = 0.0
    for _ in range(50):
        other = max(0.0, total - 3 * plate.star_r_s_ohm * abs(_circuit_current(plate, other)) ** 2)
    return plate.star_r_s_ohm, other


def _circuit_current(plate: NamePlate, other_losses_w: float) -> complex:
    """Of the circuit at the rated point: I_N less the part of the other losses. RMS [A]"""
    angle = math.acos(plate.power_factor)
    return cmath.rect(plate.current_a, -angle) - other_losses_w / (3 * plate.phase_voltage)


def across_flux(plate: NamePlate, r_s: float, other_losses_w: float) -> tuple[complex, float, float]:
    """The voltage U' [V], and the current along it and behind it [A], RMS."""
    current = _circuit_current(plate, other_losses_w)
    behind = plate.phase_voltage - r_s * current
    turned = current * behind.conjugate() / abs(behind)
    return behind, turned.real, -turned.imag


def _most_slip(plate: NamePlate, stator_share: float) -> float:
    """Of x, so that x < 1 and I_0 > 0."""
    _, active, reactive = across_flux(plate, *losses_of(plate, stator_share))
    return MOST_SLIP * min(1.0, reactive / active)


def circuit_of(plate: NamePlate, stator_share: float, x: float) -> Circuit:
    """The circuit at a share of the losses and a relative slip x of the rated point."""
    r_s, other = losses_of(plate, stator_share)
    behind, active, reactive = across_flux(plate, r_s, other)
    idle = reactive - x * active
    sigma = x * idle / (active + x * reactive)
    l_s = abs(behind) / (plate.omega_s * idle)
    l_m = l_s * math.sqrt(1 - sigma)
    tau_r = x / (sigma * plate.omega_s * plate.slip)
    return Circuit(r_s, l_s / tau_r, l_s - l_m, l_s - l_m, l_m, plate.pole_pairs)


def breakdown_ratio(plate: NamePlate, circuit: Circuit) -> float:
    """At rated voltage and frequency, by the rated torque."""
    return circuit.breakdown(plate.phase_voltage, plate.omega_s)[1] / plate.torque_nm


def starting_ratio(plate: NamePlate, circuit: Circuit) -> float:
    """Current at standstill and rated voltage, by the rated current."""
    return abs(circuit.current(plate.phase_voltage, plate.omega_s, 1.0)) / plate.current_a


@dataclass(frozen=True)
class Target:
    """What x follows from."""

    key: str  # of the plate
    ratio: Callable[[NamePlate, Circuit], float]  # falls with x
    value: float
    is_given: bool = True


def target_of(plate: NamePlate) -> Target:
    if plate.breakdown_ratio is not None:
        return Target("breakdown_ratio", breakdown_ratio, plate.breakdown_ratio)
    if plate.starting_ratio is not None:
        return Target("starting_ratio", starting_ratio, plate.starting_ratio)
    return Target("breakdown_ratio", breakdown_ratio, USUAL_BREAKDOWN, False)


@dataclass(frozen=True)
class Fit:
    circuit: Circuit
    other_losses_w: float
    target: Target


def _slip_of(plate: NamePlate, stator_share: float, target: Target) -> float:
    """x at which the ratio is that of the target. A ratio that no plate says keeps away from what the rated point
    excludes."""
    from scipy.optimize import brentq

    def ratio(x: float) -> float:
        return target.ratio(plate, circuit_of(plate, stator_share, x))

    ends = LEAST_SLIP, _most_slip(plate, stator_share)
    high, low = (ratio(x) for x in ends)
    value = target.value
    if not target.is_given:
        value = min(max(value, ratio(MOST_ASSUMED * ends[1])), high - ROOM * (high - low))
    if low < value < high:
        return brentq(lambda x: ratio(x) - value, *ends, xtol=1e-13)
    raise UserError(
        f"{target.key} (--{target.key.replace('_', '-')}) is {target.value:g}, and a machine with this rated point has "
        f"{low:.2f} to {high:.2f}, by its leakage: correct it, current or cos phi, or leave it out."
    )


def fit(plate: NamePlate, stator_share: float = STATOR_SHARE, target: Target | None = None) -> Fit:
    """The circuit that makes the rated point of the plate. The share counts where the plate does not say.

    Raises UserError where the target is out of reach.
    """
    target = target or target_of(plate)
    circuit = circuit_of(plate, stator_share, _slip_of(plate, stator_share, target))
    return Fit(circuit, losses_of(plate, stator_share)[1], target)
