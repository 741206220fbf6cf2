"""Result files in JSON with a record or an array a line, so that two of them can be compared line by line."""

import json
from pathlib import Path
from typing import Any

from sextant_py.errors import UserError


def text(value: Any, levels: int = 2) -> str:
    """The members of the outer `levels` levels have lines of their own. What lies deeper is one line, and so is an
    object or array that holds no other. Keys are words or numbers."""
    return _text(value, levels) + "\n"


def _text(value: Any, levels: int) -> str:
    members = value.values() if isinstance(value, dict) else value if isinstance(value, list | tuple) else ()
    if levels == 0 or not any(isinstance(member, dict | list | tuple) for member in members):
        return json.dumps(value, ensure_ascii=False)
    lines = [_text(member, levels - 1) for member in members]
    if isinstance(value, dict):
        lines = [f"{json.dumps(str(key), ensure_ascii=False)}: {line}" for key, line in zip(value, lines, strict=True)]
    begin, end = "{}" if isinstance(value, dict) else "[]"
    return begin + "\n" + ",\n".join(lines) + "\n" + end


def write(file: Path, value: Any, levels: int = 2) -> None:
    """With its directory. UserError: it cannot be written."""
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text(value, levels), encoding="utf-8")
    except OSError as error:
        raise UserError(f"{file} cannot be written: {error.strerror}.") from None
