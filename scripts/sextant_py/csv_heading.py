"""What profiles and recordings refuse of the heading of a CSV file."""

from .errors import UserError

SEPARATORS = {";": "semicolons", "\t": "tabs"}


def refuse_separators(columns: list[str], where: str) -> None:
    """Refuses a heading of one column that something else than a comma separates."""
    for separator, name in SEPARATORS.items():
        if len(columns) == 1 and separator in columns[0]:
            raise UserError(f"{where}: {name} separate the columns: separate them by commas.")


def refuse_twice(column: str, columns: list[str], where: str) -> None:
    if columns.count(column) > 1:
        raise UserError(f"{where}: the column {column} occurs twice.")
