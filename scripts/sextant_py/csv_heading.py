"""Lines of a CSV file, and what profiles, recordings and lists of points refuse of its heading."""

import csv
import re

from .errors import UserError

SEPARATORS = {";": "semicolons", "\t": "tabs"}
_BEFORE_COMMENT = re.compile(r'(?:"[^"]*"?|[^"#])*')


def cells_of(line: str) -> list[str]:
    """The cells of a line; none where there is nothing but blanks and a comment."""
    text = _BEFORE_COMMENT.match(line).group().strip()
    return [cell.strip() for cell in next(csv.reader([text], skipinitialspace=True), [])]


def refuse_separators(columns: list[str], where: str) -> None:
    """Refuses a heading of one column that something else than a comma separates."""
    for separator, name in SEPARATORS.items():
        if len(columns) == 1 and separator in columns[0]:
            raise UserError(f"{where}: {name} separate the columns: separate them by commas.")


def refuse_twice(column: str, columns: list[str], where: str) -> None:
    if columns.count(column) > 1:
        raise UserError(f"{where}: the column {column} occurs twice.")
