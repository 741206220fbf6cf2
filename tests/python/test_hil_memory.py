"""The shared memory of a link when somebody else made it: neither program takes it."""

import os
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from hil_processes import DRIVE, PLANT
from programs import overrides, program

NOBODY = 65534
LINK_BYTES = 131_520
NEEDS_ROOT = pytest.mark.skipif(os.geteuid() != 0, reason="NOT TESTED: only root can become another user")


@pytest.fixture
def memory() -> Iterator[Path]:
    path = Path("/dev/shm", f"sextant_test_{os.getpid()}_{time.monotonic_ns()}")
    yield path
    path.unlink(missing_ok=True)


@pytest.fixture
def settings(memory: Path, bus_address: str, domain: int) -> dict[str, tuple[Path, tuple[str, ...]]]:
    link = f"hil.link={memory.name}"
    return {
        "sextant-plant": (PLANT, (link,)),
        "sextant-ecu": (DRIVE, (link, f"can.bus={bus_address}", f"dds.domain={domain}")),
    }


def refusal(name: str, config: Path, settings: tuple[str, ...], before: tuple[str, ...] = ()) -> str:
    """The one sentence with which the program refuses to start."""
    command = [*before, program(name), config, *overrides(settings), "--duration", "1"]
    found = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert found.returncode == 2, found
    lines = [line for line in found.stderr.splitlines() if line.startswith(f"{name}: ")]
    assert len(lines) == 1, found.stderr
    return lines[0]


@NEEDS_ROOT
@pytest.mark.parametrize("name", ["sextant-plant", "sextant-ecu"])
def test_memory_that_another_user_made_first_is_refused_to_root(
    name: str, memory: Path, settings: dict[str, tuple[Path, tuple[str, ...]]]
) -> None:
    """The attack: an unprivileged user makes empty memory, which everybody may write, before the programs start."""
    squat = f"umask 0 && head -c {LINK_BYTES} /dev/zero > {memory}"
    nobody = ("setpriv", f"--reuid={NOBODY}", f"--regid={NOBODY}", "--clear-groups")
    subprocess.run([*nobody, "sh", "-c", squat], check=True)
    assert (memory.stat().st_uid, memory.stat().st_mode & 0o777) == (NOBODY, 0o666)
    sentence = refusal(name, *settings[name])
    assert f"{memory} belongs to another user (id {NOBODY}; this program runs as 0)" in sentence
    assert "run both sides as one user, or remove it, or choose another name" in sentence
    assert memory.read_bytes() == bytes(LINK_BYTES), "nothing has been written there"


@pytest.mark.parametrize("name", ["sextant-plant", "sextant-ecu"])
def test_memory_that_others_may_write_is_refused(
    name: str, memory: Path, settings: dict[str, tuple[Path, tuple[str, ...]]]
) -> None:
    memory.write_bytes(bytes(LINK_BYTES))
    memory.chmod(0o666)
    sentence = refusal(name, *settings[name])
    assert f"{memory} may be reached by other users (mode 0666)" in sentence


@NEEDS_ROOT
@pytest.mark.parametrize("name", ["sextant-plant", "sextant-ecu"])
def test_memory_without_room_is_refused(
    name: str, memory: Path, settings: dict[str, tuple[Path, tuple[str, ...]]]
) -> None:
    """A /dev/shm of its own that is smaller than the link, in a mount namespace."""
    small = f'mount -t tmpfs -o size={LINK_BYTES // 2} none /dev/shm && exec "$@"'
    before = ("unshare", "--mount", "--propagation", "private", "sh", "-c", small, "sh")
    if subprocess.run([*before, "true"], capture_output=True, check=False).returncode != 0:
        pytest.skip("NOT TESTED: this machine grants no mount namespace")
    assert "finds no room: No space left on device" in refusal(name, *settings[name], before)
