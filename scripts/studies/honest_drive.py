"""The drive of configs/ecu_honest.toml, whose plant has dead time, drops, saturation and real sensors, told what
`identify` finds there.
"""

from dataclasses import dataclass
from pathlib import Path

from sextant_py import drive_file, identify
from sextant_py.identify_files import report, told, write_files
from sextant_py.paths import ROOT
from sextant_py.sweep_file import Settings

from . import identification
from .command import write_toml

FILE = ROOT / "configs" / "ecu_honest.toml"
METHODS = ("dtc", "foc")
TOLD = ("drive.inverter.", "control.machine_estimate.")
DEAD_TIME = "inverter.dead_time_us"
INVERTER_PARTS = (identify.DEAD_TIME,)  # of identify: inverter and R_s; L_m, R_r and leakage stay those of the file
ALL_PARTS = (identify.DEAD_TIME, identify.IMPEDANCE, identify.NO_LOAD)  # inverter and machine


@dataclass(frozen=True)
class Inverter:
    """A control period, and a dead time that belongs to it."""

    name: str
    period_us: int
    dead_us: float

    @property
    def settings(self) -> Settings:
        return {"drive.period_us": self.period_us, f"plant.{DEAD_TIME}": self.dead_us}

    @property
    def label(self) -> str:
        return f"{self.period_us} µs, dead time {self.dead_us:g} µs"


ORDINARY, HARSH = Inverter("ordinary", 125, 3.0), Inverter("harsh", 25, 1.5)
INVERTERS = (HARSH, ORDINARY)


def plant_settings() -> Settings:
    """What the plant has that an ideal one has not, but for its dead time."""
    own = drive_file.own_keys(FILE)
    return {key: value for key, value in own.items() if key.startswith("plant.") and not key.endswith(DEAD_TIME)}


def shown(settings: Settings) -> str:
    """What the drive is told."""
    told_keys = {k: value for k, value in settings.items() if k.startswith(TOLD) and not isinstance(value, str)}
    return ", ".join(f"{key.split('.')[-1]} {value:.4g}" for key, value in told_keys.items())


def identified(inverter: Inverter, mil: Path, directory: Path, parts: tuple[str, ...] = INVERTER_PARTS) -> Path:
    """The file of the drive with this inverter, and of what these parts of `identify` find."""
    work = directory / f"honest_{inverter.name}{'_all' if parts == ALL_PARTS else ''}"
    results = identification.identified(FILE, mil, work, parts, inverter.settings)
    write_files(work, FILE, results)
    (work / "identify.txt").write_text(report(results) + "\n", encoding="utf-8")
    settings = drive_file.read(FILE) | inverter.settings | told(results)
    print(f"{inverter.label}: {shown(settings)}", flush=True)
    return write_toml(work.with_suffix(".toml"), settings)
