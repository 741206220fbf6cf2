"""Which defaults of the drive the paper's scenarios switch off, by the configuration in force of each."""

import re
from collections import Counter

from sextant_py.paths import ROOT

from .lab import SCENARIOS, Lab
from .numbers import Numbers

PREFIX = "switched_off/"
DRIVE = ("control", "drive", "command", "capability", "protection", "torque_monitor")
_SECTION = re.compile(r"\[([\w.]+)\]")
_KEY = re.compile(r"(\w+) = (.+?)  # (.*); default (.+)")


def is_off(value: str, meaning: str, default: str) -> bool:
    """A flag that is false, a number that is zero, a name that is another one, and not so by default; of a number that
    is derived a zero of which the meaning says that it switches off."""
    if default in ("true", "false"):
        return (value, default) == ("false", "true")
    if default.startswith('"'):
        return value != default
    try:
        if default.startswith("derived"):
            return float(value) == 0.0 and "0: not" in meaning
        return float(value) == 0.0 != float(default)
    except ValueError:  # not set
        return False


def switched_off(configuration: str) -> list[tuple[str, str, str]]:
    """Keys of the drive that are off, with default and value, of the text of `--print-config`."""
    section, found = "", []
    for line in configuration.splitlines():
        if head := _SECTION.fullmatch(line):
            section = head[1]
        elif (key := _KEY.fullmatch(line)) and section.split(".")[0] in DRIVE and is_off(key[2], key[3], key[4]):
            found.append((f"{section}.{key[1]}", key[4].strip('"'), key[2].strip('"')))
    return found


def measure_defaults(lab: Lab, numbers: Numbers, quick: bool) -> None:
    """The number of scenarios that switch each of them off."""
    scenarios = sorted(file.stem for file in (ROOT / SCENARIOS).glob("*.toml"))
    counts = Counter(off for scenario in scenarios for off in switched_off(lab.configuration(scenario)))
    command = f"sextant-mil {SCENARIOS}/*.toml --print-config"
    for (key, default, value), count in counts.items():
        meaning = f"of {len(scenarios)} scenarios: {key} is {value}, by default {default}"
        numbers.add(f"{PREFIX}{key}/{default}/{value}", count, "scenarios", 0.0, meaning, command)


def gone(committed: Numbers, now: Numbers) -> list[str]:
    """A sentence for every default that is committed as switched off and is not."""
    names = committed.under(PREFIX).keys() - now.under(PREFIX).keys()
    return [f"{PREFIX}{name}: committed, but no scenario switches it off" for name in sorted(names)]
