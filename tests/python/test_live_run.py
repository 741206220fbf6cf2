"""tests/python/live/run: what it starts, and the exit status of a module that was skipped as a whole."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from sextant_py.paths import ROOT

LIVE = ROOT / "tests" / "python" / "live"
SKIPPED = 77

TESTS = """
import pytest

def test_right():
    pass

def test_wrong():
    assert 2 == 3

def test_skipped():
    pytest.skip("not here")

@pytest.mark.skipif(True, reason="nor here")
def test_skipped_by_mark():
    pass
"""


@pytest.mark.parametrize(
    ("chosen", "status"),
    [
        ("test_right or test_skipped", 0),
        ("test_skipped", SKIPPED),
        ("test_skipped or test_skipped_by_mark", SKIPPED),
        ("test_skipped or test_wrong", 1),
        ("no_such_test", 5),
    ],
)
def test_a_module_that_was_skipped_as_a_whole_is_no_success(chosen: str, status: int, tmp_path: Path) -> None:
    (tmp_path / "test_seeded.py").write_text(TESTS)
    conftest = ROOT / "tests" / "python" / "conftest.py"
    (tmp_path / "conftest.py").write_text(conftest.read_text(encoding="utf-8"), encoding="utf-8")
    command = [sys.executable, "-m", "pytest", "-q", "-c", "/dev/null", "--rootdir", tmp_path, "-p", "no:cacheprovider"]
    path = os.pathsep.join(map(str, (ROOT / "tests" / "python", ROOT / "scripts")))
    environment = {**os.environ, "PYTHONPATH": path, "PYTHONDONTWRITEBYTECODE": "1"}
    found = subprocess.run([*command, "-k", chosen, tmp_path], capture_output=True, text=True, env=environment)
    assert found.returncode == status, found.stdout + found.stderr
    assert ("NOT TESTED" in found.stdout) == (status == SKIPPED)


PYTHON = """#!/bin/bash
echo "$SEXTANT_LIVE_BUS $*" >>calls
exit "$STATUS"
"""


class Tree:
    """A tree in which only `run` is real."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self._write("tests/python/live/run", (LIVE / "run").read_text(encoding="utf-8"))
        self._write(".venv/bin/python", PYTHON)
        self._write("build/dev/apps/sextant-ecu", "#!/bin/sh\n")
        self._write("scripts/with_vcan", '#!/bin/bash\nshift 4\nexec "$@"\n')

    def _write(self, name: str, text: str) -> None:
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        path.chmod(0o755)

    def run(self, *arguments: str, status: int = 0, **more: str) -> subprocess.CompletedProcess:
        environment = {key: value for key, value in os.environ.items() if not key.startswith("SEXTANT_")}
        return subprocess.run(
            [self.root / "tests/python/live/run", *arguments],
            capture_output=True,
            text=True,
            cwd="/",
            env={**environment, "STATUS": str(status), **more},
        )

    def calls(self) -> list[str]:
        return (self.root / "calls").read_text().splitlines()


@pytest.fixture
def tree(tmp_path: Path) -> Tree:
    return Tree(tmp_path)


@pytest.mark.parametrize("status", [0, 1, SKIPPED, 124])
@pytest.mark.parametrize(("kind", "bus"), [("udp_multicast", "udp_multicast"), ("vcan", "socketcan")])
def test_run_ends_as_its_tests_do(kind: str, bus: str, status: int, tree: Tree) -> None:
    assert tree.run(kind, "-k", "leaves", status=status).returncode == status
    assert tree.calls() == [f"{bus} -m pytest -s tests/python/live -k leaves"]


def test_run_without_programs_says_where_they_were_sought(tree: Tree) -> None:
    found = tree.run("vcan", SEXTANT_BIN="/no/such/place")
    assert found.returncode == 1
    assert "no sextant-ecu in /no/such/place" in found.stderr
