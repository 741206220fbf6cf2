"""The configuration in force of sextant-ecu, by the program itself."""

import subprocess
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from .errors import UserError
from .sweep_point import clean_reason

PROGRAM = "sextant-ecu"


def of(program: Path, file: Path, words: Sequence[str]) -> dict[str, Any]:
    """Its tables. A drive that the program refuses is a UserError with its reason. words: options of the program"""
    done = subprocess.run(
        [program, file, *words, "--print-config"],
        capture_output=True,
        encoding="utf-8",
        errors="replace",
        stdin=subprocess.DEVNULL,
    )
    if done.returncode:
        raise UserError(f"{PROGRAM} refuses the drive: {clean_reason(done.stderr, PROGRAM)}")
    return tomllib.loads(done.stdout)
