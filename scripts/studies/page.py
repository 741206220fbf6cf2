"""Tables of Markdown, the pages that templates make, and marked places in the pages of docs."""

import math
import re
from collections.abc import Iterable, Mapping
from pathlib import Path

from sextant_py.errors import UserError

_FIELD = re.compile(r"\{([\w/.]+)(?::([^{}]+))?\}")


def row(*cells: object) -> str:
    return "| " + " | ".join(str(cell).replace("|", "\\|") for cell in cells) + " |"


def table(head: Iterable[str], rows: Iterable[Iterable[object]], left: Iterable[int] = (0,)) -> str:
    """left: the columns of text; the others stand to the right."""
    heads = list(head)
    lines = ["---" if n in left else "---:" for n in range(len(heads))]
    return "\n".join([row(*heads), f"|{'|'.join(lines)}|", *(row(*cells) for cells in rows)])


def counted(count: int, name: str) -> str:
    """So many of what has this name."""
    return f"{count} {name}" if count == 1 else f"{count} {name}s"


def figure(value: float | None, digits: int = 2, scale: float = 1.0) -> str:
    return "–" if value is None else f"{value * scale:.{digits}f}"


def number(value: float, form: str) -> str:
    """`k1` is thousands with one decimal; every other form is Python's. A true minus, a dash for no number."""
    if not math.isfinite(value):
        return "–"
    if form.startswith("k"):
        value, form = value / 1e3, f".{form[1:]}f"
    return f"{value:{form}}".replace("-", "−")


def filled(template: Path, fields: Mapping[str, object]) -> str:
    """The template's text with the fields in the place of their names in braces, `{name}` or a number `{name:form}`."""

    def field(found: re.Match) -> str:
        if found[1] not in fields:
            raise UserError(f"{template} names {found[0]}, which its study does not make.")
        return number(fields[found[1]], found[2]) if found[2] else str(fields[found[1]])

    return _FIELD.sub(field, template.read_text(encoding="utf-8"))


def put(page: str, blocks: Mapping[str, str]) -> str:
    """The page with each text between `<!-- NAME -->` and the next `<!-- end … -->`; on lines of its own where the
    first mark ends a line."""
    for name, text in blocks.items():
        marks = re.compile(rf"(<!-- {re.escape(name)} -->(\n?)).*?(<!-- end[^>]*-->)", re.DOTALL)
        if len(marks.findall(page)) != 1:
            raise UserError(f"the page must have the mark <!-- {name} --> once, and an <!-- end --> behind it.")
        page = marks.sub(lambda found, text=text: f"{found[1]}{text}{found[2]}{found[3]}", page)
    return page


def put_into(file: Path, blocks: Mapping[str, str]) -> Path:
    """Writes the page in the file with these texts at their marks."""
    try:
        file.write_text(put(file.read_text(encoding="utf-8"), blocks), encoding="utf-8")
    except OSError as error:
        raise UserError(f"{file} cannot be written: {error.strerror}.") from None
    return file
