"""Runs of a drive as short as can be: whether sextant-mil takes it, and the configuration in force."""

import subprocess
import tempfile
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


def summary_of(mil: Path, scenario: Path, settings: Settings) -> dict:
    """Of one run that must have one."""
    with tempfile.TemporaryDirectory(prefix="sextant-run-") as out:
        command = [mil, scenario, *set_words(settings), "--no-trace", "--out", out]
        done = subprocess.run(command, capture_output=True, text=True, timeout=60)
        found = read_summary(Path(out))
    if found is None:
        raise UserError(f"{scenario}: sextant-mil refuses the drive: {clean_reason(done.stderr)}.")
    return found


def known_keys(mil: Path, directory: Path, machine: Settings) -> set[str]:
    """What this sextant-mil knows; machine: keys with their section."""
    scenario = directory / "known_keys.toml"
    scenario.write_text(scenario_text(machine, "known_keys"), encoding="utf-8")
    return set(summary_of(mil, scenario, SHORT)["configuration"])
