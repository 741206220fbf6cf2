"""The drives of the torque map: what is set for each, and the scenario that all points begin from.

What a version of sextant-mil may not have stands in OPTIONAL tables: a key that it does not know is left out and named.
"""

import tomllib
from dataclasses import dataclass, field
from pathlib import Path

from sextant_py.paths import ECU
from sextant_py.short_run import SHORT, known_keys, scenario_text, summary_of
from sextant_py.sweep_file import Settings
from sextant_py.sweep_reader import flat

from .scale import SENSORS, SHIPPED, Scale

# What every drive of the map has besides configs/ecu.toml: limits beyond which the map goes on purpose.
COMMON: Settings = {"plant.integrator": "exact", "protection.over_speed_rad_s": 500}

# The paper's drive: switching table, voltage model, no magnetising, torque trim, flux priority or torque monitor,
# and none of the protections by a model of the machine.
PAPER_OPTIONAL: Settings = {
    "control.controller": "dtc",
    "control.flux_estimator": "voltage_model",
    "drive.magnetise_first": False,
    "torque_monitor.enabled": False,
    "control.dtc.flux_priority": False,
    "control.dtc.torque_trim_ms": 0,
    "protection.current_response": 0,
    "protection.speed_error_rad_s": 10_000,
    "protection.flux_lost_share": 0,
}
DRIVES: dict[str, tuple[str, Settings]] = {
    "paper": ("the paper's drive", PAPER_OPTIONAL),
    "shipped": ("ecu.toml", {}),
    "foc": ("ecu_foc.toml", {"control.controller": "foc"}),
}
GUARANTEED = "foc"  # that of docs/torque.md and of the page's single pictures

DELAY = "drive.actuation_delay_periods"
DEAD_TIME = "drive.inverter.dead_time_us"
# Where the configuration in force has the limit of the stator current; None where it has none. [A]
CURRENT_LIMIT = "drive.current_limit_a"
# Keys of a machine that the factors scale, and the ratio of their meaning to it.
FACTORS = {"r_s": "r_s_ohm", "r_r": "r_r_ohm", "l_m": "x_m_ohm"}
# The magnetising inductance, of a machine that has it in the place of the reactance.
INDUCTANCE = "l_m_h"


@dataclass
class Drive:
    """A drive as its points begin, and what this sextant-mil knows of it."""

    name: str
    base: Settings
    machine: dict[str, float]
    known: set[str]
    left_out: list[str] = field(default_factory=list)
    configuration: Settings = field(default_factory=dict)  # in force
    version: str = ""
    commit: str = ""
    title: str = ""  # of a drive that is not one of DRIVES
    scale: Scale = SHIPPED

    @property
    def label(self) -> str:
        return self.title or DRIVES[self.name][0]

    @property
    def factors(self) -> dict[str, str]:
        return FACTORS if FACTORS["l_m"] in self.machine else FACTORS | {"l_m": INDUCTANCE}

    def has_sensors(self, kind: str) -> bool:
        return set(SENSORS[kind]) <= self.known

    def write(self, directory: Path) -> Path:
        """The scenario that every point's settings are added to."""
        scenario = directory / f"{self.name}.toml"
        scenario.write_text(scenario_text(self.base, "torque_map"), encoding="utf-8")
        return scenario

    def put_in_force(self, mil: Path, directory: Path) -> None:
        """Writes its scenario, and takes what this sextant-mil makes of it."""
        found = summary_of(mil, self.write(directory), SHORT)
        self.configuration, self.version, self.commit = found["configuration"], found["version"], found["commit"]


def _shipped() -> tuple[dict, dict]:
    """configs/ecu.toml without machine and load, and the machine."""
    ecu = tomllib.loads(ECU.read_text(encoding="utf-8"))
    file = ecu["machine"].pop("file", None)
    machine = tomllib.loads((ECU.parent / file).read_text(encoding="utf-8")) if file else {}
    machine |= ecu.pop("machine")
    ecu.pop("load", None)
    return ecu, machine


def load(name: str, mil: Path, directory: Path) -> Drive:
    """The drive of that name on the machine of configs/ecu.toml; writes its scenario into the directory."""
    ecu, machine = _shipped()
    shipped = flat(ecu)
    given = {f"machine.{key}": value for key, value in machine.items()}
    drive = Drive(name, given, machine, known_keys(mil, directory, given))
    optional = COMMON | DRIVES[name][1]
    # The file of a live drive has sections, such as those of its buses, that no scenario has.
    drive.base |= {key: value for key, value in shipped.items() if key in drive.known}
    drive.base |= {key: value for key, value in optional.items() if key in drive.known}
    drive.left_out = [key for key in optional if key not in drive.known]
    drive.put_in_force(mil, directory)
    return drive
