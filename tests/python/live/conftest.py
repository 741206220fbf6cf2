"""Fixtures of the live tests: sextant-ecu runs as a process of its own and is met only over CAN and DDS.

The environment says what is tested: SEXTANT_BIN is the directory of the programs, SEXTANT_LIVE_BUS the kind of CAN bus,
"socketcan" (vcan0, inside scripts/with_vcan) or "udp_multicast".
"""

import os
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
from drive_process import WIDE, DriveProcess
from free_bus import free_udp_port, multicast_address, reason_against
from kernel import in_guest, is_emulated

KIND = os.environ.get("SEXTANT_LIVE_BUS", "udp_multicast")
# A guest is slow: a control thread that has more to do than there is time leaves nothing to the rest.
IN_GUEST = ("dds.telemetry_rate_hz=100", "realtime.wake_every_periods=200", "realtime.stage_statistics=false")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """In QEMU only those tests run that are marked kernel_can: SocketCAN itself is what they test."""
    if is_emulated():
        elsewhere = pytest.mark.skip(reason="it needs no CAN of the kernel; live.udp_multicast runs it")
        for item in items:
            if item.get_closest_marker("kernel_can") is None:
                item.add_marker(elsewhere)


def _address(index: int) -> str:
    address = f"socketcan:vcan{index}" if KIND == "socketcan" else multicast_address(free_udp_port())
    if reason := reason_against(address):
        if "SEXTANT_LIVE_BUS" in os.environ:
            pytest.fail(f"a bus that is asked for by name has to be there: {reason}")
        pytest.skip(f"NOT TESTED: {reason}")
    return address


@pytest.fixture
def live_bus() -> str:
    """The CAN bus of the test, used by nobody else."""
    return _address(0)


@pytest.fixture
def other_bus() -> str:
    """A second bus beside the first."""
    return _address(1)


@pytest.fixture
def start_drive(domain: int, tmp_path: Path) -> Iterator[Callable[..., DriveProcess]]:
    """start_drive(bus, key=value…): a running sextant-ecu in the test's DDS domain, ended with the test."""
    with ExitStack() as stack:

        def start(address: str, *settings: str) -> DriveProcess:
            common = (*WIDE, *(IN_GUEST if in_guest() else ()))
            return stack.enter_context(DriveProcess(address, domain, tmp_path, (*common, *settings)))

        yield start
