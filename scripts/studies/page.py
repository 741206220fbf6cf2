"""Tables of Markdown, and their places in the pages of docs."""

import re
from collections.abc import Iterable, Mapping
from pathlib import Path

from sextant_py.errors import UserError


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


def filled(template: Path, fields: Mapping[str, object]) -> str:
    """The template's text with the fields in the place of their names in braces."""

    def field(found: re.Match) -> str:
        if found[1] not in fields:
            raise UserError(f"{template} names {found[0]}, which its study does not make.")
        return str(fields[found[1]])

    return re.sub(r"\{(\w+)\}", field, template.read_text(encoding="utf-8"))


def put(page: str, name: str, text: str) -> str:
    """The page with the text between `<!-- NAME -->` and the next `<!-- end … -->`; on lines of its own where the first
    mark ends a line."""
    marks = re.compile(rf"(<!-- {re.escape(name)} -->(\n?)).*?(<!-- end[^>]*-->)", re.DOTALL)
    if len(marks.findall(page)) != 1:
        raise UserError(f"the page must have the mark <!-- {name} --> once, and an <!-- end --> behind it.")
    return marks.sub(lambda found: f"{found[1]}{text}{found[2]}{found[3]}", page)
