"""Fixtures shared by the Python tests."""

import itertools
import os
import socket

import pytest

_offsets = itertools.count()


@pytest.fixture
def domain() -> int:
    """A DDS domain that no other test of this machine is likely to use at the same time; C++ tests have those below."""
    return 40 + (os.getpid() * 7 + next(_offsets)) % 190


@pytest.fixture
def udp_port() -> int:
    """A UDP port that is free."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("", 0))
        return probe.getsockname()[1]


@pytest.fixture
def bus_address(udp_port: int) -> str:
    """A CAN bus of one's own over UDP multicast; skipped where the machine has no route for it."""
    from sextant_py import bus
    from sextant_py.errors import UserError

    address = f"udp_multicast:239.74.163.2:{udp_port}"
    try:
        bus.open_bus(bus.parse(address)).shutdown()
    except UserError as error:
        pytest.skip(str(error))
    return address
