"""What becomes of a failing live test: tests/python/live/run, judged below it, and the verdict they ask pytest for."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from sextant_py.paths import ROOT

LIVE = ROOT / "tests" / "python" / "live"
JUDGED = ROOT / "tests" / "python" / "judged"
ONLY_TIMING_FAILED = 70
SKIPPED = 77

TESTS = """
import pytest
from failures import NotSeenError, SpoiltByHostError

@pytest.mark.timing
def test_late():
    assert 0.3 <= 0.1

@pytest.mark.timing
def test_late_too():
    assert 0.2 <= 0.1

@pytest.mark.timing
def test_in_time():
    pass

def test_wrong():
    assert 2 == 3

@pytest.mark.timing
def test_never_seen():
    raise NotSeenError("waited in vain")

@pytest.mark.timing
def test_crashed():
    pytest.fail("exit status 134")

@pytest.mark.timing
def test_error():
    raise ValueError

@pytest.fixture
def broken():
    assert False

@pytest.mark.timing
def test_set_up(broken):
    pass

@pytest.mark.timing
def test_skipped():
    pytest.skip("not here")

@pytest.mark.skipif(True, reason="nor here")
def test_skipped_by_mark():
    pass

def test_spoilt():
    raise SpoiltByHostError("three times")
"""


@pytest.mark.parametrize(
    ("chosen", "status"),
    [
        ("test_late", ONLY_TIMING_FAILED),
        ("test_late or test_late_too or test_in_time or test_skipped", ONLY_TIMING_FAILED),
        ("test_in_time or test_skipped", 0),
        ("test_skipped", SKIPPED),
        ("test_skipped or test_skipped_by_mark", SKIPPED),
        ("test_skipped or test_late", ONLY_TIMING_FAILED),
        ("test_spoilt", ONLY_TIMING_FAILED),
        ("test_spoilt or test_late", ONLY_TIMING_FAILED),
        ("test_spoilt or test_wrong", 1),
        ("test_wrong", 1),
        ("test_late or test_wrong", 1),
        ("test_late or test_never_seen", 1),
        ("test_crashed", 1),
        ("test_error", 1),
        ("test_set_up", 1),
        ("no_such_test", 5),
    ],
)
def test_only_missed_deadlines_are_a_matter_of_timing(chosen: str, status: int, tmp_path: Path) -> None:
    (tmp_path / "test_seeded.py").write_text(TESTS)
    (tmp_path / "conftest.py").write_text("from verdict import *\n")
    command = [sys.executable, "-m", "pytest", "-q", "-c", "/dev/null", "--rootdir", tmp_path, "-p", "no:cacheprovider"]
    path = os.pathsep.join(map(str, (LIVE, ROOT / "scripts")))
    environment = {**os.environ, "PYTHONPATH": path, "PYTHONDONTWRITEBYTECODE": "1"}
    found = subprocess.run([*command, "-k", chosen, tmp_path], capture_output=True, text=True, env=environment)
    assert found.returncode == status, found.stdout + found.stderr


def test_tests_with_deadlines_are_marked() -> None:
    marked = set()
    for file in LIVE.glob("test_*.py"):
        marked |= set(re.findall(r"@pytest\.mark\.timing\n(?:@.*\n)*def (\w+)", file.read_text(encoding="utf-8")))
    assert marked == {
        "test_steps",
        "test_leaves_in_good_order",
        "test_short_silence_heals",
        "test_long_silence_latches_and_the_way_back",
        "test_interface_down_and_up",
    }


# Instead of Python: answers for host_stalls.py with a count, for pytest with the statuses asked for, one after another.
PYTHON = """#!/bin/bash
case "$1" in
  *host_stalls.py) printf '%s' "$STALLS" >"$2"; touch watching; exec sleep 60 ;;
esac
echo "$*" >>calls
until [ -e watching ]; do sleep 0.01; done
read -r status <statuses
sed -i 1d statuses
exit "$status"
"""


class Tree:
    """A tree in which only run and judged are real."""

    def __init__(self, root: Path) -> None:
        self.root = root
        for script in (LIVE / "run", JUDGED):
            self._write(str(script.relative_to(ROOT)), script.read_text(encoding="utf-8"))
        self._write(".venv/bin/python", PYTHON)
        self._write("build/dev/apps/sextant-ecu", "#!/bin/sh\n")
        self._write("scripts/with_vcan", '#!/bin/bash\nshift 2\nexec "$@"\n')

    def _write(self, name: str, text: str) -> None:
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        path.chmod(0o755)

    def run(self, *arguments: str, statuses: list[int], stalls: int = 0, **more: str) -> subprocess.CompletedProcess:
        return self.start("live/run", *arguments, statuses=statuses, stalls=stalls, **more)

    def start(
        self, script: str, *arguments: str, statuses: list[int], stalls: int, **more: str
    ) -> subprocess.CompletedProcess:
        (self.root / "statuses").write_text("".join(f"{status}\n" for status in statuses))
        environment = {key: value for key, value in os.environ.items() if not key.startswith("SEXTANT_")}
        return subprocess.run(
            [self.root / "tests/python" / script, *arguments],
            capture_output=True,
            text=True,
            timeout=30,
            cwd=self.root if script == "judged" else "/",
            env={**environment, "STALLS": f"{stalls} 31", **more},
        )

    def calls(self) -> list[str]:
        return (self.root / "calls").read_text().splitlines()


@pytest.fixture
def tree(tmp_path: Path) -> Tree:
    return Tree(tmp_path)


@pytest.mark.parametrize(
    ("statuses", "stalls", "expected"),
    [
        ([0], 9, 0),
        ([1, 0], 9, 0),
        ([70, 0], 0, 0),
        ([70, 70], 5, SKIPPED),
        ([1, 70], 5, SKIPPED),
        ([70, 70], 4, 1),
        ([70, 1], 9, 1),
        ([77], 0, SKIPPED),
        ([1, 1], 9, 1),
        ([4], 9, 1),
        ([124], 9, 1),
    ],
)
@pytest.mark.parametrize("kind", ["udp_multicast", "vcan"])
def test_exit_status_of_run(kind: str, statuses: list[int], stalls: int, expected: int, tree: Tree) -> None:
    found = tree.run(kind, statuses=statuses, stalls=stalls)
    assert found.returncode == expected, found.stderr
    assert ("NOT JUDGED" in found.stderr) == (70 in statuses and expected == SKIPPED)
    assert ("NOT TESTED" in found.stderr) == (77 in statuses)
    calls = tree.calls()
    assert ["--last-failed" in call for call in calls] == [False, True][: len(statuses)]


@pytest.mark.parametrize(
    ("statuses", "stalls", "expected"),
    [
        ([0], 9, 0),
        ([1], 9, 1),
        ([70, 0], 0, 0),
        ([70, 70], 5, SKIPPED),
        ([70, 70], 4, 1),
        ([70, 1], 9, 1),
        ([77], 0, 77),
    ],
)
def test_judged_repeats_only_deadlines(statuses: list[int], stalls: int, expected: int, tree: Tree) -> None:
    found = tree.start("judged", ".venv/bin/python", "-m", "pytest", statuses=statuses, stalls=stalls)
    assert found.returncode == expected, found.stderr
    assert tree.calls() == ["-m pytest", "-m pytest --last-failed"][: len(statuses)]


def test_run_once_measures_once(tree: Tree) -> None:
    assert tree.run("vcan", statuses=[70, 0], stalls=0, SEXTANT_LIVE_ONCE="1").returncode == 1
    assert len(tree.calls()) == 1


def test_run_selects_tests(tree: Tree) -> None:
    tree.run("vcan", statuses=[0])
    tree.run("vcan", "-m", "nightly", statuses=[0])
    tree.run("udp_multicast", "-k", "leaves", statuses=[0])
    by_default, nightly, multicast = tree.calls()
    assert by_default.endswith("-m not nightly")
    assert nightly.endswith("tests/python/live -m nightly")
    assert multicast.endswith("tests/python/live -k leaves")


def test_run_without_programs_says_where_they_were_sought(tree: Tree) -> None:
    found = tree.run("vcan", statuses=[], SEXTANT_BIN="/no/such/place")
    assert found.returncode == 1
    assert "no sextant-ecu in /no/such/place" in found.stderr
