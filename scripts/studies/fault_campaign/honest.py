"""The fault campaign of the drive on an honest plant, told what `identify` finds there, and its tables."""

from pathlib import Path

from studies import honest_drive
from studies.plant_faults import injections_table

from .file import Campaign, Found, cases, size_of
from .page import trip_list

SEEDS = 1
DRIVING = honest_drive.ORDINARY


def measure(seeds: int, hours: float, jobs: int, mil: Path, directory: Path) -> Found:
    found = Found()
    for inverter in honest_drive.INVERTERS:
        campaign = Campaign(honest_drive.identified(inverter, mil, directory), mil, directory)
        own = campaign.run_all(cases(honest_drive.METHODS, seeds, campaign.sensors), jobs, inverter.label)
        found.runs += [one | {"inverter": inverter.label} for one in own]
        if hours > 0 and inverter is DRIVING:
            found.hours = campaign.hours(honest_drive.METHODS, hours, jobs)
    return found


def tables(found: Found) -> str:
    """For the terminal: the injections by inverter."""
    labels = dict.fromkeys(one["inverter"] for one in found.runs)
    runs = {label: [one for one in found.runs if one["inverter"] == label] for label in labels}
    own = (f"{label}:\n\n{injections_table(of, ('name', 'method'))}" for label, of in runs.items())
    return "\n\n".join((*own, trip_list(found.hours)))


def blocks(found: Found, seeds: int) -> dict[str, str]:
    """By mark of the page."""
    return {
        "honest size": size_of(found, seeds),
        "honest": injections_table(found.runs),
        "honest hours": trip_list(found.hours),
    }
