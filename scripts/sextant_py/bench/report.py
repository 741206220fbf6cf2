"""The figures as text for a terminal and as tables of docs/performance.md."""

import re
from pathlib import Path

from sextant_py.errors import UserError

from .figure import MISSED, NOT_JUDGED, PUBLISHED, Figure
from .results import Results, StageResult

Stages = list[tuple[str, StageResult]]


def terminal(stages: Stages) -> str:
    lines = []
    for name, stage in stages:
        lines += ["", f"{name}: {stage.title}"]
        for figure in stage.figures:
            note = f"  ({figure.note})" if figure.note else ""
            verdict = "" if figure.verdict == PUBLISHED else figure.verdict
            verdict += f", {figure.acceptance}" if figure.acceptance else ""
            lines.append(f"  {figure.measure:<86} {figure.shown:>12} {figure.target:>10}  {verdict}{note}")
    return "\n".join(lines[1:])


def row(*cells: str) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def measure(figure: Figure) -> str:
    return f"{figure.measure} ({figure.note})" if figure.note else figure.measure


def command(figure: Figure, stage: str) -> str:
    return f"`{figure.command or f'scripts/bench --only {stage}'}`"


def judged_table(stages: Stages) -> str:
    rows = [row("measure", "target", "figure", "verdict", "command"), row("---", "---:", "---:", "---", "---")]
    for name, stage in stages:
        for f in stage.figures:
            if f.verdict != PUBLISHED:
                verdict = f.verdict if f.verdict == "ok" else f"**{f.verdict}**"
                verdict += f", {f.acceptance.replace(' x', ' ×')}" if f.acceptance else ""
                rows.append(
                    row(
                        measure(f), f.target.replace(" x", " ×"), f.shown.replace(" x", " ×"), verdict, command(f, name)
                    )
                )
    return "\n".join(rows)


def published_table(stages: Stages) -> str:
    rows = [row("measure", "figure", "command"), row("---", "---:", "---")]
    for name, stage in stages:
        for f in stage.figures:
            if f.verdict == PUBLISHED:
                rows.append(row(measure(f), f.shown.replace(" x", " ×"), command(f, name)))
    return "\n".join(rows)


def put(page: str, name: str, text: str) -> str:
    """The page with the text between `<!-- NAME -->` and `<!-- end of NAME -->`."""
    marks = re.compile(rf"(<!-- {re.escape(name)} -->\n).*?(<!-- end of {re.escape(name)} -->)", re.DOTALL)
    if len(marks.findall(page)) != 1:
        raise UserError(f"the page has no pair of marks <!-- {name} --> and <!-- end of {name} -->, or several.")
    return marks.sub(lambda found: f"{found[1]}{text}\n{found[2]}", page)


def write_page(file: Path, stages: Stages) -> None:
    page = file.read_text(encoding="utf-8")
    page = put(page, "judged figures", judged_table(stages))
    page = put(page, "published figures", published_table(stages))
    file.write_text(page, encoding="utf-8")


def verdicts(results: Results, names: list[str]) -> tuple[list[str], list[str], list[str]]:
    """What of these stages missed its target, what missed it no further than is accepted, and what could not be
    judged."""
    figures = [figure for name in names for figure in results.stages[name].figures]
    missed = [figure for figure in figures if figure.verdict == MISSED]
    return (
        [f"{f.measure}: {f.note}" if f.broken else f.measure for f in missed if not f.is_accepted_miss],
        [f"{f.measure}: {f.shown}, {f.acceptance}" for f in missed if f.is_accepted_miss],
        [f"{figure.measure}: {figure.note}" for figure in figures if figure.verdict == NOT_JUDGED],
    )
