"""sextant-mil as a sweep sees it: how it is called, and what it says of a scenario without running it."""

import hashlib
import re
import subprocess
from dataclasses import dataclass
from pathlib import Path

from . import printed_configuration, sweep_file
from .errors import UserError
from .sweep_file import Settings, Sweep, toml_value
from .sweep_point import clean_reason

FIRST_POINTS = 20  # tried for values with which the scenario can stand
LONGEST_NAME = 255  # that a file can have [byte]
_HEADING = re.compile(r"^\[([\w.]+)\]$")
_ENTRY = re.compile(r"^(?:# )?(\w+) = .*?#.*?\[([^\]]*)\];")


@dataclass
class Scenario:
    """The scenario's configuration in force, as sextant-mil prints it."""

    text: str

    def units(self) -> dict[str, str]:
        """Units of keys and of metrics."""
        table, units = "", {}
        for line in self.text.splitlines():
            if heading := _HEADING.match(line):
                table = heading[1]
            elif entry := _ENTRY.match(line):
                unit = "" if entry[2] == "1" else entry[2]
                units[f"{table}.{entry[1]}" if table else entry[1]] = unit
                if table.startswith("expect."):
                    units[table.removeprefix("expect.")] = unit
        return units

    def metrics(self) -> list[str]:
        """Every metric that a run has."""
        return re.findall(r"^\[expect\.(\w+)\]$", self.text, re.MULTILINE)


def fingerprint(program: Path) -> str:
    return hashlib.sha256(program.read_bytes()).hexdigest()


def contents(scenario: Scenario, sweep: Sweep) -> str:
    """The configuration in force and the fingerprint of every file that it or a point names."""
    values = {value for point in sweep.points for value in point.values() if isinstance(value, str)}
    values.update(re.findall(r'"([^"\n]+)"', scenario.text))
    places = (sweep.scenario.parent, sweep.file.resolve().parent)
    files = {(place / value).resolve() for value in values for place in places if len(value.encode()) <= LONGEST_NAME}
    return scenario.text + "".join(f"{file} {fingerprint(file)}\n" for file in sorted(files) if file.is_file())


def command(program: Path, sweep: Sweep, settings: Settings) -> list[str]:
    """The call of a point, without its directory."""
    found = [str(program), str(sweep.scenario)]
    for key, value in {**sweep.fixed, **settings}.items():
        found += ["--set", f"{key}={toml_value(value)}"]
    return found


def _print_config(program: Path, sweep: Sweep, settings: list[str]) -> subprocess.CompletedProcess:
    return printed_configuration.ask(program, sweep.scenario, settings, sweep.file.resolve().parent)


def _unknown(key: str, said: str) -> str | None:
    """What sextant-mil says of a key that it does not know, or of a table in which it lies."""
    for name, sentence in re.findall(r"--set: ([^\s:]+): (unknown key.*)", said):
        if f"{key}.".startswith(f"{name}."):
            return sentence
    return None


def _configuration(program: Path, sweep: Sweep) -> str:
    """The configuration in force with [set]; with a point's values as well where it cannot stand without them."""
    refusal = ""
    for settings in ({}, *sweep.points[:FIRST_POINTS]):
        found = _print_config(program, sweep, command(program, sweep, settings)[2:])
        if found.returncode == 0:
            return found.stdout
        refusal = refusal or clean_reason(found.stderr, program.name)
    raise UserError(f"{sweep.file}: the scenario is refused: {refusal}.")


def examine(program: Path, sweep: Sweep) -> Scenario:
    """The scenario as every point begins with it. Keys and metrics that it does not know are refused.

    A value that is out of range is not: the point has it as its reason.
    """
    for key, value in {**sweep.points[0], **sweep.fixed}.items():
        said = _print_config(program, sweep, ["--set", f"{key}={toml_value(value)}"]).stderr
        if sentence := _unknown(key, said):
            raise sweep_file.refuse_key(sweep, key, f"{sentence}.")
    scenario = Scenario(_configuration(program, sweep))
    for metric in sweep.plot.metrics:
        if metric not in scenario.metrics():
            known = ", ".join(scenario.metrics())
            raise sweep_file.refuse_plot(sweep, f'no metric is called "{metric}"; known are {known}.')
    return scenario
