"""The fault campaign of the drive on an honest plant, told what `identify` finds there, and its tables."""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from studies import honest_drive
from studies.page import counted, put
from studies.plant_faults import HARMLESS, KINDS, MISSED

from . import false_trips
from . import file as fault_campaign_file
from .file import STEADY, faults_table
from .page import trip_list

SEEDS = 1
DRIVING = honest_drive.ORDINARY
Progress = Callable[[int, str], Callable[[], None]]


@dataclass
class Found:
    """Runs of each inverter by its label, and driving without a fault."""

    runs: dict[str, list[dict]]
    hours: list[false_trips.Hours]

    @property
    def all_runs(self) -> list[dict]:
        return [one for runs in self.runs.values() for one in runs]


def measure(seeds: int, hours: float, jobs: int, mil: Path, directory: Path, progress: Progress) -> Found:
    found = Found({}, [])
    for inverter in honest_drive.INVERTERS:
        file = honest_drive.identified(inverter, mil, directory)
        campaign = fault_campaign_file.Campaign(file, mil, directory)
        plan = fault_campaign_file.cases(honest_drive.METHODS, seeds, campaign.sensors)
        found.runs[inverter.label] = campaign.run_all(plan, jobs, progress(len(plan), inverter.label))
        if hours > 0 and inverter is DRIVING:
            found.hours = campaign.hours(honest_drive.METHODS, hours, jobs)
    return found


def injections(found: Found) -> str:
    """A table for each inverter."""
    return "\n\n".join(f"{label}:\n\n{faults_table(runs)}" for label, runs in found.runs.items())


def summary(runs: list[dict]) -> str:
    """One sentence; it names the faults that are missed."""
    healthy = [one for one in runs if one["name"] == STEADY]
    faulty = [one for one in runs if one["name"] != STEADY]
    counts = Counter(one["kind"] for one in faulty)
    missed = Counter(one["name"] for one in faulty if one["kind"] == MISSED)
    names = ", ".join(f"{count} of {name}" for name, count in missed.items())
    kinds = ", ".join(f"{counts[kind]} {kind}" for kind in KINDS if counts[kind] or kind == MISSED)
    latest = max((one["late_ms"] for one in faulty if one["late_ms"] is not None), default=0)
    tripped = sum(one["kind"] != HARMLESS for one in healthy)
    return (
        f"{counted(len(runs), 'run')}; {tripped} of {len(healthy)} without a fault trip. "
        f"Of {len(faulty)} faults: {kinds}{f' ({names})' if names else ''}. The latest trip: {latest:.4g} ms."
    )


def tables(found: Found) -> str:
    return "\n\n".join((injections(found), trip_list(found.hours)))


def write(page: Path, found: Found, seeds: int) -> None:
    """Puts the tables into the page."""
    text = page.read_text(encoding="utf-8")
    places = len(fault_campaign_file.PLACES)
    size = f"{counted(seeds, 'seed')} at {places} operating points: {summary(found.all_runs)}"
    text = put(text, "honest", size)
    page.write_text(put(text, "honest hours", trip_list(found.hours)), encoding="utf-8")
