"""What the HIL tests put down to the host, and what they do not: hil_handling and host_watch."""

import os
import signal
import time
from pathlib import Path
from types import SimpleNamespace

import pytest
from failures import SpoiltByHostError
from hil_handling import ATTEMPTS, COMMAND_LOST, MEASUREMENT_INVALID, Delay, Rig, excuse_trip, held_within
from host_watch import HostWatch

LIMIT_NS = 10_000_000
OVER_CURRENT = 8
IN_TIME = Delay(1_000_000_000, 1_006_000_000)
LATE = Delay(1_000_000_000, 1_012_000_000)  # by 2 ms
BEFORE_ITS_CAUSE = Delay(1_000_000_000, 999_000_000)


def standing_still(*spans_ns: tuple[int, int]) -> SimpleNamespace:
    """A host that stood still in these spans."""

    def stood_still_ns(begin_ns: int, end_ns: int) -> int:
        return sum(max(0, min(end_ns, end) - max(begin_ns, begin)) for begin, end in spans_ns)

    return SimpleNamespace(stood_still_ns=stood_still_ns)


NEVER = standing_still()
WITHIN = standing_still((1_001_000_000, 1_004_000_000))
TOO_SHORT = standing_still((1_001_000_000, 1_002_000_000))
BEFORE = standing_still((900_000_000, 950_000_000))


@pytest.mark.parametrize(
    ("delays", "host", "outcome"),
    [
        ([IN_TIME], NEVER, None),
        ([LATE], NEVER, pytest.fail.Exception),
        ([LATE], TOO_SHORT, pytest.fail.Exception),
        ([LATE], BEFORE, pytest.fail.Exception),
        ([LATE, IN_TIME], WITHIN, None),
        ([LATE, LATE, LATE], WITHIN, SpoiltByHostError),
        ([BEFORE_ITS_CAUSE], NEVER, pytest.fail.Exception),
        ([BEFORE_ITS_CAUSE], WITHIN, pytest.fail.Exception),
        ([BEFORE_ITS_CAUSE, IN_TIME], BEFORE, None),
    ],
)
def test_a_delay_is_excused_by_a_stall_that_explains_it(
    delays: list[Delay], host: SimpleNamespace, outcome: type[BaseException] | None
) -> None:
    left = iter(delays)
    if outcome is None:
        held_within("gates open", LIMIT_NS, lambda: next(left), host)
    else:
        with pytest.raises(outcome):
            held_within("gates open", LIMIT_NS, lambda: next(left), host)
    assert list(left) == [], "measured less often than it may be"
    assert len(delays) <= ATTEMPTS


@pytest.mark.parametrize(
    ("fault", "still_ns", "is_excused"),
    [
        (MEASUREMENT_INVALID, 25_000_000, True),
        (COMMAND_LOST, 200_000_000, True),
        (MEASUREMENT_INVALID, 1_500_000, False),
        (OVER_CURRENT, 25_000_000, False),
    ],
)
def test_a_trip_is_excused_by_a_stall_that_can_have_caused_it(fault: int, still_ns: int, is_excused: bool) -> None:
    earlier, state = (
        SimpleNamespace(first_fault=fault, reason="of the test", state=SimpleNamespace(name="FAULT"), t_ns=t_ns)
        for t_ns in (-1_000_000_000, 2_000_000_000)
    )
    record = SimpleNamespace(run=lambda seconds: None, states=[earlier, state])
    rig = Rig(record, None, standing_still((2_000_000_000 - still_ns, 2_000_000_000), (0, 1_000_000_000)))
    if is_excused:
        excuse_trip(rig, 0)
    else:
        with pytest.raises(pytest.fail.Exception, match="the drive tripped"):
            excuse_trip(rig, 0)


def test_a_processor_that_stands_still_is_seen_and_when(tmp_path: Path) -> None:
    before_ns = time.monotonic_ns()
    with HostWatch(tmp_path) as watch:
        stopped = watch.process_ids[0]
        os.kill(stopped, signal.SIGSTOP)
        begin_ns = time.monotonic_ns()
        time.sleep(0.05)
        end_ns = time.monotonic_ns()
        os.kill(stopped, signal.SIGCONT)
        assert watch.stood_still_ns(begin_ns, end_ns) >= 45_000_000
        assert watch.stood_still_ns(0, before_ns) == 0
