"""Runs of sextant-mil without a trace, and those as short as can be: whether it takes a drive, and how."""

import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

from .errors import UserError
from .sweep_file import Settings, toml_value
from .sweep_point import clean_reason, read_summary
from .sweep_reader import set_words

SHORT: Settings = {"duration_s": 0.001}


def scenario_text(settings: Settings, name: str) -> str:
    """The file of a scenario of one second without torque, of a drive with these settings."""
    head = [f"name = {toml_value(name)}", "duration_s = 1", "[profile.torque_nm]", "value = 0"]
    return "\n".join([*(f"{key} = {toml_value(value)}" for key, value in settings.items()), *head]) + "\n"


@dataclass(frozen=True)
class Ended:
    summary: dict | None  # None where it left none
    said: str  # what it reported, or how it ended


def run_of(mil: Path, scenario: Path, settings: Settings, time_limit_s: float = 120) -> Ended:
    """One run of a scenario with these settings beside it."""
    with tempfile.TemporaryDirectory(prefix="sextant-run-") as out:
        command = [mil, scenario, *set_words(settings), "--no-trace", "--out", out]
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=time_limit_s)
        except subprocess.TimeoutExpired:
            return Ended(None, f"no result within {time_limit_s:g} s")
        return Ended(read_summary(Path(out)), clean_reason(done.stderr, mil.name) or f"exit status {done.returncode}")


def summary_of(mil: Path, scenario: Path, settings: Settings) -> dict:
    """Of one run that must have one."""
    ended = run_of(mil, scenario, settings)
    if ended.summary is None:
        raise UserError(f"{scenario}: sextant-mil refuses the drive: {ended.said}.")
    return ended.summary


def known_keys(mil: Path, directory: Path, machine: Settings) -> set[str]:
    """What this sextant-mil knows; machine: keys with their section."""
    scenario = directory / "known_keys.toml"
    scenario.write_text(scenario_text(machine, "known_keys"), encoding="utf-8")
    return set(summary_of(mil, scenario, SHORT)["configuration"])
