"""Fixtures shared by the Python tests."""

import fcntl
import gc
import itertools
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from free_bus import free_udp_port, multicast_address, reason_against

FIRST_DOMAIN, DOMAINS = 40, 190
ALL_SKIPPED = 77  # ctest shows such a module as skipped

_RUN, _SKIPPED = pytest.StashKey[int](), pytest.StashKey[int]()
_offsets = itertools.count()


def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo) -> None:
    counts = item.config.stash
    if call.excinfo is not None and call.excinfo.errisinstance(pytest.skip.Exception):
        counts[_SKIPPED] = counts.get(_SKIPPED, 0) + 1
    elif call.when == "call":
        counts[_RUN] = counts.get(_RUN, 0) + 1


def pytest_sessionfinish(session: pytest.Session, exitstatus: int) -> None:
    """A module of which every test was skipped has tested nothing, and says so."""
    counts = session.config.stash
    if exitstatus == pytest.ExitCode.OK and counts.get(_RUN, 0) == 0 and counts.get(_SKIPPED, 0) > 0:
        print("NOT TESTED: every test was skipped")
        session.exitstatus = ALL_SKIPPED


@pytest.fixture
def domain() -> Iterator[int]:
    """A DDS domain that no other Python test of this machine uses at the same time; C++ tests have those below.

    Its participants end with the test: one that waits for the collector of cyclic garbage is there for the next test,
    of whichever process, that has this domain.
    """
    for _ in range(DOMAINS):
        number = FIRST_DOMAIN + (os.getpid() * 7 + next(_offsets)) % DOMAINS
        with Path(tempfile.gettempdir(), f"sextant_test_domain_{number}").open("w") as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                continue
            yield number
            gc.collect()
            return
    pytest.fail("every DDS domain is in use")


@pytest.fixture
def udp_port() -> int:
    """A UDP port that is free."""
    return free_udp_port()


@pytest.fixture
def bus_address(udp_port: int) -> str:
    """A CAN bus of one's own over UDP multicast; skipped, aloud, where the machine has no route for it."""
    address = multicast_address(udp_port)
    if reason := reason_against(address):
        pytest.skip(f"NOT TESTED: {reason}")
    return address
