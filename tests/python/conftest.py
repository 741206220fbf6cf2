"""Fixtures shared by the Python tests."""

import itertools
import os
from collections.abc import Iterator

import pytest
from free_bus import free_udp_port, multicast_address, reason_against
from host_watch import HostWatch
from verdict import pytest_runtest_makereport, pytest_sessionfinish

__all__ = ["pytest_runtest_makereport", "pytest_sessionfinish"]

PRIORITY = 5  # below plant, drive and vehicle, above all else

_offsets = itertools.count()


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line(
        "markers", "timing: its assertions are deadlines, which a stalled host can miss; see verdict"
    )


@pytest.fixture(scope="session")
def host(tmp_path_factory: pytest.TempPathFactory) -> Iterator[HostWatch]:
    """The host is watched. Meanwhile the test itself, but nothing it starts, has real-time priority where it may.

    The time at which it did something has to be the time at which it meant to.
    """
    policy, parameters = os.sched_getscheduler(0), os.sched_getparam(0)
    with HostWatch(tmp_path_factory.mktemp("host")) as watch:
        try:
            os.sched_setscheduler(0, os.SCHED_RR | os.SCHED_RESET_ON_FORK, os.sched_param(PRIORITY))
        except PermissionError:
            print("no right to real-time scheduling here; on a busy machine measurements may have to be repeated")
        try:
            yield watch
        finally:
            os.sched_setscheduler(0, policy, parameters)


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
