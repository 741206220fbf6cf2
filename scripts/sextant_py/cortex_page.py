"""The figures of the drive on a microcontroller: docs/embedded.json, and the tables of docs/embedded.md made of it."""

import json
import re

from .firmware_image import IN_FLASH
from .paths import ROOT

FIGURES = ROOT / "docs" / "embedded.json"
PAGE = ROOT / "docs" / "embedded.md"
NAMES = {
    "drive_step": "`Drive::step`",
    "drive_step_driven": "the same, gates driven",
    "controller_step": "`DirectTorqueController::step`",
    "controller_step_driven": "the same, gates driven",
    "plant_period_driven": "plant, one period, gates driven",
    "plant_period_open": "plant, one period, gates open",
}
UNITS = {
    "torque": "torque [N·m]",
    "psi_s_alpha": "flux, α [Wb]",
    "psi_s_beta": "flux, β [Wb]",
    "plant_i_alpha": "plant: current, α [A]",
    "plant_tau_e": "plant: torque [N·m]",
    "plant_omega_m": "plant: speed [rad/s]",
}


def load() -> dict:
    return json.loads(FIGURES.read_text(encoding="utf-8"))


def text_of(figures: dict) -> str:
    return json.dumps(figures, indent=1, ensure_ascii=False) + "\n"


def _row(*cells: object) -> str:
    return "| " + " | ".join(str(cell) for cell in cells) + " |"


def _size_table(figures: dict) -> list[str]:
    sizes = figures["firmware_bytes"]
    sections = ", ".join(f"`{name}` {size:,}" for name, size in sizes["sections"].items() if name in IN_FLASH)
    return [
        _row("firmware with the whole drive", "bytes"),
        _row("---", "---:"),
        _row(f"flash ({sections})", f"{sizes['flash']:,}"),
        _row("RAM: `.data` and `.bss`", f"{sizes['ram']:,}"),
        _row("stack, the most it held, interrupt included", f"{sizes['stack']:,}"),
    ]


def _symbol_table(figures: dict) -> list[str]:
    rows = [_row("largest functions and objects", "bytes"), _row("---", "---:")]
    for symbol in figures["firmware_bytes"]["largest"]:
        short = re.sub(r"\(anonymous namespace\)::|sextant::", "", symbol["name"]).split("(")[0]
        rows.append(_row(f"`{short}`", f"{symbol['size']:,}"))
    return rows


def _instruction_table(figures: dict) -> list[str]:
    runs = figures["runs"]
    rows = [
        _row("instructions", *(f"{name}: mean" + " | " + f"{name}: most" for name in runs)),
        _row("---", *("---:" for _ in range(2 * len(runs)))),
    ]
    for key, name in NAMES.items():
        counts = [r["instructions"][key] for r in runs.values()]
        rows.append(_row(name, *(f"{c['mean']:,.0f} | {c['max']:,}" for c in counts)))
    return rows


def _clock_table(figures: dict) -> list[str]:
    ratio = figures["cycles_per_instruction"]
    least = figures["least_clock_mhz"]
    counts = [r["instructions"]["drive_step"] for r in figures["runs"].values()]
    mean = max(c["mean"] for c in counts) * ratio["mean"] / 168
    most = max(c["max"] for c in counts) * ratio["max"] / 168
    return [
        _row("estimate, not measured", "value"),
        _row("---", "---:"),
        _row("clock cycles an instruction of `Drive::step`, mean and most", f"{ratio['mean']} and {ratio['max']}"),
        _row("`Drive::step` at 168 MHz, mean and most", f"{mean:.1f} and {most:.1f} µs"),
        _row("least clock for `Drive::step` within 25 µs, gates driven", f"{least['drive_step_driven']} MHz"),
        _row("the same, in every period of the runs", f"{least['drive_step']} MHz"),
    ]


def _golden_table(figures: dict) -> list[str]:
    runs = figures["runs"]
    kinds = {
        "target": "Cortex-M4F",
        "target_unfused": "Cortex-M4F, unfused",
        "host_double": "host in `double`",
    }
    columns = [(name, kind) for name in runs for kind in kinds]
    rows = [
        _row("largest difference from the host in `float`", *(f"{kinds[kind]}, {name}" for name, kind in columns)),
        _row("---", *("---:" for _ in columns)),
    ]

    def of(name: str, kind: str) -> dict:
        return runs[name]["against_host_float"][kind]

    def cells(value: callable) -> list[str]:
        return [str(value(of(*column))) for column in columns]

    rows.append(_row("periods", *(f"{runs[name]['periods']:,}" for name, _ in columns)))
    rows.append(_row("periods with another decision", *cells(lambda c: c["different"])))
    rows.append(_row("equal in every bit", *cells(lambda c: "yes" if c["bit_identical"] else "no")))
    for key, title in UNITS.items():
        rows.append(_row(title, *cells(lambda c, key=key: f"{c['largest'][key]:.1e}" if c["largest"][key] else "0")))
    return rows


TABLES = {
    "sizes": _size_table,
    "symbols": _symbol_table,
    "instructions": _instruction_table,
    "clock": _clock_table,
    "golden": _golden_table,
}


def table(figures: dict) -> str:
    """All tables, for a terminal."""
    parts = [f"{figures['processor']}, {figures['compiler']}"]
    return "\n\n".join([*parts, *("\n".join(make(figures)) for make in TABLES.values())])


def rendered(page: str, figures: dict) -> str:
    """The page with its tables made anew; they stand between <!-- NAME --> and <!-- end -->."""
    for name, make in TABLES.items():
        block = f"<!-- {name} -->\n" + "\n".join(make(figures)) + "\n<!-- end -->"
        page, count = re.subn(rf"<!-- {name} -->\n.*?<!-- end -->", lambda _, b=block: b, page, flags=re.DOTALL)
        if count != 1:
            raise ValueError(f"{PAGE.name} has {count} places for the table {name}")
    return page


def save(figures: dict) -> None:
    FIGURES.write_text(text_of(figures), encoding="utf-8")
    PAGE.write_text(rendered(PAGE.read_text(encoding="utf-8"), figures), encoding="utf-8")


def differences() -> list[str]:
    """The page must be what its figures make of it."""
    page = PAGE.read_text(encoding="utf-8")
    if rendered(page, load()) == page:
        return []
    return ["a table of docs/embedded.md is not what docs/embedded.json makes of it; --update writes both"]
