"""The tables of docs/fault_campaign.md."""

from pathlib import Path

from studies.page import counted, put_into, table

from .false_trips import Hours

PERIOD_MS = 0.025


def _time(ms: float) -> str:
    """In control periods T where there are few of them."""
    periods = round(ms / PERIOD_MS)
    return f"{periods} T" if periods <= 8 else f"{ms:.4g} ms"


def fault_table(faults: list[dict]) -> str:
    head = ("injection", "fault", "observable", "worst reaction", "since cause [ms]")
    rows = [
        (
            one["name"],
            one["fault"],
            one["observable"],
            _time(one["reaction_ms"])
            + (f", **{one['missed']} missed**" if one["missed"] else "")
            + (f", **{one['late']} later than {_time(one['bound_ms'])}**" if one["late"] else ""),
            f"{one['since_cause_ms']:.4g}",
        )
        for one in faults
    ]
    return table(head, rows, left=(0, 1, 2))


def trip_list(hours: list[Hours]) -> str:
    """Driving without a fault: what tripped in it, and what did not."""
    lines = []
    for one in hours:
        if one.faults:
            faults = ", ".join(f"{name} {count}" for name, count in sorted(one.faults.items()))
            lines.append(f"- {_driven(one)}: **{counted(sum(one.faults.values()), 'false trip')}**: {faults}")
    quiet = "; ".join(_driven(one) for one in hours if not one.faults)
    return "\n".join([*lines, *([f"- no trip: {quiet}"] if quiet else [])])


def _driven(one: Hours) -> str:
    return f"{one.kind} ({one.simulated_s:.0f} s)"


def write(page: Path, seeds: int, faults: list[dict], hours: list[Hours]) -> None:
    """Puts the tables into the page."""
    names = ("runs", "missed", "late", "runs_inside", "trips_inside")
    runs, missed, late, inside, trips = (sum(one[name] for one in faults) for name in names)
    size = f"{counted(seeds, 'seed')} at 3 operating points, with ideal and with real sensors: {counted(runs, 'run')}, "
    size += f"{missed} missed, {late} later than their bounds.\n"
    size += f"Just inside the limits: {inside} runs, {trips} trips."
    put_into(page, {"size": size, "faults": fault_table(faults), "trips": trip_list(hours)})
