"""Random induction machines of any power."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Machine:
    """T-equivalent circuit, SI units, referred to the stator; with what it is run on and at."""

    name: str
    power_kw: float
    r_s: float
    r_r: float
    l_ls: float
    l_lr: float
    l_m: float
    pole_pairs: int
    inertia: float
    u_dc: float
    flux: float  # rated stator flux linkage [Wb]

    @property
    def settings(self) -> dict[str, float]:
        """Keys of its table in a file; reactances are at 50 Hz."""
        return {
            "r_s_ohm": self.r_s, "r_r_ohm": self.r_r, "l_ls_h": self.l_ls, "l_lr_h": self.l_lr, "l_m_h": self.l_m,
            "reactance_frequency_hz": 50, "poles": 2 * self.pole_pairs, "inertia_kg_m2": self.inertia,
        }  # fmt: skip

    @property
    def base_speed(self) -> float:
        """Mechanical speed at which the link is just enough for the rated flux. [rad/s]"""
        return self.u_dc / math.sqrt(3) / self.flux / self.pole_pairs

    @property
    def rated_torque(self) -> float:
        """Power at 9/10 of the base speed. [N·m]"""
        return self.power_kw * 1e3 / (0.9 * self.base_speed)


def random_machines(random: np.random.Generator, powers_kw: Iterable[float]) -> list[Machine]:
    """400 V, 50 Hz; resistances, reactances and inertias per unit as they are usual at the power."""
    return [random_machine(random, power_kw) for power_kw in powers_kw]


def random_powers_kw(random: np.random.Generator, count: int) -> np.ndarray:
    """From 0.25 to 200 kW, evenly over their logarithm."""
    return 10 ** random.uniform(math.log10(0.25), math.log10(200), count)


def random_machine(random: np.random.Generator, power_kw: float, volts: float = 400.0) -> Machine:
    """50 Hz; volts: line to line, RMS. The link has 1.3 to 1.625 times of it."""
    w = 100 * math.pi
    pole_pairs = int(random.integers(1, 5))
    impedance = 0.65 * volts**2 / (1e3 * power_kw)  # of a power factor times efficiency of 0.65
    size = (power_kw / 10) ** -0.3  # small machines have the larger resistances
    inertia_constant = random.uniform(0.08, 0.6)  # kinetic energy at rated speed by power [s]
    return Machine(
        name=f"random, {power_kw:.3g} kW",
        power_kw=power_kw,
        r_s=impedance * size * random.uniform(0.02, 0.04),
        r_r=impedance * size * random.uniform(0.015, 0.04),
        l_ls=impedance * random.uniform(0.06, 0.14) / w,
        l_lr=impedance * random.uniform(0.06, 0.14) / w,
        l_m=impedance * random.uniform(1.5, 3.5) / w,
        pole_pairs=pole_pairs,
        inertia=2 * inertia_constant * 1e3 * power_kw / (w / pole_pairs) ** 2,
        u_dc=random.uniform(1.3, 1.625) * volts,
        flux=volts * math.sqrt(2 / 3) / w,
    )
