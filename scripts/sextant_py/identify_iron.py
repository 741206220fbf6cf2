"""Iron loss from a shaft that coasts at several fluxes, and the inertia: by retardation, as IEC 60034-2-1 has it.

Without torque of stator flux and current the shaft of `no_load` obeys
  −J dω/dt = T_f + p P_fe/ω_e,   P_fe = 3/2 (ω_e ψ_s)²/R_fe,   ω_e = p ω
at about one speed ω: what falls with the square of the flux is iron, what stays is friction and load, T_f. R_fe is that
at this frequency, of eddy currents and hysteresis together.
"""

import math
from dataclasses import dataclass

import numpy as np

from .identify_inertia import Inertia
from .identify_no_load import NoLoad

CERTAIN = 3  # standard deviations that the loss is above zero by at least


@dataclass(frozen=True)
class IronLoss:
    resistance_ohm: float  # R_fe per phase, across the voltage of the stator flux
    sigma: float  # its relative standard deviation
    loss_w: float  # at the whole flux and this speed
    friction_nm: float  # T_f, with the load
    friction_sigma_nm: float
    omega_e: float  # electrical [rad/s]


def fit(points: list[NoLoad], inertia: Inertia, pole_pairs: float) -> IronLoss | None:
    """Of measurements at several fluxes; None where no certain iron loss shows."""
    omega_e = pole_pairs * np.array([point.speed for point in points])
    flux = np.array([point.flux_wb for point in points])
    torque = inertia.inertia * np.array([-point.acceleration for point in points]) * np.sign(omega_e)
    columns = np.column_stack([1.5 * pole_pairs * np.abs(omega_e) * flux**2, np.ones(flux.size)])
    scale = np.linalg.norm(columns, axis=0)
    scaled = columns / scale
    conductance, friction = (float(one) for one in np.linalg.lstsq(scaled, torque, rcond=None)[0] / scale)
    rest = torque - columns @ np.array([conductance, friction])
    variance = float(rest @ rest) / (flux.size - 2)
    sigmas = np.sqrt(variance * np.diag(np.linalg.inv(scaled.T @ scaled))) / scale
    if not conductance > CERTAIN * sigmas[0]:
        return None
    whole = 1.5 * (float(omega_e[-1]) * points[-1].flux_wb) ** 2 * conductance
    sigma = math.hypot(float(sigmas[0]) / conductance, inertia.sigma / inertia.inertia)
    return IronLoss(1 / conductance, sigma, whole, friction, float(sigmas[1]), abs(float(omega_e[-1])))
