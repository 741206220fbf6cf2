"""docs/paper/README.md, made of its template and of the committed numbers alone."""

import math
import re
from collections.abc import Callable
from pathlib import Path

from studies.page import table

from .defaults import PREFIX
from .numbers import Numbers
from .vehicle import KINDS

TEMPLATE = Path(__file__).with_name("page.md")
_NUMBER = re.compile(r"\{([\w/.]+):([^{}]+)\}")
_TABLE = re.compile(r"^<!-- table (\w+) -->$", re.MULTILINE)
_PART = re.compile(r"^<!-- if ([\w/.]+) -->\n(.*?)^<!-- end -->\n", re.MULTILINE | re.DOTALL)


def text(value: float, form: str) -> str:
    """`k1` is thousands with one decimal; everything else is Python's. A true minus, a dash for no number."""
    if not math.isfinite(value):
        return "–"
    if form.startswith("k"):
        value, form = value / 1e3, f".{form[1:]}f"
    return f"{value:{form}}".replace("-", "−")


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


def render(numbers: Numbers, template: str | None = None) -> str:
    """The page. A number that it names and that is not there is an error: KeyError."""
    page = TEMPLATE.read_text(encoding="utf-8") if template is None else template
    page = _PART.sub(lambda part: part[2] if numbers.under(part[1]) else "", page)
    page = _TABLE.sub(lambda name: TABLES[name[1]](numbers), page)
    return _NUMBER.sub(lambda number: text(numbers[number[1]], number[2]), page)
