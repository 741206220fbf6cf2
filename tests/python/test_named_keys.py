"""Every key of the configuration that a sentence of a program or a page names is one."""

import ast
import re
import subprocess
from collections.abc import Iterator
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
COMPLETE = r"(?!_)(?![\w(/.-]*[(/])"  # neither a part of a name nor a path or a call
SUFFIXES = (".toml", ".py", ".png", ".h5", ".csv", ".json", ".log", ".md", ".xml", ".idl", ".dbc", ".html", ".mcap")


def run(name: str, file: Path, *words: str) -> subprocess.CompletedProcess:
    return subprocess.run(
        [program(name), file, *words, "--print-config"], capture_output=True, text=True, timeout=60, cwd=ROOT
    )


def tables() -> set[str]:
    printed = "".join(run(*file).stdout for file in FILES)
    return {heading[1] for heading in re.finditer(r"^\[+(\w+)", printed, re.MULTILINE)}


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
    key = re.compile(rf"(?<![\w./-])((?:{'|'.join(sorted(tables()))})(?:\.[a-z][a-z0-9_]*)+){COMPLETE}")
    return {
        found: path for path, text in texts() for found in key.findall(text) if not found.endswith((*SUFFIXES, "_"))
    }


def is_key(name: str) -> bool:
    return any("unknown key" not in run(*file, "--set", f"{name}=nonsense").stderr for file in FILES)


def test_every_key_that_is_named_is_known() -> None:
    named = named_keys()
    assert len(named) > 100
    unknown = {name: str(path.relative_to(ROOT)) for name, path in named.items() if not is_key(name)}
    assert unknown == {}


@pytest.mark.parametrize(("name", "is_known"), [("protection.over_current_a", True), ("telemetry.drive_id", False)])
def test_a_key_is_told_from_another_name(name: str, is_known: bool) -> None:
    assert is_key(name) == is_known
