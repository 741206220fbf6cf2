"""docs/paper/README.md, made of its template and of the committed numbers alone."""

from pathlib import Path

from studies.page import filled, table

from .defaults import PREFIX
from .numbers import Numbers

TEMPLATE = Path(__file__).with_name("page.md")


def defaults_table(n: Numbers) -> str:
    rows = [[*name.split("/"), f"{count:.0f}"] for name, count in n.under(PREFIX).items()]
    return table(["key", "default", "here", "scenarios"], [[f"`{key}`", *more] for key, *more in rows])


def render(numbers: Numbers) -> str:
    values = {name: number.value for name, number in numbers.entries.items()}
    return filled(TEMPLATE, values | {"defaults": defaults_table(numbers)})
