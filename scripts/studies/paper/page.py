"""docs/paper/README.md, made of its template and of the committed numbers alone."""

from collections.abc import Callable
from pathlib import Path

from studies.page import filled, table
from studies.page import number as text

from .cycle import FIGURES
from .defaults import PREFIX
from .numbers import Numbers
from .vehicle import KINDS

RESPONSE_STEPS = (2, 15, 30, 65, 130)
TEMPLATE = Path(__file__).with_name("page.md")


def response_table(n: Numbers) -> str:
    columns = (("centred/dead", ".2f"), ("v1/dead", ".2f"), ("centred/magnetised", ".3f"))
    rows = [
        [
            f"{step}",
            *(text(n[f"response/{key}/{step}"], form) for key, form in columns),
            text(n[f"surge/centred/{step}"], ".0f"),
        ]
        for step in RESPONSE_STEPS
    ]
    head = ["step [N·m]", "centred [ms]", "from V1 [ms]", "magnetised [ms]", "surge, centred [A]"]
    return table(head, rows)


def table6(n: Numbers) -> str:
    rows = []
    for (upper, lower), figure in sorted(FIGURES.items(), key=lambda item: item[1]):
        name = f"table6/{upper}/{lower}/"

        def cell(key: str, form: str, name: str = name) -> str:
            return text(n[name + key], form)

        rows.append(
            [
                f"{figure}",
                f"{upper:g}",
                f"{lower:g}",
                cell("drive_low_nm", ".2f") + " … " + cell("drive_high_nm", "+.2f"),
                cell("rest_low_nm", ".2f") + " … " + cell("rest_high_nm", "+.2f"),
                cell("leg_hz", "k2"),
                cell("first_dead_s", ".2f"),
                cell("first_error_nm", ".2f"),
                cell("first_a", ".0f"),
            ]
        )
    head = ["Figure", "upper", "lower", "driving [N·m]", "at rest [N·m]", "leg [kHz]"]
    head += ["no torque for [s]", "worst error [N·m]", "surge [A]"]
    return table(head, rows)


def cycle_table(n: Numbers) -> str:
    lines = (
        ("torque error, RMS [N·m]", "torque_error_rms_nm", ".3f"),
        ("… worst after 0.2 s [N·m]", "torque_error_max_nm", ".2f"),
        ("surges above 25 A", "surges", ".0f"),
        ("largest current vector [A]", "surge_worst_a", ".0f"),
        ("flux below 95 % [% of the time]", "flux_low_percent", ".0f"),
        ("least flux [Wb]", "flux_min_wb", ".3f"),
        ("drawn less fed back [kJ]", "net_j", "k1"),
        ("work on the shaft [kJ]", "energy_shaft_j", "k1"),
        ("lost in the windings [kJ]", "energy_copper_j", "k1"),
    )
    kinds = ("linear", "clip", "origin", "sampled")
    rows = [
        [what, *(text(n[f"nycc/{k}/{key}"], form) if f"nycc/{k}/{key}" in n else "" for k in kinds)]
        for what, key, form in lines
    ]
    return table(["NYCC, 598 s", "linear", "clip", "origin", "linear, sampled"], rows)


def vehicle_table(n: Numbers) -> str:
    lines = (
        ("speed error, RMS [rad/s]", "speed_error_rms_rad_s", ".3f"),
        ("… worst [km/h]", "speed_error_max_kmh", ".2f"),
        ("torque error, RMS [N·m]", "torque_error_rms_nm", ".2f"),
        ("… worst [N·m]", "torque_error_max_nm", ".1f"),
        ("largest phase current [A]", "peak_current_a", ".0f"),
        ("flux below 95 % [% of the time]", "flux_low_percent", ".0f"),
        ("drawn from the link, means of 10 ms [kJ]", "from_10_ms_j", "k1"),
        ("fed back [kJ]", "to_10_ms_j", "k1"),
        ("net work on the shaft [kJ]", "energy_shaft_j", "k1"),
        ("lost in the windings [kJ]", "energy_copper_j", "k1"),
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
    "response": response_table,
    "table6": table6,
    "cycle": cycle_table,
    "vehicle": vehicle_table,
}


def render(numbers: Numbers) -> str:
    values = {name: number.value for name, number in numbers.entries.items()}
    return filled(TEMPLATE, values | {name: made(numbers) for name, made in TABLES.items()})
