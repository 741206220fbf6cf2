"""Every command of scripts/ at the edges of its system: files, directories, encodings and outputs that are not usual.

The commands are those behind scripts/, and their arguments are read from their parsers, so that a new one is covered. A
command runs in a child of this process, which has loaded it: processes of their own would take minutes.
"""

import argparse
import importlib
import os
import re
import runpy
import signal
import sys
import tempfile
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import pytest
from programs import modules_called
from sextant_py.paths import ROOT

SCRIPTS = ROOT / "scripts"
FAILED, REFUSED = 1, 2
LIMIT_S = 6  # of a command that has to refuse
ABSENT = ("is not built", "/apps/sextant-ecu: No such file")  # programs that a command needs before it reads a file
WORK_S = 1.5  # of one that may go on to its work
NOBODY = 65534
UNWRITABLE = Path("/proc/sextant_edge")  # neither root can make anything here


def commands() -> list[str]:
    """The modules behind the links to scripts/command and behind the scripts that name one."""
    scripts = [script for script in SCRIPTS.iterdir() if script.is_file()]
    named = {script.name for script in scripts if script.is_symlink()}
    texts = [script.read_text(encoding="utf-8", errors="replace") for script in scripts if not script.is_symlink()]
    return sorted(
        named | {one for text in texts for one in re.findall(r"^\(?(?:run|mil)_module (\w+)", text, re.MULTILINE)}
    )


@dataclass
class Ended:
    status: int | None  # none where it was still at work
    out: str
    err: str


def _become(words: list[str], out: int | None, prepare: Callable[[], None], folder: Path) -> None:
    """Runs the command in this process, a child, and ends it as an interpreter does."""
    os.setsid()
    if out is None:
        out = os.open(folder / "out", os.O_WRONLY | os.O_CREAT)
    os.dup2(out, 1)
    os.dup2(os.open(folder / "err", os.O_WRONLY | os.O_CREAT), 2)
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    sys.stdout = open(1, "w", encoding="utf-8", closefd=False)  # noqa: SIM115 it ends with the process
    sys.stderr = open(2, "w", encoding="utf-8", closefd=False, buffering=1)  # noqa: SIM115
    sys.argv = words
    os.chdir(folder)
    prepare()
    status = 0
    sys.modules.pop(load(words[0]).__name__)  # it begins anew, as the program
    try:
        runpy.run_module(modules_called(words[0])[0], run_name="__main__", alter_sys=True)
    except SystemExit as end:
        status = end.code if isinstance(end.code, int) else int(end.code is not None)
    except BaseException:
        traceback.print_exc()
        status = 1
    try:
        sys.stdout.flush()
    except (OSError, ValueError):
        status = 120
    os._exit(status)


def run(
    words: list[object], folder: Path, out: int | None = None, limit_s: float = LIMIT_S,
    prepare: Callable[[], None] = lambda: None,
) -> Ended:  # fmt: skip
    """The command in a child; it is ended after limit_s."""
    load(str(words[0]))
    for name in ("out", "err"):
        (folder / name).unlink(missing_ok=True)
    child = os.fork()
    if child == 0:
        try:
            _become([str(word) for word in words], out, prepare, folder)
        finally:
            os._exit(121)
    end_s = time.monotonic() + limit_s
    found = (0, 0)
    while found[0] == 0 and time.monotonic() < end_s:
        found = os.waitpid(child, os.WNOHANG)
        time.sleep(0.002)
    if found[0] == 0:
        os.killpg(child, signal.SIGKILL)
        os.waitpid(child, 0)
    said = [(folder / name).read_text(encoding="utf-8") if (folder / name).exists() else "" for name in ("out", "err")]
    return Ended(os.waitstatus_to_exitcode(found[1]) if found[0] else None, *said)


def load(name: str) -> object:
    """The module with the command's main, also of a folder."""
    module = importlib.import_module(modules_called(name)[0])
    return importlib.import_module(f"{module.__name__}.__main__") if hasattr(module, "__path__") else module


class _ParserFound(BaseException):
    pass


@cache
def parser_of(name: str) -> argparse.ArgumentParser:
    def take(self: argparse.ArgumentParser, *_: object, **__: object) -> None:
        raise _ParserFound(self)

    with pytest.MonkeyPatch.context() as patch:
        for method in ("parse_args", "parse_known_args", "parse_intermixed_args", "parse_known_intermixed_args"):
            patch.setattr(argparse.ArgumentParser, method, take)
        with pytest.raises(_ParserFound) as found:
            load(name).main([])
    return found.value.args[0]


def is_path(action: argparse.Action) -> bool:
    return action.type is Path or action.dest in ("words", "runs", "profile")


def is_output(action: argparse.Action) -> bool:
    """What names a result is called so, or says so in its help."""
    return action.dest in ("junit", "log", "out", "output", "page") or "to write" in (action.help or "")


def is_needed(action: argparse.Action) -> bool:
    return action.required and action.nargs != "*"


def filled(action: argparse.Action, path: Path) -> list[str]:
    """The words of an argument, with the path where it takes one."""
    word = str(path) if is_path(action) else str(next(iter(action.choices))) if action.choices else "a=1"
    return [*action.option_strings[-1:], word]


def line(name: str, tried: argparse.Action, path: Path) -> list[str]:
    """The command with the path as one argument, and as others that it cannot do without."""
    needed = [one for one in parser_of(name)._actions if one is tried or is_needed(one)]
    return [name, *(word for one in needed for word in filled(one, path))]


def arguments(are_outputs: bool) -> list[tuple[str, str]]:
    found = []
    for name in commands():
        paths = [one for one in parser_of(name)._actions if is_path(one)]
        found += [(name, one.dest) for one in paths if is_output(one) == are_outputs]
    return found


def argument(name: str, dest: str) -> argparse.Action:
    return next(one for one in parser_of(name)._actions if one.dest == dest)


def check_sentence(found: Ended, name: str, *words: str) -> None:
    """One sentence with one of the words. argparse precedes its own with the usage."""
    name = parser_of(name).prog
    assert "Traceback" not in found.err, found.err
    assert found.status is not None, "it does not end"
    text = found.err[found.err.find(f"\n{name}: ") + 1 :] if found.err.startswith("usage: ") else found.err
    assert text.count("\n") == 1, found.err
    assert text.startswith(f"{name}: "), found.err
    assert not words or any(word in text for word in words), found.err


# ---- files that are read


def _missing(folder: Path) -> Path:
    return folder / "none" / "at_all.h5"


def _directory(folder: Path) -> Path:
    path = folder / "folder.toml"
    path.mkdir()
    return path


def _latin(folder: Path) -> Path:
    path = folder / "latin.toml"
    path.write_bytes('description = "Größe"\n'.encode("latin-1"))
    return path


def _latin_table(folder: Path) -> Path:
    path = folder / "latin.csv"
    path.write_bytes("t_ns,Größe\n0,1\n1,2\n".encode("latin-1"))
    return path


def _foreign(suffix: str) -> Callable[[Path], Path]:
    def make(folder: Path) -> Path:
        path = folder / f"foreign{suffix}"
        path.write_bytes(bytes(range(256)) * 40)
        return path

    return make


FILES = {
    "missing": _missing,
    "directory": _directory,
    "latin": _latin,
    "latin table": _latin_table,
    **{f"foreign {suffix}": _foreign(suffix) for suffix in (".h5", ".csv", ".toml", ".json")},
}


@pytest.mark.parametrize("name", commands())
def test_a_command_has_its_arguments(name: str) -> None:
    assert parser_of(name).prog


@pytest.mark.parametrize("kind", FILES)
@pytest.mark.parametrize(("name", "dest"), arguments(are_outputs=False))
def test_a_file_that_cannot_be_used(name: str, dest: str, kind: str, tmp_path: Path) -> None:
    path = FILES[kind](tmp_path)
    before = path.read_bytes() if path.is_file() else b""
    action = argument(name, dest)
    found = run(line(name, action, path), tmp_path)
    option = action.option_strings[-1] if action.option_strings else path.name  # it may lack another one
    check_sentence(found, name, path.name, option, *ABSENT)
    assert found.status == REFUSED, found
    assert before == (path.read_bytes() if path.is_file() else b"")


@pytest.mark.skipif(os.geteuid() != 0, reason="NOT TESTED: needs another user")
@pytest.mark.parametrize(("name", "dest"), arguments(are_outputs=False))
def test_a_file_without_permission(name: str, dest: str, tmp_path: Path) -> None:
    path = _foreign(".h5")(tmp_path)
    path.chmod(0o700)
    tmp_path.chmod(0o711)
    action = argument(name, dest)
    option = action.option_strings[-1] if action.option_strings else path.name
    found = run(line(name, action, path), tmp_path, prepare=lambda: os.setresuid(NOBODY, NOBODY, NOBODY))
    check_sentence(found, name, path.name, option, *ABSENT)
    assert found.status == REFUSED, found


# ---- what is written

TABLE = "t_ns,torque_nm\n0,1\n1000000,2\n2000000,3\n3000000,1\n"


def table(folder: Path) -> Path:
    path = folder / "run.csv"
    path.write_text(TABLE, encoding="utf-8")
    return path


@pytest.mark.parametrize(("name", "dest"), arguments(are_outputs=True))
def test_a_place_that_cannot_be_written(name: str, dest: str, tmp_path: Path) -> None:
    action = argument(name, dest)
    needed = [one for one in parser_of(name)._actions if is_needed(one) and one is not action]
    words = [word for one in needed for word in filled(one, table(tmp_path))]
    found = run([name, *words, *filled(action, UNWRITABLE / "out.html")], tmp_path, limit_s=WORK_S)
    assert "Traceback" not in found.err, found.err
    assert found.status in (None, REFUSED), found  # a measurement is at work until then
    assert (tmp_path / "run.csv").exists() == bool(needed)


SPOKEN = {  # commands that can do their work on a table alone
    "compare": lambda folder: ["--align", "rise torque_nm 1.5", table(folder), table(folder)],
    "plot": lambda folder: [table(folder), "-o", folder / "new.png"],
    "report": lambda folder: [table(folder), "--out", folder / "new.html"],
    "rt_check": lambda _: [],
    "completion": lambda _: ["bash"],
    "sweep": lambda _: [ROOT / "configs" / "sweeps" / "hysteresis_band.toml", "--dry-run"],
}


@pytest.mark.parametrize("name", commands())
def test_a_full_standard_output(name: str, tmp_path: Path) -> None:
    with Path("/dev/full").open("w") as full:
        for words in (["--help"], *([SPOKEN[name](tmp_path)] if name in SPOKEN else [])):
            found = run([name, *words], tmp_path, out=full.fileno())
            check_sentence(found, name, "No space left on device")
            assert found.status == FAILED, found


@pytest.mark.parametrize("name", commands())
def test_a_reader_that_has_gone(name: str, tmp_path: Path) -> None:
    for words in (["--help"], *([SPOKEN[name](tmp_path)] if name in SPOKEN else [])):
        reading, writing = os.pipe()
        os.close(reading)
        found = run([name, *words], tmp_path, out=writing)
        os.close(writing)
        assert (found.status, found.err) == (FAILED, ""), found


def _no_temporary_directory() -> None:
    tempfile.tempdir = None
    tempfile._candidate_tempdir_list = lambda: [str(UNWRITABLE)]


@pytest.mark.parametrize("name", SPOKEN)
def test_without_a_temporary_directory(name: str, tmp_path: Path) -> None:
    words = [name, *SPOKEN[name](tmp_path)]
    found = run(words, tmp_path, prepare=_no_temporary_directory)
    if found.status != 0:
        check_sentence(found, name, "temporary directory")
        assert found.status == REFUSED, found
    assert (tmp_path / "run.csv").exists() == ("run.csv" in str(words))
