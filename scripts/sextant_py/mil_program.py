"""Where sextant-mil and the other programs are, and their build for the commands that see to it themselves."""

import os
import shutil
import subprocess
from functools import cache
from pathlib import Path

from .errors import UserError
from .paths import IS_CHECKOUT, ROOT

NAME = "sextant-mil"
BUILT = ROOT / "build" / "release" / "apps"
BUILD = "SEXTANT_BUILD"  # in the environment of a command that builds what it needs of the release
BESIDE = {"sextant-ecu": ("sextant-telemetry",)}  # programs that another one starts


@cache
def build(target: str, *flags: str) -> None:
    """Builds a target of the release, and the programs that it starts, where the command is one that does so."""
    if BUILD not in os.environ:
        return
    targets = (target, *BESIDE.get(target, ()))
    jobs = str(os.cpu_count())
    for words in (
        ["--preset", "release", *flags],
        ["--build", "--preset", "release", "-j", jobs, "--target", *targets],
    ):
        try:
            done = subprocess.run(["cmake", *words], cwd=ROOT, stdout=subprocess.DEVNULL, check=False)
        except FileNotFoundError:
            raise UserError("cmake is missing; scripts/setup installs it.") from None
        if done.returncode:
            raise UserError(f"{target} cannot be built; cmake --preset release tells why.")


def find(wanted: Path | None, name: str = NAME) -> Path:
    """The program, by its full path: the one wanted, that of the checkout, or that of the PATH.

    SEXTANT_BIN names the directory of the programs; it goes before checkout and PATH.
    """
    if not wanted and (directory := os.environ.get("SEXTANT_BIN")):
        program = Path(directory) / name
        if not program.is_file():
            raise UserError(f"SEXTANT_BIN names {directory}, where no {name} is; build it or unset SEXTANT_BIN.")
        return program.resolve()
    if not wanted:
        build(name)
    for program in (wanted,) if wanted else (BUILT / name, shutil.which(name)):
        if program and Path(program).is_file() and os.access(program, os.X_OK):
            return Path(program).resolve()
    if wanted:
        raise UserError(f"--{name.removeprefix('sextant-')}: {wanted} is not a program.")
    if not IS_CHECKOUT:
        raise UserError(f"there is no {name} in the PATH: install Sextant's programs, or name theirs in SEXTANT_BIN.")
    raise UserError(
        f"build/release/apps/{name} is not built yet: cmake --preset release && "
        f"cmake --build --preset release --target {name} does it; SEXTANT_BIN names another directory."
    )
