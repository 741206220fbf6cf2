"""Which kernel the tests run on."""

import os
from functools import cache

import pytest


@cache
def in_guest() -> bool:
    """Whether the kernel is a guest's, as scripts/with_vcan tells: slow.

    In User Mode Linux a system call costs 15 µs to 60 µs and all processes share one
    processor; in QEMU without KVM all code is emulated, several times slower.
    """
    return os.environ.get("WITH_VCAN") in {"uml", "qemu"}


def is_emulated() -> bool:
    """Whether the kernel is QEMU's, whose guest is too slow for all live tests."""
    return os.environ.get("WITH_VCAN") == "qemu"


def native_kernel_only() -> None:
    """Ends a test that needs more processor time than a guest has."""
    if in_guest():
        pytest.skip("it needs a native kernel; live.udp_multicast runs it")
