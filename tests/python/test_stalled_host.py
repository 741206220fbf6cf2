"""scripts/check_stalled_host: all processes of a command stand still again and again; its exit status is kept."""

import subprocess
import sys

import pytest
from sextant_py import stalled_host
from sextant_py.paths import ROOT

CHECK = ROOT / "scripts" / "check_stalled_host"

# A process below the command's own, whose parent has ended: the longest time between two looks at the clock [s].
ORPHAN = """
import os, sys, time
if os.fork():
    os._exit(0)
longest, last = 0.0, time.monotonic()
end = last + 8.0
while last < end:
    time.sleep(0.01)
    now = time.monotonic()
    longest, last = max(longest, now - last), now
print(longest, flush=True)
"""
# One that is stopped by its own command must stay so until that wakes it.
STOPPED = """
import os, signal, subprocess, sys, time
def state():
    return open(f"/proc/{sleeper.pid}/stat").read().rsplit(")", 1)[1].split()[0]
sleeper = subprocess.Popen(["sleep", "600"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
os.kill(sleeper.pid, signal.SIGSTOP)
while state() != "T":
    time.sleep(0.01)
end = time.monotonic() + 8.0
found = "T"
while found == "T" and time.monotonic() < end:
    time.sleep(0.05)
    found = state()
sleeper.kill()
if found != "T":
    sys.exit(f"it is in {found}")
"""


def run(*command: str) -> subprocess.CompletedProcess:
    module = [sys.executable, "-m", "sextant_py.stalled_host"]
    return subprocess.run([*module, *command], cwd=ROOT / "scripts", capture_output=True, text=True, timeout=480)


def test_every_process_below_the_command_stands_still() -> None:
    # The command waits for what the orphan says: the pipe ends with it.
    found = run("bash", "-c", '"$0" -c "$1" | cat', sys.executable, ORPHAN)
    assert found.returncode == 0, found.stderr
    assert float(found.stdout.splitlines()[0]) >= 0.9 * stalled_host.STOP_S


def test_a_guest_stands_still_too() -> None:
    """The tests on a kernel vcan stall with it, where their kernel is a process of this machine."""
    found = run(str(ROOT / "scripts" / "with_vcan"), "bash", "-c", '"$0" -c "$1" | cat', sys.executable, ORPHAN)
    assert found.returncode == 0, found.stderr
    assert float(found.stdout.splitlines()[0]) >= 0.9 * stalled_host.STOP_S


def test_who_is_stopped_by_the_test_is_not_woken() -> None:
    found = run(sys.executable, "-c", STOPPED)
    assert found.returncode == 0, found.stderr


def test_the_exit_status_is_the_commands_own() -> None:
    assert run("bash", "-c", "exit 7").returncode == 7
    assert run("bash", "-c", "kill -9 $$").returncode == 128 + 9


@pytest.mark.parametrize(
    ("arguments", "words"), [(["--frobnicate"], "unknown argument"), (["3", "--frobnicate"], "unknown argument")]
)
def test_bad_arguments(arguments: list[str], words: str) -> None:
    found = subprocess.run([CHECK, *arguments], capture_output=True, text=True, timeout=480)
    assert found.returncode == 2
    assert words in found.stderr


def test_help() -> None:
    found = subprocess.run([CHECK, "--help"], capture_output=True, text=True, timeout=480)
    assert found.returncode == 0
    assert found.stdout.startswith("check_stalled_host [N]")
