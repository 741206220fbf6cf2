"""Which kernel the tests run on."""

from functools import cache
from pathlib import Path

import pytest


@cache
def is_user_mode_linux() -> bool:
    """There a system call costs 15 µs to 60 µs, and all processes share one processor."""
    return "User Mode Linux" in Path("/proc/cpuinfo").read_text(encoding="utf-8")


def native_kernel_only() -> None:
    """Ends a test whose claim needs the time that User Mode Linux does not leave."""
    if is_user_mode_linux():
        pytest.skip("claim of a native kernel; shown by live.udp_multicast")
