"""The figures of the drive on a microcontroller, results.json, and the tables of docs/embedded.md made of it."""

import re
from pathlib import Path

from sextant_py.paths import ROOT

from studies import json_file, page

from .firmware_image import IN_FLASH

FIGURES = Path(__file__).with_name("results.json")
COMMITTED = FIGURES.relative_to(ROOT)  # as messages name it
PAGE = ROOT / "docs" / "embedded.md"
NAMES = {
    "drive_step": "`Drive::step`",
    "drive_step_driven": "the same, gates driven",
    "controller_step": "`DirectTorqueController::step`",
    "controller_step_driven": "the same, gates driven",
    "plant_period_driven": "plant, one period, gates driven",
    "plant_period_gates_off": "plant, one period, gates off",
}
UNITS = {
    "torque": "torque [N·m]",
    "psi_s_alpha": "flux, α [Wb]",
    "plant_tau_e": "plant: torque [N·m]",
}
KINDS = {"target": "Cortex-M4F", "target_unfused": "Cortex-M4F, unfused", "host_double": "host in `double`"}


def load() -> dict:
    return json_file.read(FIGURES, dict[str, object], "check_cortex_m --update")


def write_figures(figures: dict, file: Path) -> None:
    json_file.write(file, figures, levels=3)


def _sizes(figures: dict) -> str:
    sizes = figures["firmware_bytes"]
    sections = ", ".join(f"`{name}` {size:,}" for name, size in sizes["sections"].items() if name in IN_FLASH)
    names = {f"flash ({sections})": "flash", "RAM: `.data` and `.bss`": "ram"}
    names |= {"stack, the most it held, interrupt included": "stack"}
    return page.table(("firmware with the whole drive", "bytes"), ((k, f"{sizes[v]:,}") for k, v in names.items()))


def _symbols(figures: dict) -> str:
    def short(name: str) -> str:
        return re.sub(r"\(anonymous namespace\)::|sextant::", "", name).split("(")[0]

    largest = figures["firmware_bytes"]["largest"]
    rows = ((f"`{short(symbol['name'])}`", f"{symbol['size']:,}") for symbol in largest)
    return page.table(("largest functions and objects", "bytes"), rows)


def _instructions(figures: dict) -> str:
    runs = figures["runs"]
    rows = []
    for key, name in NAMES.items():
        counts = [r["instructions"][key] for r in runs.values()]
        rows.append((name, *(text for c in counts for text in (f"{c['mean']:,.0f}", f"{c['max']:,}"))))
    heads = (f"{name}: {which}" for name in runs for which in ("mean", "most"))
    return page.table(("instructions", *heads), rows)


def _methods(figures: dict) -> str:
    rows = ((f"`{name}`", f"{c['mean']:,.0f}", f"{c['max']:,}") for name, c in figures["methods"].items())
    return page.table(("instructions of a step, gates driven, delayed", "mean", "most"), rows)


def _golden(figures: dict) -> str:
    runs = figures["runs"]
    found = {(name, kind): runs[name]["against_host_float"][kind] for name in runs for kind in KINDS}
    rows = [
        ("periods with another decision", *(c["different"] for c in found.values())),
        ("equal in every bit", *("yes" if c["bit_identical"] else "no" for c in found.values())),
    ]
    for key, title in UNITS.items():
        largest = (c["largest"][key] for c in found.values())
        rows.append((title, *(f"{value:.1e}" if value else "0" for value in largest)))
    head = ("largest difference from the host in `float`", *(f"{KINDS[kind]}, {name}" for name, kind in found))
    return page.table(head, rows)


TABLES = {"sizes": _sizes, "instructions": _instructions, "golden": _golden}  # of the page
TERMINAL = {**TABLES, "symbols": _symbols, "methods": _methods}


def table(figures: dict) -> str:
    """All tables, for a terminal."""
    return "\n\n".join(
        [f"{figures['processor']}, {figures['compiler']}", *(make(figures) for make in TERMINAL.values())]
    )


def rendered(text: str, figures: dict) -> str:
    """The page with its tables made anew."""
    return page.put(text, {name: make(figures) for name, make in TABLES.items()})


def save(figures: dict) -> None:
    write_figures(figures, FIGURES)
    PAGE.write_text(rendered(PAGE.read_text(encoding="utf-8"), figures), encoding="utf-8")


def differences() -> list[str]:
    """The page must be what its figures make of it."""
    text = PAGE.read_text(encoding="utf-8")
    if rendered(text, load()) == text:
        return []
    return [f"a table of docs/embedded.md is not what {COMMITTED} makes of it; --update writes both"]
