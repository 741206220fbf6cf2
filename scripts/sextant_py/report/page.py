"""The page: one HTML file that needs no network and no script."""

from datetime import UTC, datetime
from pathlib import Path

import jinja2

from ..errors import UserError
from .model import BAD, GOOD, Run

HERE = Path(__file__).parent
WORDS = {GOOD: "holds", BAD: "does not hold"}


def filled(template: str, **values: object) -> str:
    """A template of this folder with the style of all pages."""
    loader = jinja2.FileSystemLoader(HERE)
    environment = jinja2.Environment(loader=loader, autoescape=True, trim_blocks=True, lstrip_blocks=True)
    style = (HERE / "page.css").read_text(encoding="utf-8")
    return environment.get_template(template).render(style=style, **values)


def render(runs: list[Run], title: str, now: datetime | None = None) -> str:
    counts = {result: sum(run.result == result for run in runs) for result in (GOOD, BAD)}
    written = (now or datetime.now(UTC)).strftime("%Y-%m-%d %H:%M UTC")
    return filled("page.html", runs=runs, title=title, written=written, counts=counts, words=WORDS)


def write(runs: list[Run], title: str, output: Path) -> None:
    text = render(runs, title)
    try:
        output.parent.mkdir(parents=True, exist_ok=True)
        output.write_text(text, encoding="utf-8")
    except OSError as error:
        raise UserError(f"the report {output} cannot be written: {error.strerror}.") from None
