"""Text, lines and cells of a CSV file, and what profiles, recordings and lists of points refuse of its heading."""

import csv
import re
from pathlib import Path

from .errors import UserError

SEPARATORS = {";": "semicolons", "\t": "tabs"}
CONTROL = re.compile(rb"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f]")  # bytes that no text has
_LINE_END = re.compile(rb"\r\n|\n|\r")
_BEFORE_COMMENT = re.compile(r'(?:"[^"]*"?|[^"#])*')


def refuse_control(path: Path, data: bytes, line: int = 1) -> None:
    """Refuses a byte that no text has. line: the number of the first line of the data."""
    if found := CONTROL.search(data):
        number = line + len(_LINE_END.findall(data, 0, found.start()))
        what = f"the byte 0x{found.group()[0]:02x} is no text"
        raise UserError(f"{path}:{number}: {what}; save the file as text in UTF-8, or remove that byte.")


def lines_of(path: Path, what: str) -> list[str]:
    """The lines of a small file, with any line end. what: as sentences call the file."""
    try:
        data = path.read_bytes()
        text = data.decode("utf-8-sig")
    except OSError as error:
        raise UserError(f"{what} {path} cannot be read: {error.strerror}.") from None
    except UnicodeDecodeError:
        raise UserError(f"{what} {path} is not a text file in UTF-8.") from None
    refuse_control(path, data)
    return re.split(_LINE_END.pattern.decode(), text)


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
