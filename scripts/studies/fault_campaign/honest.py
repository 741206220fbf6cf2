"""The fault campaign of the drive on an honest plant, told what `identify` finds there, and its tables."""

from collections import Counter
from pathlib import Path

from studies import honest_drive
from studies.page import counted
from studies.plant_faults import HARMLESS, KINDS, MISSED, injections_table

from .file import PLACES, STEADY, Campaign, Found, cases
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
    """For the terminal: the injections by inverter."""
    labels = dict.fromkeys(one["inverter"] for one in found.runs)
    runs = {label: [one for one in found.runs if one["inverter"] == label] for label in labels}
    own = (f"{label}:\n\n{injections_table(of, ('name', 'method'))}" for label, of in runs.items())
    return "\n\n".join((*own, trip_list(found.hours)))


def blocks(found: Found, seeds: int) -> dict[str, str]:
    """By mark of the page."""
    runs = f"{counted(seeds, 'seed')} at {len(PLACES)} operating points: {summary(found.runs)}"
    return {"honest": runs, "honest hours": trip_list(found.hours)}
