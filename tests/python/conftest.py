"""Fixtures shared by the Python tests."""

import itertools
import os
import socket
from collections.abc import Iterator

import pytest
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
    """A DDS domain that no other test of this machine is likely to use at the same time."""
    return 10 + (os.getpid() * 7 + next(_offsets)) % 200


@pytest.fixture
def udp_port() -> int:
    """A UDP port that is free."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("", 0))
        return probe.getsockname()[1]


@pytest.fixture
def bus_address(udp_port: int) -> str:
    """A CAN bus of one's own over UDP multicast; skipped, aloud, where the machine has no route for it."""
    from sextant_py import bus
    from sextant_py.errors import UserError

    address = f"udp_multicast:239.74.163.2:{udp_port}"
    try:
        bus.open_bus(bus.parse(address)).shutdown()
    except UserError as error:
        pytest.skip(f"NOT TESTED: {error}")
    return address
