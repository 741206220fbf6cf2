"""A drive on a plant in another process, brought into torque production on a machine that may stand still meanwhile.

A host that stops either side for longer than the drive's patience trips the drive, as it should. A trip is put down to
the host only where the host has been seen to stand still; every other one is the drive's failure and ends the test.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass

import pytest
from failures import SpoiltByHostError
from host_watch import HostWatch
from telemetry_record import Span, TelemetryRecord
from vehicle import Vehicle

ATTEMPTS = 3
COMMAND_LOST, MEASUREMENT_INVALID, WATCHDOG = 0, 5, 18
OF_A_STALL = {COMMAND_LOST, MEASUREMENT_INVALID, WATCHDOG}
# What the watchers must have seen at least. Nine patterns that acted since the drive's last period trip it: they do not
# fit one measurement (docs/hil.md); fewer periods than these are no reason. Gates open after 5 ms and more.
STALL_NS = 2_000_000
BEFORE_NS = 300_000_000  # so long before its effect a stall may have begun; a silence of 200 ms is a fault
SHARE_SPOILT = 0.05  # of a span in which a torque is measured


@dataclass
class Rig:
    """What a test has in its hands."""

    record: TelemetryRecord
    vehicle: Vehicle
    host: HostWatch


def is_in(record: TelemetryRecord, *names: str) -> bool:
    return record.samples[-1].state.name in names


def reset(rig: Rig) -> None:
    """Out of FAULT; the fault is expected and has been seen."""
    rig.record.wait_for_state("FAULT")
    rig.vehicle.demand(fault_reset=True)
    rig.record.wait_for_state("STANDBY", "READY")


def to_torque(rig: Rig, torque_nm: float) -> None:
    """Into torque production from any state; a fault that is latched is reset."""
    rig.record.wait_until_heard()
    for _ in range(ATTEMPTS):
        rig.record.poll()
        if is_in(rig.record, "FAULT"):
            reset(rig)
        begin_ns = time.monotonic_ns()
        if _came_to_torque(rig, torque_nm):
            return
        excuse_trip(rig, begin_ns)
    raise SpoiltByHostError(f"the host tripped the drive {ATTEMPTS} times on its way to {torque_nm:g} N·m")


def _came_to_torque(rig: Rig, torque_nm: float) -> bool:
    """Disable until READY, then enable; false where the drive tripped."""
    rig.vehicle.demand()
    rig.record.wait_for_state("READY", "FAULT")
    if is_in(rig.record, "FAULT"):
        return False
    rig.vehicle.demand(torque_nm, enable=True)
    rig.record.wait_for_state("TORQUE", "FAULT")
    return is_in(rig.record, "TORQUE")


def excuse_trip(rig: Rig, begin_ns: int) -> None:
    """The drive has tripped since begin_ns [CLOCK_MONOTONIC]: the host's doing, said aloud, or a failure."""
    rig.record.run(0.1)
    tripped = [state for state in rig.record.states if state.state.name == "FAULT" and state.t_ns >= begin_ns]
    if not tripped:
        pytest.fail("the drive tripped and has not said so")
    state = tripped[0]
    still_ns = rig.host.stood_still_ns(state.t_ns - BEFORE_NS, state.t_ns)
    what = f"the drive tripped ({state.reason}) while the host stood still for {still_ns * 1e-6:.1f} ms"
    if state.first_fault not in OF_A_STALL or still_ns < STALL_NS:
        pytest.fail(what)
    print(f"disturbed: {what}")


def at_torque(rig: Rig, torque_nm: float, seconds: float, sound: Callable[[Span], bool] = lambda _: True) -> Span:
    """The samples of so many seconds of torque production without a trip.

    A span that is not sound is taken anew where the host stood still for a good part of it; elsewhere it counts.
    """
    for _ in range(ATTEMPTS):
        to_torque(rig, torque_nm)
        begin_ns = time.monotonic_ns()
        span = rig.record.run(seconds)
        if "FAULT" in span.states:
            excuse_trip(rig, begin_ns)
            continue
        if sound(span):
            return span
        still_ns = rig.host.stood_still_ns(begin_ns, time.monotonic_ns())
        if still_ns <= SHARE_SPOILT * seconds * 1e9:
            return span
        print(f"disturbed: the host stood still for {still_ns * 1e-6:.1f} ms of {seconds:g} s at torque")
    raise SpoiltByHostError(f"each of {ATTEMPTS} spans of {seconds:g} s at torque was disturbed")


@dataclass(frozen=True)
class Delay:
    """From a cause to its effect, on CLOCK_MONOTONIC [ns]."""

    cause_ns: int
    effect_ns: int

    @property
    def ns(self) -> int:
        return self.effect_ns - self.cause_ns


def held_within(what: str, limit_ns: int, measure: Callable[[], Delay], host: HostWatch) -> None:
    """Holds a delay against its limit. What the host has spoilt is measured anew, at most twice; all else counts."""
    for _ in range(ATTEMPTS):
        delay = measure()
        print(f"{what}: {delay.ns * 1e-6:.2f} ms, at most {limit_ns * 1e-6:g} ms")
        if 0 < delay.ns <= limit_ns:
            return
        excuse_delay(what, limit_ns, delay, host)
    raise SpoiltByHostError(f"{what}: {ATTEMPTS} attempts, each disturbed")


def excuse_delay(what: str, limit_ns: int, delay: Delay, host: HostWatch) -> None:
    """Too long, or with an effect that was there before its cause: the host's doing, said aloud, or a failure."""
    if delay.ns > limit_ns:
        still_ns, enough_ns = host.stood_still_ns(delay.cause_ns, delay.effect_ns), delay.ns - limit_ns
    else:
        still_ns, enough_ns = host.stood_still_ns(delay.effect_ns - BEFORE_NS, delay.cause_ns), STALL_NS
    sentence = f"{what} took {delay.ns * 1e-6:.2f} ms; the host stood still for {still_ns * 1e-6:.2f} ms"
    if still_ns < enough_ns:
        pytest.fail(sentence)
    print(f"disturbed: {sentence}")
