"""The torque that machine, link and current limit allow at a speed, independent of the drive's own computation.

Steady state of the T-equivalent circuit at electrical slip frequency w_2 and stator flux linkage psi, in the frame
of the flux, with L_s = L_ls + L_m, L_r = L_lr + L_m, sigma = 1 − L_m²/(L_s L_r), tau_r = L_r/R_r:
  i_s = psi/L_s · (1 + j w_2 tau_r)/(1 + j w_2 sigma tau_r)
  u_s = R_s i_s + j (p omega_m + w_2) psi
  torque = 3/2 p psi Im(i_s)
At a slip frequency voltage and current are proportional to the flux: the largest flux that respects all limits gives
the largest torque. A search over the slip frequency finds the best up to that at which the torque is the usable share
of the breakdown torque at the flux.
"""

import math
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Limits:
    r_s: float  # [ohm]
    r_r: float  # [ohm]
    l_s: float  # [H]
    l_r: float  # [H]
    l_m: float  # [H]
    pole_pairs: int
    voltage: float  # amplitude that the drive may use [V]
    current: float  # amplitude of the stator current; infinite: no limit [A]
    flux: float  # stator flux linkage [Wb]
    torque: float  # configured [N·m]
    breakdown_use: float = 1.0  # usable share of the breakdown torque at a flux

    @property
    def largest_slip(self) -> float:
        """At which 2 x/(1 + x²), x = slip sigma tau_r, is the usable share of the breakdown torque. [rad/s]"""
        sigma, tau_r = 1 - self.l_m**2 / (self.l_s * self.l_r), self.l_r / self.r_r
        return self.breakdown_use / (1 + math.sqrt(1 - self.breakdown_use**2)) / (sigma * tau_r)


def largest_torque(limits: Limits, omega_m: float, sign: int) -> float:
    """Largest magnitude of a torque of that sign at omega_m [rad/s]. [N·m]"""
    m = limits
    sigma, tau_r = 1 - m.l_m**2 / (m.l_s * m.l_r), m.l_r / m.r_r
    low, high = 0.0, m.largest_slip
    best = 0.0
    for _ in range(4):  # each time within a hundredth of the range before
        slip = np.linspace(low, high, 2001)
        torque = _torque(m, sigma, tau_r, omega_m, sign * slip)
        k = int(np.argmax(torque))
        best = max(best, float(torque[k]))
        width = (high - low) / 200
        low, high = max(0.0, slip[k] - width), min(m.largest_slip, slip[k] + width)
    return min(best, m.torque)


def _torque(m: Limits, sigma: float, tau_r: float, omega_m: float, slip: np.ndarray) -> np.ndarray:
    current = (1 + 1j * slip * tau_r) / (1 + 1j * slip * sigma * tau_r) / m.l_s  # by flux
    voltage = m.r_s * current + 1j * (m.pole_pairs * omega_m + slip)
    flux = np.minimum(m.flux, m.current / abs(current))
    flux = np.minimum(flux, m.voltage / np.maximum(abs(voltage), 1e-12))
    return 1.5 * m.pole_pairs * flux**2 * abs(current.imag)


def _inductance(configuration: dict, name: str) -> float:
    """Of the machine, which gives it as such or as a reactance. [H]"""
    given = configuration.get(f"machine.l_{name}_h")
    if given is not None:
        return given
    return configuration[f"machine.x_{name}_ohm"] / (2 * math.pi * configuration["machine.reactance_frequency_hz"])


def limits_of(configuration: dict, current_limit: str) -> Limits:
    """From the configuration in force of a run; current_limit: the key of the current limit, if it has one."""
    l_m = _inductance(configuration, "m")
    current = configuration.get(current_limit)
    return Limits(
        r_s=configuration["machine.r_s_ohm"],
        r_r=configuration["machine.r_r_ohm"],
        l_s=l_m + _inductance(configuration, "ls"),
        l_r=l_m + _inductance(configuration, "lr"),
        l_m=l_m,
        pole_pairs=configuration["machine.poles"] // 2,
        voltage=configuration["capability.voltage_use"] * configuration["plant.u_dc_v"] / math.sqrt(3),
        current=math.inf if current is None else current,
        flux=configuration["control.flux_reference_wb"],
        torque=configuration["capability.torque_nm"],
        breakdown_use=configuration.get("capability.breakdown_use", 1.0),
    )


def limits_from(stored: dict) -> Limits:
    """Of results, which have no infinity."""
    return Limits(**{key: math.inf if value is None else value for key, value in stored.items()})


def worst_difference(capability: dict) -> tuple[float, float, str]:
    """Of published from analytic torque: percent of the analytic one, speed, and the direction."""
    worst = (0.0, 0.0, "motoring")
    for direction in ("motoring", "regenerating"):
        rows = zip(capability["speeds"], capability[direction], capability[f"{direction}_analytic"], strict=True)
        for speed, published, analytic in rows:
            percent = 100 * ((published or 0.0) / analytic - 1) if analytic else 0.0
            if abs(percent) > abs(worst[0]):
                worst = (percent, speed, direction)
    return worst
