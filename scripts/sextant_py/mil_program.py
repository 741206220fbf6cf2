"""Where sextant-mil is."""

import os
import shutil
from pathlib import Path

from .errors import UserError
from .paths import ROOT

DEFAULT = ROOT / "build" / "release" / "apps" / "sextant-mil"


def find(wanted: Path | None) -> Path:
    """The program, by its full path: the one wanted, that of the checkout, or that of the PATH."""
    for program in (wanted,) if wanted else (DEFAULT, shutil.which("sextant-mil")):
        if program and Path(program).is_file() and os.access(program, os.X_OK):
            return Path(program).resolve()
    if wanted:
        raise UserError(f"--mil: {wanted} is not a program.")
    raise UserError(
        "build/release/apps/sextant-mil is not built yet: cmake --preset release && "
        "cmake --build --preset release --target sextant-mil does it; --mil PATH names another."
    )
