"""The fixture `domain`: a test leaves no participant in its DDS domain, which another process may be given next."""

import os
import subprocess
import sys
from pathlib import Path

from sextant_py.paths import ROOT

TESTS = """
import gc
from cyclonedds.domain import DomainParticipant
from sextant_py import dds

gc.disable()  # it would have its turn at some time

def test_leaves_a_cycle(domain):
    node = dds.Node(domain)
    cycle = [node]
    cycle.append(cycle)

def test_nothing_is_left():
    assert not any(isinstance(found, DomainParticipant) for found in gc.get_objects())
"""


def test_participants_end_with_the_test_whose_domain_it_is(tmp_path: Path) -> None:
    (tmp_path / "test_seeded.py").write_text(TESTS)
    conftest = ROOT / "tests" / "python" / "conftest.py"
    (tmp_path / "conftest.py").write_text(conftest.read_text(encoding="utf-8"), encoding="utf-8")
    command = [sys.executable, "-m", "pytest", "-q", "-c", "/dev/null", "--rootdir", tmp_path, "-p", "no:cacheprovider"]
    path = os.pathsep.join(map(str, (ROOT / "tests" / "python", ROOT / "scripts")))
    environment = {**os.environ, "PYTHONPATH": path, "PYTHONDONTWRITEBYTECODE": "1"}
    ended = subprocess.run([*command, tmp_path], capture_output=True, text=True, env=environment, timeout=480)
    assert ended.returncode == 0, ended.stdout + ended.stderr
    assert "2 passed" in ended.stdout
