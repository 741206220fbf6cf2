"""How far the circuit of a name plate may be off: fits at the ends of what is assumed, and of a plate's tolerances.

A plate is off by the tolerances of IEC 60034-1: slip 20 % (30 % below 1 kW), 1 − cos φ a sixth within 0.02 to 0.07,
losses 15 % (10 % above 150 kW), breakdown torque 10 %. Each is varied alone to both of its ends; the deviations of a
quantity to either side, as logarithms, add up as those of independent errors do, by their squares.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

from . import nameplate_circuit as circuit
from .nameplate_circuit import Fit, Target, fit
from .nameplate_plate import NamePlate

SMALL_W, LARGE_W = 1e3, 150e3


@dataclass(frozen=True)
class Variant:
    """A plate and its circuit, with one thing at an end of its range."""

    cause: str
    plate: NamePlate
    fit: Fit

    def current(self, slip: float) -> complex:
        """Of a line at rated voltage and frequency, with the part of the other losses. RMS [A]"""
        voltage = self.plate.phase_voltage
        return self.fit.circuit.current(voltage, self.plate.omega_s, slip) + self.fit.other_losses_w / (3 * voltage)

    def torque(self, slip: float) -> float:
        """Of the air gap at rated voltage and frequency. [N·m]"""
        return self.fit.circuit.torque(self.plate.phase_voltage, self.plate.omega_s, slip)


Quantity = Callable[[Variant], float]
PARAMETERS: dict[str, Quantity] = {
    "r_s_ohm": lambda v: v.fit.circuit.r_s,
    "r_r_ohm": lambda v: v.fit.circuit.r_r,
    "l_ls_h": lambda v: v.fit.circuit.l_ls,
    "l_lr_h": lambda v: v.fit.circuit.l_lr,
    "l_m_h": lambda v: v.fit.circuit.l_m,
}


def _with_slip(plate: NamePlate, factor: float) -> NamePlate:
    slip = factor * plate.slip
    return replace(plate, speed_rpm=plate.speed_rpm * (1 - slip) / (1 - plate.slip))


def _with_power_factor(plate: NamePlate, step: float) -> NamePlate:
    """At the same power: the current goes with it."""
    power_factor = min(plate.power_factor + step, 0.5 * (1 + plate.power_factor))
    return replace(plate, power_factor=power_factor, current_a=plate.current_a * plate.power_factor / power_factor)


def _with_losses(plate: NamePlate, factor: float) -> NamePlate:
    """At the same power factor: the current goes with the input."""
    input_w = plate.power_w + factor * (plate.input_w - plate.power_w)
    return replace(plate, current_a=plate.current_a * input_w / plate.input_w)


def _plates(plate: NamePlate) -> Iterator[tuple[str, NamePlate]]:
    slip = 0.3 if plate.power_w < SMALL_W else 0.2
    cosine = min(max((1 - plate.power_factor) / 6, 0.02), 0.07)
    losses = 0.1 if plate.power_w > LARGE_W else 0.15
    for sign in (-1, 1):
        yield "slip", _with_slip(plate, 1 + sign * slip)
        yield "power factor", _with_power_factor(plate, sign * cosine)
        yield "losses", _with_losses(plate, 1 + sign * losses)


def _targets(target: Target) -> list[Target]:
    if not target.is_given:
        return [replace(target, value=value) for value in circuit.USUAL_BREAKDOWN_RANGE]
    ends = circuit.BREAKDOWN_RANGE if target.key == "breakdown_ratio" else circuit.STARTING_RANGE
    # A tolerance may reach what the rated point excludes: such an end is left at the nearest that it allows.
    return [replace(target, value=target.value / end, is_given=False) for end in ends if end != 1]


def variants(plate: NamePlate) -> list[Variant]:
    """The nominal one first."""
    nominal = fit(plate)
    found = [Variant("", plate, nominal)]
    if plate.r_s_ohm is None and plate.other_losses_w is None:
        found += [Variant("stator share", plate, fit(plate, share)) for share in circuit.STATOR_SHARE_RANGE]
    found += [Variant(nominal.target.key, plate, fit(plate, target=one)) for one in _targets(nominal.target)]
    loose = replace(nominal.target, is_given=False)
    for cause, other in _plates(plate):
        # A tolerance may leave less than the rotor or a measured resistance takes: such a plate cannot be.
        if other.stator_side_losses_w <= (other.other_losses_w or 0.0):
            continue
        found.append(Variant(cause, other, fit(other, target=loose)))
    return found


def span(of: list[Variant], quantity: Quantity) -> tuple[float, float, float]:
    """Low end, value and high end."""
    value = quantity(of[0])
    sides = [0.0, 0.0]
    for cause in {variant.cause for variant in of[1:]}:
        steps = [math.log(quantity(variant) / value) for variant in of if variant.cause == cause]
        sides[0] += min(0.0, *steps, 0.0) ** 2
        sides[1] += max(0.0, *steps, 0.0) ** 2
    low, high = (math.exp(sign * math.sqrt(side)) for sign, side in zip((-1, 1), sides, strict=True))
    return low * value, value, high * value


def worst(of: list[Variant], quantity: Quantity) -> float:
    return max(quantity(variant) for variant in of)
