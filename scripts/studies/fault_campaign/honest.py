"""The fault campaign of the drive on an honest plant, told what `identify` finds there, and its tables."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from studies import honest_drive
from studies.page import counted, put

from . import false_trips
from . import file as fault_campaign_file
from .file import faults_table
from .library import injections_table
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


def tables(found: Found) -> str:
    return "\n\n".join((injections(found), trip_list(found.hours)))


def write(page: Path, found: Found, seeds: int) -> None:
    """Puts the tables into the page."""
    text = page.read_text(encoding="utf-8")
    places = len(fault_campaign_file.PLACES)
    size = f"{counted(seeds, 'seed')} at {places} operating points: {counted(len(found.all_runs), 'run')}."
    text = put(text, "honest size", size)
    text = put(text, "honest", injections_table(found.all_runs, with_latest=True))
    page.write_text(put(text, "honest hours", trip_list(found.hours)), encoding="utf-8")
