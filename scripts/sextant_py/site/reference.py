"""Pages of reference: the CAN messages of the DBC, the topics of the IDL, the help of the commands, the headers."""

import re
import subprocess
import sys

from ..commands import COMMANDS
from ..contract import Contract
from ..paths import ROOT
from ..telemetry_contract import enumerations, enumerators, signals, structs

HEADERS = ROOT / "include" / "sextant"
_SENTENCE = re.compile(
    r"^((?:///.*\n)+)(?:template.*\n)?(?:\[\[nodiscard\]\] )?(class|struct|enum class|concept|\w)", re.MULTILINE
)


def cell(text: object) -> str:
    return str(text).replace("|", "\\|").replace("\n", " ").strip()


def row(*cells: object) -> str:
    return f"| {' | '.join(map(cell, cells))} |"


def table(headings: tuple[str, ...], rows: list[str]) -> str:
    return "\n".join([row(*headings), "|" + "---|" * len(headings), *rows]) + "\n"


def can_page() -> str:
    """Every message with its signals."""
    database = Contract().database
    parts = [
        f"# CAN messages\n\nContract {database.version}, from `configs/interfaces/sextant.dbc`, with the identifiers of"
        " offset 0. [The CAN contract](../can.md) has what a DBC cannot express.\n"
    ]
    for message in sorted(database.messages, key=lambda message: message.frame_id):
        cycle = f"every {message.cycle_time} ms" if message.cycle_time else "on change"
        sender = ", ".join(message.senders)
        parts.append(f"## 0x{message.frame_id:03X} {message.name}\n\n{cell(message.comment or '')}\n")
        parts.append(f"{message.length} bytes, {cycle}, from {sender}.\n")
        rows = []
        for signal in message.signals:
            choices = signal.choices or {}
            values = ", ".join(f"{value} {name}" for value, name in choices.items())
            span = "" if signal.minimum is None else f"{signal.minimum:g} … {signal.maximum:g}"
            text = " ".join(part for part in (signal.comment, f"Values: {values}." if values else "") if part)
            place = f"{signal.start}, {signal.length}{' signed' if signal.is_signed else ''}"
            rows.append(row(f"`{signal.name}`", place, f"{signal.scale:g}", signal.unit or "", span, text))
        parts.append(table(("signal", "bit, length", "factor", "unit", "range", "meaning"), rows))
    return "\n".join(parts)


def telemetry_page() -> str:
    """Every topic with its members, and the enumerations."""
    parts = [
        "# Telemetry\n\nFrom `configs/interfaces/telemetry.idl`. [Watch by DDS](../telemetry.md) has the networks.\n"
    ]
    for struct in structs():
        rows = [
            row(f"`{member.name}`", f"`{member.type}`", member.unit, member.text + (" (key)" if member.is_key else ""))
            for member in signals(struct)
        ]
        parts.append(f"## {struct}\n\nTopic `sextant/{struct}`.\n")
        parts.append(table(("member", "type", "unit", "meaning"), rows))
    for enumeration in enumerations():
        rows = [row(value, f"`{name}`") for value, name in enumerate(enumerators(enumeration))]
        parts += [f"## {enumeration}\n", table(("value", "name"), rows)]
    return "\n".join(parts)


def commands_page() -> str:
    parts = ["# Commands\n\n`sextant NAME` where the Python package is installed, `scripts/NAME` in a checkout.\n"]
    for name in COMMANDS:
        words = [sys.executable, "-m", "sextant_py", name, "--help"]
        said = subprocess.run(words, capture_output=True, text=True, check=True, cwd=ROOT / "scripts")
        parts.append(f"## {name}\n\n```text\n{said.stdout.rstrip()}\n```\n")
    return "\n".join(parts)


def first_sentence(text: str) -> str:
    """Of the first comment of a header that documents something."""
    found = _SENTENCE.search(text)
    if not found:
        return ""
    comment = " ".join(line.removeprefix("///").strip() for line in found[1].splitlines())
    return re.split(r"(?<=[.:]) ", comment, maxsplit=1)[0]


def headers_page() -> str:
    """Every public header by its folder, with what its first comment says."""
    parts = ["# Headers\n\nThe public headers, each with the first sentence of its first comment.\n"]
    for folder in sorted(path for path in HEADERS.iterdir() if path.is_dir()):
        rows = [
            row(
                f"`sextant/{header.relative_to(HEADERS).as_posix()}`",
                first_sentence(header.read_text(encoding="utf-8")),
            )
            for header in sorted(folder.rglob("*.hpp"))
        ]
        parts += [f"## {folder.name}\n", table(("header", "what it has"), rows)]
    return "\n".join(parts)


PAGES = {
    "reference/can.md": can_page,
    "reference/telemetry.md": telemetry_page,
    "reference/commands.md": commands_page,
    "reference/headers.md": headers_page,
}
