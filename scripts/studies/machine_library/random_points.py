"""Machines at random, as entries of a library of machines."""

from pathlib import Path

import numpy as np

from studies.command import made, write_toml

from .points import Machine
from .random_machines import Machine as RandomMachine
from .random_machines import random_machine, random_powers_kw

VOLTS = (48.0, 230.0, 400.0, 690.0)  # line to line, RMS
LARGEST_AT_48_V_KW = 20.0


def drawn(count: int, seed: int, directory: Path) -> list[Machine]:
    """That many, each with its file in the directory, from 0.25 to 200 kW and at 48 to 690 V."""
    dice, found = np.random.default_rng(seed), []
    for number, power_kw in enumerate(random_powers_kw(dice, count)):
        volts = float(dice.choice(VOLTS if power_kw <= LARGEST_AT_48_V_KW else VOLTS[1:]))
        file = directory / f"random_{seed}_{number}.toml"
        found.append(entry(random_machine(dice, float(power_kw), volts), volts, file))
    return found


def entry(machine: RandomMachine, volts: float, file: Path) -> Machine:
    """The machine, with its file."""
    made(file.parent)
    return Machine(
        f"{machine.name}, {volts:g} V", write_toml(file, machine.settings), machine.power_kw * 1e3, volts, 50.0,
        machine.rated_torque, machine.base_speed, 2 * machine.pole_pairs, machine.u_dc,
    )  # fmt: skip
