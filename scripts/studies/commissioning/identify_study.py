"""Measures what `identify` finds on the machines of the library, each behind an inverter with dead time and drops and
sensors with noise, by a drive whose estimate is wrong.
"""

import argparse
import math
import random
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from sextant_py import identify, mil_program
from sextant_py.errors import UserError, run
from sextant_py.identify_files import Results
from sextant_py.identify_machine import TCircuit, estimate_of, inertia_of
from sextant_py.identify_run import configuration_of, scenario_of
from sextant_py.paths import OUT
from sextant_py.program_arguments import add_runs, from_one, parser_of
from sextant_py.sweep_file import Settings

from studies import identification
from studies.command import made, words
from studies.machine_library import random_machines
from studies.machine_library.points import Machine, chosen_machines, sensor_settings
from studies.machine_library.random_points import entry

EXAMPLES = """examples:
  scripts/identify_study                                  all machines of configs/machines/library.toml
  scripts/identify_study --machines krause_3hp,ong_20hp   these alone
  scripts/identify_study --random 50 --seed 3             random machines of 0.25 to 200 kW
  scripts/identify_study --period-us 25 --dead-time-us 1.5
  scripts/identify_study --spread 1                       the drive knows its machine
  scripts/identify_study --seed 7                         other errors of the estimate

The drive's estimate of each parameter is wrong by a random factor up to --spread or down to its inverse. Its switches
take 1.2 V, of which it is told; of the dead time it is not. The current sensors have 12 bits over 1.25 times the trip
level, and noise of 0.2 A by 300 A of that range. Compared are the parameters that the terminals show: R_s, the leakage
inductance of the stator with the rotor short, k_r² R_r and k_r L_m with k_r = L_m/(L_m + L_lr). Errors in percent; a *
marks those beyond the target. Exit status: 0 when each machine is within the targets, 1 when one is not."""
TARGETS = {"t_d": 10, "R_s": 3, "σL_s": 5, "R_r": 5, "L_m": 5, "J": 10}  # [%]
THRESHOLD_V = 1.2
NOISE_SHARE = 0.2 / 300  # of the range of the current sensors
# Of the drive with the right machine, as a plate tells them.
LIMITS = ("control.flux_reference_wb", "protection.over_current_a", "protection.current_jump_a")
NOISE_V_SHARE = 0.5 / 1000  # of the range of the voltage sensor


@dataclass(frozen=True)
class Row:
    machine: str
    errors: dict[str, float] = field(default_factory=dict)  # [%]
    reason: str = ""  # why there are none

    @property
    def misses(self) -> list[str]:
        return [name for name, error in self.errors.items() if not abs(error) <= TARGETS[name]]

    def text(self, width: int) -> str:
        if self.reason:
            return f"{self.machine:{width}}  {self.reason}"
        shown = [f"{error:8.2f}{'*' if name in self.misses else ' '}" for name, error in self.errors.items()]
        return f"{self.machine:{width}} {''.join(shown)}"


@dataclass(frozen=True)
class Study:
    """What is the same for every machine."""

    mil: Path
    directory: Path
    period_us: float
    dead_time_us: float
    spread: float
    seed: int

    def estimate(self, machine: Machine, true: TCircuit, inertia: float) -> Settings:
        """Wrong; the division of the leakage is right, which cannot be found."""
        dice = random.Random(f"{self.seed}/{machine.id}")

        def wrong(value: float) -> float:
            return float(f"{value * self.spread ** dice.uniform(-1, 1):.5g}")

        leakage = wrong(1.0)
        values = {"r_s_ohm": wrong(true.r_s), "r_r_ohm": wrong(true.r_r), "l_m_h": wrong(true.l_m)}
        values |= {"inertia_kg_m2": wrong(inertia)} | {"l_ls_h": leakage * true.l_ls, "l_lr_h": leakage * true.l_lr}
        return {f"control.machine_estimate.{key}": value for key, value in values.items()}

    def plant(self, configuration: Settings) -> Settings:
        link = configuration["plant.u_dc_v"]
        sensors = sensor_settings("12 bits", configuration["protection.over_current_a"], link)
        span = sensors["plant.sensors.current.range_a"]
        return sensors | {
            "plant.sensors.current.noise_a": round(NOISE_SHARE * span, 6),
            "plant.sensors.voltage.noise_v": round(NOISE_V_SHARE * 2 * link, 4),
            "plant.inverter.dead_time_us": self.dead_time_us,
            "plant.inverter.threshold_v": THRESHOLD_V,
            "drive.period_us": self.period_us,
        }

    def measure(self, machine: Machine) -> Row:
        own = made(self.directory / machine.id)
        file = own / f"{machine.id}.toml"
        file.write_text(machine.scenario(), encoding="utf-8")
        try:
            configuration = configuration_of(self.mil, scenario_of(file, self.mil, own), [])
            true, inertia = estimate_of(configuration), inertia_of(configuration)
            kept = {key: configuration[key] for key in LIMITS}
            settings = self.plant(configuration) | kept | self.estimate(machine, true, inertia)
            found = identification.identified(file, self.mil, own, identify.PARTS, settings, THRESHOLD_V)
        except UserError as error:
            return Row(machine.id, reason=str(error))
        return Row(machine.id, self.errors(found, true, inertia))

    def errors(self, results: Results, true: TCircuit, inertia: float) -> dict[str, float]:
        at, is_found = true.terminals, results.impedance.machine
        pairs = {
            "t_d": (1e6 * results.found.dead_time_s, self.dead_time_us),
            "R_s": (results.found.r_s_ohm, at.r_s),
            "σL_s": (is_found.leakage, at.leakage),
            "R_r": (is_found.r_rotor, at.r_rotor),
            "L_m": (is_found.l_magnetising, at.l_magnetising),
            "J": (results.inertia.inertia, inertia),
        }
        return {name: 100 * (one / other - 1) if other else math.nan for name, (one, other) in pairs.items()}


def parse_arguments(arguments: list[str]) -> argparse.Namespace:
    parser = parser_of("identify_study", "Measures what identify finds on the machines of the library.", EXAMPLES)
    parser.add_argument("--machines", type=words, metavar="A,B", help="these alone")
    parser.add_argument(
        "--random", type=from_one, metavar="N", help="so many random machines in the place of the library"
    )
    parser.add_argument("--period-us", type=float, default=125, metavar="US", help="control period (default: 125)")
    parser.add_argument("--dead-time-us", type=float, default=1.5, metavar="US", help="of the plant (default: 1.5)")
    parser.add_argument("--spread", type=float, default=1.4, metavar="X", help="of the estimate (default: 1.4)")
    parser.add_argument(
        "--seed", type=int, default=1, metavar="N", help="of the estimate, and of random machines (default: 1)"
    )
    add_runs(parser, "machines")
    options = parser.parse_args(arguments)
    if not (math.isfinite(options.spread) and options.spread >= 1):
        parser.error("--spread: expected a factor from 1 on")
    if not (math.isfinite(options.dead_time_us) and options.dead_time_us > 0):
        parser.error("--dead-time-us: expected a time above 0")
    return options


def drawn(count: int, seed: int, directory: Path) -> list[Machine]:
    """Of 50 Hz and 400 V."""
    dice = np.random.default_rng(seed)
    machines = random_machines.random_machines(dice, random_machines.random_powers_kw(dice, count))
    return [entry(one, 400.0, directory / f"random_{number}.toml") for number, one in enumerate(machines)]


def main(arguments: list[str]) -> int:
    options = parse_arguments(arguments)
    directory = OUT / "identify_study"
    if options.random:
        machines = drawn(options.random, options.seed, directory / "machines")
    else:
        machines = chosen_machines(options.machines)
    mil = mil_program.find(options.mil)
    study = Study(mil, directory, options.period_us, options.dead_time_us, options.spread, options.seed)
    width = max(len(machine.id) for machine in machines)
    print(f"{'':{width}} {''.join(f'{name:>8} ' for name in TARGETS)} (errors in %)", flush=True)
    rows = []
    with ThreadPoolExecutor(options.jobs) as pool:
        for row in pool.map(study.measure, machines):
            print(row.text(width), flush=True)
            rows.append(row)
    missing = [row for row in rows if row.reason or row.misses]
    print(f"{len(rows) - len(missing)} of {len(rows)} machines within the targets: "
          + ", ".join(f"{name} {target} %" for name, target in TARGETS.items()))  # fmt: skip
    return 1 if missing else 0


if __name__ == "__main__":
    run("identify_study", main)
