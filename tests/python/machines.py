"""Induction machines: five published ones; random ones come from sextant_py."""

import math

from studies.machine_library.random_machines import Machine, random_machine, random_machines

__all__ = ["Machine", "published", "random_machine", "random_machines"]


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
