"""The virtual environment of the peers: the newest versions that a Python of this machine can have."""

import hashlib
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

from sextant_py.errors import UserError
from sextant_py.paths import ROOT

REQUIREMENTS = ROOT / "scripts" / "requirements-peers.txt"
VENV = ROOT / ".cache" / "peers-venv"
LOG = ROOT / ".cache" / "peers.log"
NEWEST_NEEDS = (3, 12)  # the newest motulator; requirements-peers.txt has an older one for an older Python
PROBE = "import sys, ensurepip, venv; print(*sys.version_info[:2])"


def folders() -> list[Path]:
    """Where interpreters are: PATH, and what pyenv has installed, whose shims run only versions that it selects."""
    pyenv = Path(os.environ.get("PYENV_ROOT") or Path.home() / ".pyenv")
    path = os.environ.get("PATH", "").split(os.pathsep)
    return [*(Path(folder) for folder in path if folder), *sorted(pyenv.glob("versions/*/bin"))]


def minor_of(program: Path) -> int:
    """Of python3.N; 0 for any other name."""
    found = re.fullmatch(r"python3\.(\d+)", program.name)
    return int(found[1]) if found else 0


def runs(program: str | Path, needed: tuple[int, int]) -> bool:
    """Whether it is a Python of that version or a newer one, which can make a virtual environment."""
    try:
        done = subprocess.run([program, "-c", PROBE], capture_output=True, text=True, timeout=60)
    except (OSError, subprocess.TimeoutExpired):
        return False
    return done.returncode == 0 and tuple(map(int, done.stdout.split())) >= needed


def interpreter(needed: tuple[int, int] = NEWEST_NEEDS) -> str:
    """A Python of that version or a newer one where there is one, the oldest of them first; else the present one."""
    if sys.version_info[:2] >= needed:
        return sys.executable
    named = [program for folder in folders() for program in folder.glob("python3.*") if minor_of(program) >= needed[1]]
    for program in sorted(named, key=minor_of):
        if runs(program, needed):
            return str(program)
    return sys.executable


def install(venv: Path = VENV, requirements: Path = REQUIREMENTS) -> Path:
    """The Python of the virtual environment, made where it is missing or out of date."""
    base, python, stamp = interpreter(), venv / "bin" / "python", venv / ".fingerprint"
    # Programs of a virtual environment name their interpreter by full path.
    fingerprint = hashlib.sha256(f"{requirements.read_text()}{base}{sys.version}{venv}".encode()).hexdigest()
    if stamp.exists() and stamp.read_text() == fingerprint and python.exists():
        return python
    shutil.rmtree(venv, ignore_errors=True)
    LOG.parent.mkdir(parents=True, exist_ok=True)
    with LOG.open("w", encoding="utf-8") as log:
        for command in (
            [base, "-m", "venv", str(venv)],
            # Not what the two list for their own tests.
            [str(python), "-m", "pip", "install", "--no-deps", "--quiet", "--no-input", "-r", str(requirements)],
        ):
            if subprocess.run(command, stdout=log, stderr=log, stdin=subprocess.DEVNULL).returncode != 0:
                raise UserError(f"the peers cannot be installed from {requirements.name}; .cache/peers.log tells why")
    stamp.write_text(fingerprint)
    return python
