"""A comparison for people and for programs: table, Markdown, JSON and JUnit."""

import json
from dataclasses import asdict
from itertools import groupby
from pathlib import Path

import junitparser
from rich.console import Console
from rich.table import Table
from rich.text import Text

from . import junit
from .comparison import IGNORED, OUT, Row

HEADINGS = ("metric", "A", "B", "B − A", "share", "tolerance", "result")
PLAIN_WIDTH = 110  # where there is no terminal
STYLES = {OUT: "bold red", IGNORED: "dim"}


def _shown(value: float | str | None) -> str:
    return "-" if value is None else value if isinstance(value, str) else f"{value:.6g}"


def cells(row: Row) -> tuple[str, ...]:
    difference = "" if row.difference is None else f"{row.difference:+.3g}"
    share = "" if row.relative is None else f"{row.relative:+.2%}"
    return row.metric, _shown(row.first), _shown(row.second), difference, share, row.tolerance, row.result


def conclusion(rows: list[Row]) -> str:
    out = [row for row in rows if row.result == OUT]
    compared = sum(row.result != IGNORED for row in rows)
    if not out:
        return f"{compared} values agree within their tolerances"
    return f"{len(out)} of {compared} values are out of tolerance: {', '.join(row.metric for row in out[:6])}" + (
        " …" if len(out) > 6 else ""
    )


def print_table(rows: list[Row]) -> None:
    """A table for each scenario; without colours where there is no terminal or NO_COLOR is set."""
    console = Console(highlight=False)
    if not console.is_terminal:
        console.width = PLAIN_WIDTH
    for scenario, part in groupby(rows, lambda row: row.scenario):
        table = Table(title=Text(scenario), title_justify="left", box=None, pad_edge=False)
        for heading in HEADINGS:
            table.add_column(heading, justify="left" if heading in ("metric", "result") else "right", no_wrap=True)
        for row in part:
            table.add_row(*map(Text, cells(row)), style=STYLES.get(row.result, ""))
        console.print(table)
    console.print(Text(conclusion(rows)))


def markdown(rows: list[Row]) -> str:
    """Tables as GitHub shows them."""
    lines: list[str] = []
    for scenario, part in groupby(rows, lambda row: row.scenario):
        lines += [f"### {scenario}", "", f"| {' | '.join(HEADINGS)} |", "|---|---:|---:|---:|---:|---:|---|"]
        for row in part:
            marked = [f"**{cell}**" if row.result == OUT and cell else cell for cell in cells(row)]
            lines.append(f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in marked)} |")
        lines.append("")
    return "\n".join([*lines, f"{conclusion(rows)}.", ""])


def as_json(rows: list[Row]) -> str:
    listed = [asdict(row) | {"difference": row.difference, "relative": row.relative} for row in rows]
    return json.dumps({"equal": all(row.result != OUT for row in rows), "rows": listed}, indent=2, ensure_ascii=False)


def write_junit(rows: list[Row], file: Path) -> None:
    """A test suite for each scenario, a test case for each metric."""
    xml = junitparser.JUnitXml("compare")
    for scenario, part in groupby(rows, lambda row: row.scenario):
        suite = junitparser.TestSuite(scenario)
        for row in part:
            case = junitparser.TestCase(row.metric, scenario, 0)
            if row.result == OUT:
                case.result = [junitparser.Failure(row.reason, "tolerance")]
            elif row.result == IGNORED:
                case.result = [junitparser.Skipped("not compared")]
            suite.add_testcase(case)
        xml.add_testsuite(suite)
    junit.write(xml, file)
