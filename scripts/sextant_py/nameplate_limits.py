"""Limits of a drive from a name plate: its current and torque, in place of the machine's breakdown."""

import math
from dataclasses import dataclass

from .nameplate_circuit import Circuit, Fit, across_flux
from .nameplate_plate import NamePlate
from .nameplate_spread import Variant, span, worst

OVERLOAD = 1.5  # torque limit by rated torque; for a minute a drive is usually made for it
BREAKDOWN_USE = 0.95  # capability.breakdown_use
HEADROOM = 1.25  # trip level by the current limit, as the drive's own default has it
HAND_OVER, MAGNETISING = 1.25, 1.8  # by the current of the flux, as include/sextant/core/drive_limits.hpp has them
# protection.current_jump_a by the trip level and by an active vector, as drive_limits.hpp has them
SENSOR_SHARE, LEAST_JUMP = 0.03, 0.5
LEAST_CURRENT = 1.55  # current limit by the current of the flux: capability needs more than 1.5
OVER_SPEED = 1.2  # by the largest speed: the test of IEC 60034-1, 9.7


@dataclass(frozen=True)
class Limits:
    """Amplitudes."""

    u_dc_v: float
    flux_wb: float  # of the stator at the rated point
    torque_nm: float
    current_limit_a: float
    over_current_a: float
    current_jump_a: float
    hand_over_a: float
    magnetising_a: float
    over_speed_rad_s: float
    base_speed_rad_s: float  # up to which the link suffices for flux and rated torque


def flux_of(plate: NamePlate, fit: Fit) -> float:
    """ψ_s = √2 |U − R_s I|/ω, the amplitude at the rated point. [Wb]"""
    behind, _, _ = across_flux(plate, fit.circuit.r_s, fit.other_losses_w)
    return math.sqrt(2) * abs(behind) / plate.omega_s


def breakdown_at_flux(circuit: Circuit, flux_wb: float) -> float:
    """T_b = 3/4 p (1 − σ)/σ ψ²/L_s, of include/sextant/core/steady_state.hpp. [N·m]"""
    sigma = circuit.sigma
    return 0.75 * circuit.pole_pairs * (1 - sigma) / sigma * flux_wb**2 / circuit.l_s


def current_at(circuit: Circuit, flux_wb: float, torque_nm: float) -> float:
    """Amplitude of the stator current at flux and torque, at most at the breakdown; of the same source. [A]"""
    share = min(1.0, torque_nm / breakdown_at_flux(circuit, flux_wb))
    x = share / (1 + math.sqrt(1 - share**2))
    return flux_wb / circuit.l_s * math.sqrt((1 + (x / circuit.sigma) ** 2) / (1 + x**2))


def _reactive(variant: Variant) -> float:
    """What the rated current has across the flux's voltage: more than the flux takes without torque. [A]"""
    return math.sqrt(2) * across_flux(variant.plate, variant.fit.circuit.r_s, variant.fit.other_losses_w)[2]


def limits_of(of: list[Variant], period_us: float, u_dc_v: float | None, overload: float = OVERLOAD) -> Limits:
    """Of variants, the nominal one first.

    The torque limit is `overload` of the rated torque, at most BREAKDOWN_USE of the low end of what the machine has at
    the rated flux, and at least the rated torque. The current limit is what this torque takes with the worst of the
    variants. The trip level is HEADROOM of it and the change that one active vector makes in a period,
    (2/3) u_dc T/σL_s: by so much a method that switches once a period passes a limit. The flux takes less current
    without torque than the rated point has behind the voltage, whatever the leakage. A jump of the current that no
    voltage explains allows for what the low end of σL_s makes of an active vector.
    """
    plate = of[0].plate
    u_dc = u_dc_v or math.sqrt(2) * plate.voltage_v
    flux = flux_of(plate, of[0].fit)
    reserve, _, _ = span(of, lambda v: breakdown_at_flux(v.fit.circuit, flux_of(v.plate, v.fit)) / v.plate.torque_nm)
    torque = plate.torque_nm * max(1.0, min(overload, BREAKDOWN_USE * reserve))
    idle = worst(of, _reactive)
    needed = worst(of, lambda v: current_at(v.fit.circuit, flux_of(v.plate, v.fit), torque))
    current = max(needed, LEAST_CURRENT * idle)
    low, leakage, _ = span(of, lambda v: v.fit.circuit.sigma * v.fit.circuit.l_s)
    ripple = 2 / 3 * u_dc * 1e-6 * period_us / leakage
    trip = HEADROOM * current + ripple
    jump = SENSOR_SHARE * trip + max(LEAST_JUMP, leakage / low - 1) * ripple
    largest = (plate.max_speed_rpm or plate.synchronous_rad_s * 30 / math.pi) * math.pi / 30
    return Limits(
        u_dc, flux, torque, current, trip, jump, HAND_OVER * idle,
        min(MAGNETISING * idle, current), OVER_SPEED * largest,
        plate.speed_rad_s * u_dc / (math.sqrt(2) * plate.voltage_v),
    )  # fmt: skip
