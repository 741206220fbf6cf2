"""Induction machines: five published ones, and random ones of any power."""

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
    def base_speed(self) -> float:
        """Mechanical speed at which the link is just enough for the rated flux. [rad/s]"""
        return self.u_dc / math.sqrt(3) / self.flux / self.pole_pairs

    @property
    def rated_torque(self) -> float:
        """Power at 9/10 of the base speed. [N·m]"""
        return self.power_kw * 1e3 / (0.9 * self.base_speed)


def from_reactances(name: str, power_kw: float, volts: float, hertz: float, **values: float) -> Machine:
    """Of a table of resistances and reactances; rated line-to-line voltage, RMS."""
    w = 2 * math.pi * hertz
    return Machine(
        name=name,
        power_kw=power_kw,
        r_s=values["r_s"],
        r_r=values["r_r"],
        l_ls=values["x_ls"] / w,
        l_lr=values["x_lr"] / w,
        l_m=values["x_m"] / w,
        pole_pairs=2,
        inertia=values["inertia"],
        u_dc=1.35 * volts,
        flux=volts * math.sqrt(2 / 3) / w,
    )


def published() -> list[Machine]:
    """From 1.1 to 37 kW."""
    stray = math.sqrt(1 - 0.0667)
    return [
        # P. C. Krause, O. Wasynczuk, S. D. Sudhoff, Analysis of Electric Machinery and Drive Systems, table 4.10-1:
        # 3 hp, which is also the paper's, and 50 hp.
        from_reactances(
            "Krause, 3 hp", 2.24, 220, 60, r_s=0.435, r_r=0.816, x_ls=0.754, x_lr=0.754, x_m=26.13, inertia=0.089
        ),
        from_reactances(
            "Krause, 50 hp", 37.3, 460, 60, r_s=0.087, r_r=0.228, x_ls=0.302, x_lr=0.302, x_m=13.08, inertia=1.662
        ),
        # O. Wallscheid, M. Schenke, J. Böcker, EPE-PEMC 2018, doi 10.1109/EPEPEMC.2018.8522008: the squirrel-cage
        # machine of gym-electric-motor.
        Machine("Wallscheid, 1.1 kW", 1.1, 2.9338, 1.355, 5.87e-3, 5.87e-3, 143.75e-3, 2, 1.1e-3, u_dc=560, flux=0.9),
        # Modelica Buildings library, IM_10HP_400V_50Hz.
        Machine("Buildings, 10 hp", 7.46, 0.7384, 0.7402, 3.045e-3, 3.045e-3, 0.1241, 2, 0.0343, u_dc=540, flux=1.04),
        # Modelica Standard Library, Electrical.Machines, ParameterRecords.IM_SquirrelCageData: 100 V, 100 A, 50 Hz.
        Machine(
            "Modelica, 34 kW",
            34.0,
            0.03,
            0.04,
            3 * (1 - stray) / (100 * math.pi),
            3 * (1 - stray) / (100 * math.pi),
            3 * stray / (100 * math.pi),
            2,
            0.29,
            u_dc=250,
            flux=0.45,
        ),
    ]


def random_machines(random: np.random.Generator, powers_kw: Iterable[float]) -> list[Machine]:
    """400 V, 50 Hz; resistances, reactances and inertias per unit as they are usual at the power."""
    return [random_machine(random, power_kw) for power_kw in powers_kw]


def random_machine(random: np.random.Generator, power_kw: float) -> Machine:
    volts, w = 400.0, 100 * math.pi
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
        u_dc=random.uniform(520, 650),
        flux=volts * math.sqrt(2 / 3) / w,
    )
