"""The fault campaign on machines of the library, under every method and at two control periods, and its tables."""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from sextant_py.control_methods import METHODS
from sextant_py.sweep_file import toml_value

from studies.machine_library.points import Machine, read_library
from studies.page import counted, put, table
from studies.plant_faults import KINDS, MISSED, NAMED, OTHERWISE, REFUSED

from . import false_trips
from . import file as fault_campaign_file
from .file import STEADY
from .page import trip_list

MACHINES = ("marathon_quarter_hp", "motulator_2k2", "modelica_24k", "mathworks_215hp")
PERIODS_US = (50, 125)
SEEDS = 1
DRIVING_MACHINES = MACHINES[1:]
DRIVING_PERIOD_US = 125
DRIVING_METHODS = ("dtc", "foc")
Progress = Callable[[int, str], Callable[[], None]]


@dataclass
class Found:
    """Runs, each with its machine and period; and driving without a fault."""

    runs: list[dict]
    hours: list[false_trips.Hours]

    @property
    def all_runs(self) -> list[dict]:
        return self.runs


def machines() -> list[Machine]:
    return [machine for machine in read_library() if machine.id in MACHINES]


def campaign_of(machine: Machine, period_us: int, mil: Path, directory: Path) -> fault_campaign_file.Campaign:
    """Nothing but machine, link and control period is set."""
    file = directory / f"{machine.id}_{period_us}us.toml"
    text = f"[machine]\nfile = {toml_value(str(machine.file))}\n[plant]\nu_dc_v = {machine.u_dc:g}\n"
    file.write_text(text + f"[drive]\nperiod_us = {period_us}\n", encoding="utf-8")
    return fault_campaign_file.Campaign(file, mil, directory)


def measure(seeds: int, hours: float, jobs: int, mil: Path, directory: Path, progress: Progress) -> Found:
    plan = fault_campaign_file.cases(METHODS, seeds)
    found = Found([], [])
    for machine in machines():
        for period_us in PERIODS_US:
            campaign = campaign_of(machine, period_us, mil, directory)
            step = progress(len(plan), f"{machine.id}, {period_us} µs")
            own = campaign.run_all(plan, jobs, step)
            found.runs += [one | {"machine": machine.name, "period_us": period_us} for one in own]
        if hours > 0 and machine.id in DRIVING_MACHINES:
            found.hours += driving(machine, hours, jobs, mil, directory)
    return found


def driving(machine: Machine, hours: float, jobs: int, mil: Path, directory: Path) -> list[false_trips.Hours]:
    found = campaign_of(machine, DRIVING_PERIOD_US, mil, directory).hours(DRIVING_METHODS, hours, jobs)
    for one in found:
        one.kind = f"{machine.name}: {one.kind}"
    return found


def injections_table(runs: list[dict]) -> str:
    """By injection, over all machines, periods and methods; refused runs where there are any."""
    kinds = [kind for kind in KINDS if kind != REFUSED or any(one["kind"] == REFUSED for one in runs)]
    groups: dict[str, list[dict]] = {}
    for one in runs:
        groups.setdefault(one["name"], []).append(one)
    rows = []
    for name, own in groups.items():
        counts = Counter(one["kind"] for one in own)
        seen = Counter(one["seen"] for one in own if one["kind"] in (NAMED, OTHERWISE))
        named = ", ".join(f"{fault} {count}" for fault, count in seen.most_common()) or "–"
        rows.append((name, len(own), *(counts[kind] for kind in kinds), named))
    head = ("injection", "runs", *kinds, "tripped as")
    return table(head, rows, left=(0, len(head) - 1))


def methods_table(runs: list[dict]) -> str:
    """Missed faults of those injected, and trips of runs without a fault, by machine and method."""
    groups: dict[str, list[dict]] = {}
    for one in runs:
        groups.setdefault(one["machine"], []).append(one)
    rows = [
        (machine, *(_missed([one for one in own if one["method"] == method]) for method in METHODS))
        for machine, own in groups.items()
    ]
    return table(("machine", *(f"`{method}`" for method in METHODS)), rows)


def _missed(own: list[dict]) -> str:
    faulty = [one for one in own if one["name"] != STEADY]
    missed = sum(one["kind"] == MISSED for one in faulty)
    refused = sum(one["kind"] == REFUSED for one in own)
    tripped = sum(one["name"] == STEADY and one["kind"] == OTHERWISE for one in own)
    text = f"{missed}/{len(faulty)}"
    text += f", {tripped} false" if tripped else ""
    return text + (f", {refused} refused" if refused else "")


def tables(found: Found) -> str:
    return "\n\n".join((injections_table(found.runs), methods_table(found.runs), trip_list(found.hours)))


def write(page: Path, found: Found, seeds: int) -> None:
    """Puts the tables into the page."""
    text = page.read_text(encoding="utf-8")
    text = put(
        text, "library size", f"{counted(seeds, 'seed')} at 5 operating points: {counted(len(found.runs), 'run')}."
    )
    text = put(text, "library", injections_table(found.runs))
    text = put(text, "library methods", methods_table(found.runs))
    page.write_text(put(text, "library hours", trip_list(found.hours)), encoding="utf-8")
