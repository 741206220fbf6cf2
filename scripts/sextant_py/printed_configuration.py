"""The configuration in force, as sextant-mil and the other programs print it: the one way to ask for it."""

import subprocess
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from .errors import UserError, reason_of
from .sweep_point import clean_reason

ECU = "sextant-ecu"
OPTION = "--print-config"
SECONDS = 60  # for the program to print


def ask(
    program: Path, file: Path, words: Sequence[str] = (), folder: Path | None = None
) -> subprocess.CompletedProcess:
    """What the program says of a file with these options, in a folder. UserError: it cannot be run."""
    command = [str(program), str(file), *words, OPTION]
    options = {"capture_output": True, "encoding": "utf-8", "errors": "replace", "stdin": subprocess.DEVNULL}
    try:
        return subprocess.run(command, cwd=folder, timeout=SECONDS, **options)
    except subprocess.TimeoutExpired:
        raise UserError(f"{program} has not printed its configuration within {SECONDS} s.") from None
    except OSError as error:
        raise UserError(f"{program} cannot be run: {reason_of(error)}.") from None


def text_of(program: Path, file: Path, words: Sequence[str] = (), what: str = "the scenario") -> str:
    """What it prints. UserError with the program's reason where it refuses `what`."""
    done = ask(program, file, words)
    if done.returncode:
        reason = clean_reason(done.stderr, program.name).rstrip(".") or f"its exit status is {done.returncode}"
        raise UserError(f"{program.name} refuses {what}: {reason}.")
    return done.stdout


def tables_of(program: Path, file: Path, words: Sequence[str] = (), what: str = "the scenario") -> dict[str, Any]:
    """Its tables, as text_of."""
    return tomllib.loads(text_of(program, file, words, what))
