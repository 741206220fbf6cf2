"""Where sextant-mil is."""

import os
import shutil
from pathlib import Path

from .errors import UserError
from .paths import ROOT

DEFAULT = ROOT / "build" / "release" / "apps" / "sextant-mil"


def find(wanted: Path | None) -> Path:
    """The program, by its full path: the one wanted, that of the checkout, or that of the PATH.

    SEXTANT_BIN names the directory of the programs; it goes before checkout and PATH.
    """
    if not wanted and (directory := os.environ.get("SEXTANT_BIN")):
        program = Path(directory) / "sextant-mil"
        if not program.is_file():
            raise UserError(f"SEXTANT_BIN names {directory}, where no sextant-mil is; build it or unset SEXTANT_BIN.")
        return program.resolve()
    for program in (wanted,) if wanted else (DEFAULT, shutil.which("sextant-mil")):
        if program and Path(program).is_file() and os.access(program, os.X_OK):
            return Path(program).resolve()
    if wanted:
        raise UserError(f"--mil: {wanted} is not a program.")
    raise UserError(
        "build/release/apps/sextant-mil is not built yet: cmake --preset release && "
        "cmake --build --preset release --target sextant-mil does it; SEXTANT_BIN names another directory."
    )
