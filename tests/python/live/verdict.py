"""Tells deadlines that a stalled host can miss from everything else that can fail; hooks of pytest, see conftest.py.

Where nothing failed but assertions of tests marked `timing`, pytest's exit status is ONLY_TIMING_FAILED instead of 1.
What was waited for in vain, pytest.fail, an error, and a failure in set-up or tear-down is never a matter of timing.
"""

import pytest
from telemetry_record import NotSeenError

ONLY_TIMING_FAILED = 70  # run knows it too

_TIMING = pytest.StashKey[int]()


def _is_timing(item: pytest.Item, call: pytest.CallInfo) -> bool:
    if call.excinfo is None or call.when != "call" or item.get_closest_marker("timing") is None:
        return False
    return call.excinfo.errisinstance(AssertionError) and not call.excinfo.errisinstance(NotSeenError)


def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo) -> None:
    if _is_timing(item, call):
        item.config.stash[_TIMING] = item.config.stash.get(_TIMING, 0) + 1


def pytest_sessionfinish(session: pytest.Session, exitstatus: int) -> None:
    if exitstatus == pytest.ExitCode.TESTS_FAILED and session.config.stash.get(_TIMING, 0) == session.testsfailed:
        session.exitstatus = ONLY_TIMING_FAILED
