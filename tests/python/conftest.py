"""Fixtures shared by the Python tests."""

import itertools
import os

import pytest
from free_bus import free_udp_port, multicast_address, reason_against

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
def domain() -> int:
    """A DDS domain that no other test of this machine is likely to use at the same time; C++ tests have those below."""
    return 40 + (os.getpid() * 7 + next(_offsets)) % 190


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
