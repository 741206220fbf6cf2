"""The fault campaign on machines of the library, under every method and at two control periods, and its tables."""

from pathlib import Path

from sextant_py.control_methods import METHODS
from sextant_py.sweep_file import toml_value

from studies.machine_library.points import Machine, read_library
from studies.page import counted, table
from studies.plant_faults import MISSED, OTHERWISE, REFUSED, injections_table

from .false_trips import Hours
from .file import PLACES, STEADY, Campaign, Found, cases
from .page import trip_list

MACHINES = ("marathon_quarter_hp", "motulator_2k2", "modelica_24k", "mathworks_215hp")
PERIODS_US = (50, 125)
SEEDS = 1
DRIVING_MACHINES = MACHINES[1:]
DRIVING_PERIOD_US = 125
DRIVING_METHODS = ("dtc", "foc")


def machines() -> list[Machine]:
    return [machine for machine in read_library() if machine.id in MACHINES]


def campaign_of(machine: Machine, period_us: int, mil: Path, directory: Path) -> Campaign:
    """Nothing but machine, link and control period is set."""
    file = directory / f"{machine.id}_{period_us}us.toml"
    text = f"[machine]\nfile = {toml_value(str(machine.file))}\n[plant]\nu_dc_v = {machine.u_dc:g}\n"
    file.write_text(text + f"[drive]\nperiod_us = {period_us}\n", encoding="utf-8")
    return Campaign(file, mil, directory)


def measure(seeds: int, hours: float, jobs: int, mil: Path, directory: Path) -> Found:
    found = Found()
    for machine in machines():
        for period_us in PERIODS_US:
            campaign = campaign_of(machine, period_us, mil, directory)
            own = campaign.run_all(cases(METHODS, seeds), jobs, f"{machine.id}, {period_us} µs")
            found.runs += [one | {"machine": machine.name, "period_us": period_us} for one in own]
        if hours > 0 and machine.id in DRIVING_MACHINES:
            found.hours += driving(machine, hours, jobs, mil, directory)
    return found


def driving(machine: Machine, hours: float, jobs: int, mil: Path, directory: Path) -> list[Hours]:
    found = campaign_of(machine, DRIVING_PERIOD_US, mil, directory).hours(DRIVING_METHODS, hours, jobs)
    for one in found:
        one.kind = f"{machine.name}: {one.kind}"
    return found


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
    """For the terminal."""
    injections = injections_table(found.runs, with_latest=False)
    return "\n\n".join((injections, methods_table(found.runs), trip_list(found.hours)))


def blocks(found: Found, seeds: int) -> dict[str, str]:
    """By mark of the page."""
    size = f"{counted(seeds, 'seed')} at {len(PLACES)} operating points: {counted(len(found.runs), 'run')}."
    return {
        "library size": size,
        "library": injections_table(found.runs, with_latest=False),
        "library methods": methods_table(found.runs),
        "library hours": trip_list(found.hours),
    }
