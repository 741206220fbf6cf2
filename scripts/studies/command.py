"""What the commands of the studies have in common."""

from pathlib import Path

from sextant_py.errors import UserError
from sextant_py.sweep_file import Settings, toml_value


def words(text: str) -> list[str]:
    """Of an option A,B."""
    return [word for word in text.split(",") if word]


def chosen(option: str, wanted: list[str] | None, known: list[str]) -> list[str]:
    """The names that are wanted, or all. UserError: one of them is not known."""
    for name in wanted or []:
        if name not in known:
            raise UserError(f'{option}: there is no "{name}"; they are {", ".join(known)}.')
    return wanted or known


def made(directory: Path) -> Path:
    """The directory, made where it is missing."""
    try:
        directory.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UserError(f"{directory} cannot be made: {error.strerror}.") from None
    return directory


def write_toml(file: Path, settings: Settings) -> Path:
    """A file of dotted keys. UserError: it cannot be written."""
    try:
        file.write_text("".join(f"{key} = {toml_value(value)}\n" for key, value in settings.items()), encoding="utf-8")
    except OSError as error:
        raise UserError(f"{file} cannot be written: {error.strerror}.") from None
    return file
