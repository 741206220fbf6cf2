"""The one edge of all commands: an error of the system or of an encoding is a sentence and a status, no traceback."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from sextant_py.paths import ROOT

SCRIPTS = ROOT / "scripts"


def program(main: str, **options: object) -> subprocess.CompletedProcess:
    """A command whose main has this body."""
    code = "import sys\nfrom sextant_py.errors import run\n"
    code += f"def main(arguments):\n    {main}\n    return 0\nrun('tool', main)\n"
    environment = {**os.environ, "PYTHONPATH": str(SCRIPTS), **options.pop("env", {})}
    environment.pop("PYTHONUNBUFFERED", None)  # it would write without a buffer that can fail later
    places = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **options}
    return subprocess.run([sys.executable, "-c", code], env=environment, text=True, timeout=120, check=False, **places)


def one_sentence(found: subprocess.CompletedProcess, status: int = 1) -> str:
    assert found.returncode == status, found
    lines = found.stderr.splitlines()
    assert len(lines) == 1, found.stderr
    assert lines[0].startswith("tool: ")
    return lines[0]


@pytest.mark.parametrize("encoding", ["ascii", "iso-8859-1", "cp1252"])
def test_output_that_an_encoding_lacks_is_replaced(encoding: str) -> None:
    found = program(
        "print('10 N·m ─ 日'); print('Ω', file=sys.stderr)", env={"PYTHONIOENCODING": encoding}, encoding=encoding
    )
    assert found.returncode == 0
    assert "?" in found.stdout
    assert "N" in found.stdout


@pytest.mark.parametrize("main", ["print('short')", "print('long ' * 100_000)", "sys.exit(print('help'))"])
def test_full_standard_output_is_told(main: str) -> None:
    with Path("/dev/full").open("w") as full:
        assert "No space left on device" in one_sentence(program(main, stdout=full))


def test_closed_standard_output_ends_without_a_word() -> None:
    found = program("print('anything')", preexec_fn=lambda: os.close(1), stdout=None)
    assert (found.returncode, found.stderr) == (0, "")


@pytest.mark.parametrize("main", ["print('long ' * 100_000)", "print('short')"])
def test_a_reader_that_has_gone_ends_a_command_without_a_word(main: str) -> None:
    reading, writing = os.pipe()
    os.close(reading)
    found = program(main, stdout=writing)
    os.close(writing)
    assert (found.returncode, found.stderr) == (1, "")


@pytest.mark.parametrize(
    ("main", "reason"),
    [
        ("open('/no/such/file')", "/no/such/file: No such file or directory"),
        ("open('/')", "/: Is a directory"),
        ("kept = [open('/dev/null') for _ in range(10**7)]", "Too many open files"),
        ("open(b'/tmp/\\xff\\xfe')", "No such file or directory"),
        ("b'\\xe9'.decode('utf-8')", "not in the encoding that is expected"),
    ],
)
def test_an_error_of_the_system_is_a_sentence(main: str, reason: str) -> None:
    def few_descriptors() -> None:
        import resource

        resource.setrlimit(resource.RLIMIT_NOFILE, (64, 64))

    status = 1 if reason == "Too many open files" else 2
    assert reason in one_sentence(program(main, preexec_fn=few_descriptors), status)


def test_an_error_of_the_program_keeps_its_traceback() -> None:
    found = program("raise ValueError('a bug')")
    assert found.returncode == 1
    assert "Traceback" in found.stderr


def test_the_command_of_the_package_tells_its_version() -> None:
    found = subprocess.run(
        [sys.executable, "-m", "sextant_py", "--version"], capture_output=True, text=True, timeout=120,
        env={**os.environ, "PYTHONPATH": str(SCRIPTS)},
    )  # fmt: skip
    assert found.returncode == 0, found.stderr
    assert re.fullmatch(r"\d+\.\d+\.\d+\n", found.stdout)
