"""Fixtures shared by the Python tests."""

import itertools
import os

import pytest
from free_bus import free_udp_port, multicast_address, reason_against

_offsets = itertools.count()


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
    """A CAN bus of one's own over UDP multicast; skipped where the machine has no route for it."""
    address = multicast_address(udp_port)
    if reason := reason_against(address):
        pytest.skip(reason)
    return address
