"""docs/paper/README.md, made of its template and of the committed numbers alone."""

from collections.abc import Callable
from pathlib import Path

from studies.page import filled, table
from studies.page import number as text

from .defaults import PREFIX
from .numbers import Numbers
from .vehicle import KINDS

TEMPLATE = Path(__file__).with_name("page.md")


def vehicle_table(n: Numbers) -> str:
    lines = (
        ("speed error, RMS [rad/s]", "speed_error_rms_rad_s", ".3f"),
        ("torque error, RMS [N·m]", "torque_error_rms_nm", ".2f"),
        ("… worst [N·m]", "torque_error_max_nm", ".1f"),
        ("largest phase current [A]", "peak_current_a", ".0f"),
        ("flux below 95 % [% of the time]", "flux_low_percent", ".0f"),
        ("efficiency, shaft / (drawn − fed back) [%]", "efficiency_percent", ".1f"),
        ("braking energy recovered on balance [%]", "recovered_net_percent", ".0f"),
    )
    rows = [[what, *(text(n[f"vehicle/{kind}/{key}"], form) for kind in KINDS)] for what, key, form in lines]
    return table(["NYCC, one motor of two", "event-exact", "sampled 25 µs"], rows)


def defaults_table(n: Numbers) -> str:
    rows = [[*name.split("/"), f"{count:.0f}"] for name, count in n.under(PREFIX).items()]
    return table(["key", "default", "here", "scenarios"], [[f"`{key}`", *more] for key, *more in rows])


TABLES: dict[str, Callable[[Numbers], str]] = {
    "defaults": defaults_table,
    "vehicle": vehicle_table,
}


def render(numbers: Numbers) -> str:
    values = {name: number.value for name, number in numbers.entries.items()}
    return filled(TEMPLATE, values | {name: made(numbers) for name, made in TABLES.items()})
