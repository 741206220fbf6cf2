"""Completion in bash, by the code that `completion bash` prints, with the variables that bash sets."""

import subprocess
import sys
from pathlib import Path

import pytest
from sextant_py.paths import ROOT

# What bash does at a tab, for a line whose words contain no blanks.
TAB = r"""
sextant() { PYTHONPATH=scripts "$PYTHON" -m sextant_py "$@"; }
COMP_LINE=$1 COMP_POINT=${#1} COMP_TYPE=9
COMP_WORDS=($1)
[[ $1 != *' ' ]] || COMP_WORDS+=('')
COMP_CWORD=$((${#COMP_WORDS[@]} - 1))
function=$(complete -p "${COMP_WORDS[0]}" | sed 's/.*-F \([^ ]*\) .*/\1/')
"$function" "${COMP_WORDS[0]}" "${COMP_WORDS[COMP_CWORD]}" 2>/dev/null
printf '%s\n' "${COMPREPLY[@]}"
"""


@pytest.fixture(scope="module")
def code() -> str:
    command = [ROOT / "scripts" / "completion", "bash"]
    return subprocess.run(command, capture_output=True, text=True, check=True, timeout=120).stdout


def completed(code: str, line: str) -> set[str]:
    environment = {"PATH": "/usr/bin:/bin", "PYTHON": sys.executable}
    command = ["bash", "-c", code + TAB, "bash", line]
    found = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, timeout=120, env=environment)
    assert found.returncode == 0, found.stderr
    return {word.strip() for word in found.stdout.splitlines() if word.strip()}


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("scripts/plot --sp", {"--spectrum"}),
        ("scripts/plot trace.h5 --locus ", {"flux", "current"}),
        ("./scripts/compare a b --j", {"--json", "--junit"}),
        ("scripts/sweep --sch", {"--scheduler"}),
        ("sextant pl", {"playback", "plot"}),
        ("sextant plot --locus f", {"flux"}),
        ("sextant vcu --prof", {"--profile"}),
        ("sextant nonsense --x", set()),
    ],
)
def test_a_line_is_completed(code: str, line: str, expected: set[str]) -> None:
    assert completed(code, line) == expected


def test_every_command_is_offered(code: str) -> None:
    from sextant_py.commands import COMMANDS

    assert completed(code, "sextant ") >= set(COMMANDS)


def test_the_code_for_zsh_is_for_zsh() -> None:
    command = [ROOT / "scripts" / "completion", "zsh"]
    said = subprocess.run(command, capture_output=True, text=True, check=True, timeout=120).stdout
    assert said.startswith("#compdef sextant scripts/vcu")


def test_an_unknown_shell_is_refused(tmp_path: Path) -> None:
    found = subprocess.run([ROOT / "scripts" / "completion", "fish"], capture_output=True, text=True, timeout=120)
    assert found.returncode == 2
    assert "invalid choice: 'fish'" in found.stderr
