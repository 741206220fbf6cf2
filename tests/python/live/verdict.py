"""Tells deadlines that a stalled host can miss from everything else that can fail; hooks of pytest, see conftest.py.

Where nothing failed but assertions of tests marked `timing`, and measurements of any test that ended in a
SpoiltByHostError, pytest's exit status is ONLY_TIMING_FAILED instead of 1. What was waited for in vain, pytest.fail, an
error, and a failure in set-up or tear-down is never a matter of timing.
Where every test was skipped the exit status is ALL_SKIPPED instead of 0: nothing has been tested.
"""

import pytest
from failures import NotSeenError, SpoiltByHostError

ONLY_TIMING_FAILED = 70  # judged knows both
ALL_SKIPPED = 77

_TIMING = pytest.StashKey[int]()
_RUN = pytest.StashKey[int]()
_SKIPPED = pytest.StashKey[int]()


def _is_timing(item: pytest.Item, call: pytest.CallInfo) -> bool:
    if call.excinfo is None or call.when != "call":
        return False
    if call.excinfo.errisinstance(SpoiltByHostError):
        return True
    if item.get_closest_marker("timing") is None:
        return False
    return call.excinfo.errisinstance(AssertionError) and not call.excinfo.errisinstance(NotSeenError)


def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo) -> None:
    counts = item.config.stash
    if _is_timing(item, call):
        counts[_TIMING] = counts.get(_TIMING, 0) + 1
    if call.excinfo is not None and call.excinfo.errisinstance(pytest.skip.Exception):
        counts[_SKIPPED] = counts.get(_SKIPPED, 0) + 1
    elif call.when == "call":
        counts[_RUN] = counts.get(_RUN, 0) + 1


def pytest_sessionfinish(session: pytest.Session, exitstatus: int) -> None:
    counts = session.config.stash
    if exitstatus == pytest.ExitCode.TESTS_FAILED and counts.get(_TIMING, 0) == session.testsfailed:
        session.exitstatus = ONLY_TIMING_FAILED
    if exitstatus == pytest.ExitCode.OK and counts.get(_RUN, 0) == 0 and counts.get(_SKIPPED, 0) > 0:
        session.exitstatus = ALL_SKIPPED
