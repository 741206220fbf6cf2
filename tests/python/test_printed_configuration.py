"""One module asks the programs for their configuration, and says alike what keeps it from an answer."""

import ast
import re
from pathlib import Path

import pytest
from programs import program
from sextant_py import printed_configuration
from sextant_py.errors import UserError
from sextant_py.paths import ROOT

SCENARIO = ROOT / "configs" / "scenarios" / "constant_torque.toml"
ASKING = ROOT / "scripts" / "sextant_py" / "printed_configuration.py"


def test_no_other_module_asks_in_its_own_way() -> None:
    own = {
        str(file.relative_to(ROOT))
        for room in ("sextant", "sextant_py")
        for file in (ROOT / "scripts" / room).rglob("*.py")
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(node, ast.Constant) and node.value == printed_configuration.OPTION and file != ASKING
    }
    assert own == set()


def test_the_tables_are_those_in_force() -> None:
    tables = printed_configuration.tables_of(program("sextant-mil"), SCENARIO, ["--set", "machine.r_s_ohm=0.5"])
    assert tables["machine"]["r_s_ohm"] == 0.5
    assert tables["name"] == "constant_torque"


def script(directory: Path, text: str) -> Path:
    file = directory / "sextant-mil"
    file.write_text(f"#!/bin/sh\n{text}\n", encoding="utf-8")
    file.chmod(0o755)
    return file


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('echo "sextant-mil: no such key." >&2; exit 2', "sextant-mil refuses the scenario: no such key."),
        ("exit 3", "sextant-mil refuses the scenario: its exit status is 3."),
        ("sleep 10", "has not printed its configuration within 0.2 s."),
    ],
)
def test_what_keeps_it_from_an_answer_is_a_sentence(
    tmp_path: Path, text: str, words: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(printed_configuration, "SECONDS", 0.2 if "sleep" in text else 60)
    with pytest.raises(UserError, match=re.escape(words)):
        printed_configuration.text_of(script(tmp_path, text), SCENARIO)


def test_a_program_that_is_none_is_a_sentence(tmp_path: Path) -> None:
    (tmp_path / "text").write_text("none")
    for name, reason in (("none", "No such file or directory"), ("text", "Permission denied")):
        with pytest.raises(UserError, match=rf"{name} cannot be run: .*{reason}"):
            printed_configuration.text_of(tmp_path / name, SCENARIO)
