"""The shell scripts: what they say of themselves, and that set-up is quick when there is nothing to do."""

import os
import shutil
import subprocess
import time
from pathlib import Path

import pytest
from sextant_py.paths import ROOT

SCRIPTS = ROOT / "scripts"
SHELL_SCRIPTS = [
    "setup",
    "with_vcan",
    "demo",
    "test",
    "bench",
    "nightly",
    "check_demo",
    "check_format",
    "check_package",
]
PYTHON_PROGRAMS = ["vcu", "monitor", "record", "plot", "sweep"]


def run(*command: str | Path, **options: object) -> subprocess.CompletedProcess:
    return subprocess.run(command, capture_output=True, text=True, timeout=120, **options)


@pytest.mark.parametrize("name", SHELL_SCRIPTS + PYTHON_PROGRAMS)
def test_help_from_any_directory(name: str, tmp_path: Path) -> None:
    found = run(SCRIPTS / name, "--help", cwd=tmp_path)
    assert found.returncode == 0, found.stderr
    assert name in found.stdout.splitlines()[0]
    assert found.stderr == ""


@pytest.mark.parametrize("name", ["setup", "demo", "bench", "nightly", "check_demo", "check_format", "check_package"])
def test_unknown_arguments_are_refused(name: str) -> None:
    found = run(SCRIPTS / name, "--frobnicate")
    assert found.returncode == 1
    assert found.stderr == f'{name}: unknown argument "--frobnicate"; see {name} --help.\n'


def test_setup_is_quiet_and_quick_when_nothing_is_missing(tmp_path: Path) -> None:
    began = time.monotonic()
    found = run(SCRIPTS / "setup", cwd=tmp_path, stdin=subprocess.DEVNULL)
    assert (found.returncode, found.stdout, found.stderr) == (0, "", "")
    assert time.monotonic() - began < 10


def test_monitor_from_a_directory_that_cyclone_would_split(tmp_path: Path) -> None:
    """Spaces and commas in the path of the tree: DDS starts, with the tree's own configuration."""
    tree = tmp_path / "space, comma & 100 %"
    shutil.copytree(SCRIPTS, tree / "scripts", ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copytree(ROOT / "configs", tree / "configs")
    (tree / ".venv").symlink_to(ROOT / ".venv")
    environment = {key: value for key, value in os.environ.items() if key != "CYCLONEDDS_URI"}
    found = run(tree / "scripts" / "monitor", "--once", "--duration", "0.5", "--domain", "211", env=environment)
    assert found.returncode == 1
    assert found.stderr.startswith("monitor: no other DDS participant was discovered (domain 211, configs/"), (
        found.stderr
    )


def test_format_gate_fails_where_git_lists_nothing(elsewhere: Path) -> None:
    environment = {**os.environ, "CLANG_FORMAT": str(ROOT / ".venv" / "bin" / "clang-format")}
    found = run(elsewhere / "scripts" / "check_format", env=environment)
    assert found.returncode == 1
    assert "check_format: no C++ file was found" in found.stderr


@pytest.fixture
def elsewhere(tmp_path: Path) -> Path:
    """A copy of the scripts whose machine lacks one package."""
    shutil.copytree(SCRIPTS, tmp_path / "scripts", ignore=shutil.ignore_patterns("__pycache__"))
    (tmp_path / "scripts" / "packages.txt").write_text("bash\nno-such-package-here # comment\n")
    return tmp_path


def test_setup_without_apt_says_so(elsewhere: Path) -> None:
    programs = elsewhere / "bin"
    programs.mkdir()
    for name in ("bash", "dirname", "basename", "mkdir", "flock", "sed", "id", "cat"):
        (programs / name).symlink_to(shutil.which(name))
    found = run(elsewhere / "scripts" / "setup", env={"PATH": str(programs)})
    assert found.returncode == 1
    assert found.stderr.startswith("setup: this is not a Debian-like system (no apt-get)")
    assert found.stderr.count("\n") == 1


def test_setup_without_rights_names_what_is_missing(elsewhere: Path) -> None:
    programs = elsewhere / "bin"
    programs.mkdir()
    (programs / "id").write_text("#!/bin/sh\necho 1000\n")
    (programs / "sudo").write_text("#!/bin/sh\nexit 1\n")
    for program in programs.iterdir():
        program.chmod(0o755)
    path = f"{programs}:{os.environ['PATH']}"
    found = run(elsewhere / "scripts" / "setup", env={**os.environ, "PATH": path}, stdin=subprocess.DEVNULL)
    assert found.returncode == 1
    expected = "setup: these packages are missing and installing them needs root or sudo: no-such-package-here.\n"
    assert found.stderr == expected


@pytest.mark.parametrize("name", PYTHON_PROGRAMS)
def test_programs_before_setup_name_it(name: str, elsewhere: Path) -> None:
    found = run(elsewhere / "scripts" / name)
    assert found.returncode == 1
    assert found.stderr == f"{name}: the Python packages are not installed yet; scripts/setup does it.\n"
