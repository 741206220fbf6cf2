"""The page: one HTML file that needs no network and no script."""

from datetime import UTC, datetime
from pathlib import Path

import jinja2

from ..errors import UserError
from .model import BAD, GOOD, Run

HERE = Path(__file__).parent
WORDS = {GOOD: "holds", BAD: "does not hold"}


def render(runs: list[Run], title: str, now: datetime | None = None) -> str:
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(HERE), autoescape=True, trim_blocks=True, lstrip_blocks=True
    )
    counts = {result: sum(run.result == result for run in runs) for result in (GOOD, BAD)}
    style = (HERE / "page.css").read_text(encoding="utf-8")
    written = (now or datetime.now(UTC)).strftime("%Y-%m-%d %H:%M UTC")
    page = environment.get_template("page.html")
    return page.render(runs=runs, title=title, style=style, written=written, counts=counts, words=WORDS)


def write(runs: list[Run], title: str, output: Path) -> None:
    text = render(runs, title)
    try:
        output.parent.mkdir(parents=True, exist_ok=True)
        output.write_text(text, encoding="utf-8")
    except OSError as error:
        raise UserError(f"the report {output} cannot be written: {error.strerror}.") from None
