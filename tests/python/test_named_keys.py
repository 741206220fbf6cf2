"""Every key of the configuration that a sentence of a program or a page names is one."""

import ast
import re
import subprocess
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest
from programs import program
from sextant_py.paths import ROOT

SCENARIO = ROOT / "configs" / "scenarios" / "constant_torque.toml"
FILES = (
    ("sextant-mil", SCENARIO),
    ("sextant-ecu", ROOT / "configs" / "ecu.toml"),
    ("sextant-ecu", ROOT / "configs" / "ecu_four.toml"),
    ("sextant-plant", ROOT / "configs" / "plant.toml"),
)
OBJECTS = ("vcu",)  # of Python, whose members have names of keys
COMPLETE = r"(?!_)(?![\w(/.-]*[(/])"  # neither a part of a name nor a path or a call
SUFFIXES = (".toml", ".py", ".png", ".h5", ".csv", ".json", ".log", ".md", ".xml", ".idl", ".dbc", ".html", ".mcap")


def run(name: str, file: Path, *words: str) -> subprocess.CompletedProcess:
    return subprocess.run(
        [program(name), file, *words, "--print-config"], capture_output=True, text=True, timeout=60, cwd=ROOT
    )


@cache
def printed_keys() -> frozenset[str]:
    """Every key, dotted."""
    found, table = set(), ""
    for line in "".join(run(*file).stdout for file in FILES).splitlines():
        if heading := re.match(r"\[+([\w.]+)\]+", line):
            table = heading[1]
        elif entry := re.match(r"(?:# )?(\w+) =", line):
            found.add(f"{table}.{entry[1]}" if table else entry[1])
    return frozenset(found)


@cache
def pattern() -> re.Pattern:
    """A dotted name whose first part is a table, or whose last part is a key that no other word is."""
    tables = {key.partition(".")[0] for key in printed_keys() if "." in key}
    keys = {name for key in printed_keys() if "_" in (name := key.rpartition(".")[2])}
    of_table = rf"(?:{'|'.join(sorted(tables))})(?:\.[a-z][a-z0-9_]*)+"
    of_key = rf"(?:[a-z][a-z0-9_]*\.)+(?:{'|'.join(sorted(keys))})"
    return re.compile(rf"(?<![\w./-])({of_table}|{of_key}){COMPLETE}")


def keys_in(text: str) -> list[str]:
    return [
        found
        for found in pattern().findall(text)
        if not found.endswith((*SUFFIXES, "_")) and found.partition(".")[0] not in OBJECTS
    ]


def literals_of_c(path: Path) -> Iterator[str]:
    for line in path.read_text(encoding="utf-8").splitlines():
        if not line.lstrip().startswith(("#include", "//")):
            yield from re.findall(r'"((?:[^"\\]|\\.)*)"', line)


def literals_of_python(path: Path) -> Iterator[str]:
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.value


def code_of_page(path: Path) -> Iterator[str]:
    return iter(re.findall(r"`([^`\n]*)`", path.read_text(encoding="utf-8")))


def texts() -> Iterator[tuple[Path, str]]:
    sources = [
        *((path, literals_of_c) for room in ("apps", "include", "src") for path in (ROOT / room).rglob("*.[ch]pp")),
        *((path, literals_of_python) for path in (ROOT / "scripts").rglob("*.py")),
        *((path, code_of_page) for path in (ROOT / "README.md", *(ROOT / "docs").rglob("*.md"))),
    ]
    for path, read in sources:
        yield from ((path, text) for text in read(path))


def named_keys() -> dict[str, Path]:
    """Each key with a file that names it."""
    return {found: path for path, text in texts() for found in keys_in(text)}


def is_key(name: str) -> bool:
    """Whether it is one, or the end of one: a sentence about a table leaves the table's name out."""
    if any(key == name or key.endswith(f".{name}") for key in printed_keys()):
        return True
    return any("unknown key" not in run(*file, "--set", f"{name}=nonsense").stderr for file in FILES)


def test_every_key_that_is_named_is_known() -> None:
    named = named_keys()
    assert len(named) > 100
    unknown = {name: str(path.relative_to(ROOT)) for name, path in named.items() if not is_key(name)}
    assert unknown == {}


@pytest.mark.parametrize(
    ("name", "is_known"),
    [
        ("protection.over_current_a", True),
        ("saturation.knee_wb", True),
        ("telemetry.drive_id", False),
        ("protections.over_current_a", False),
        ("plnat.saturation.knee_wb", False),
        ("plant.satration.knee_wb", False),
        ("control.foc.bandwith_rad_s", False),
    ],
)
def test_a_key_is_told_from_another_name(name: str, is_known: bool) -> None:
    assert is_key(name) == is_known
    for text in (name, f"raise {name} to 5, or", f'"{name}"', f"{name}=5"):
        assert keys_in(text) == [name]
