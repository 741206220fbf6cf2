"""Lockout at power-up, silence of the vehicle, a bus that goes down: what the drive does, and in which order.

Its timeouts are seconds here. That it keeps the shipped ones to a control period is claimed in virtual time
(tests/virtual_time/command_campaign_test.cpp, rows 2 and 18), and measured on the live drive by scripts/bench.
"""

import time
from collections.abc import Callable, Iterator

import numpy as np
import pytest
from drive_process import DriveProcess
from handling import (
    COMMAND_LOST,
    ENOUGH,
    PATIENCE_S,
    TORQUE_STEP_NM,
    at_torque,
    bring_up,
    check_excusable,
    is_reference,
    state,
    until,
    untripped,
)
from network_interface import set_up
from sextant_py import bus
from telemetry_record import Span, TelemetryRecord
from vehicle import Vehicle

TORQUE_NM = 20.0
NO_TORQUE_NM = 5.0  # the chatter of the comparators about a reference of zero
COMMAND_LOST_BIT = 1 << COMMAND_LOST
ZERO_FOR_LONG = ("command.timeout_ms=1000", "command.lost_ms=60000")  # a silence that heals
SOON_LOST = ("command.timeout_ms=1000", "command.lost_ms=4000")

Start = Callable[..., tuple[DriveProcess, TelemetryRecord]]


@pytest.fixture
def start(live_bus: str, domain: int, start_drive: Callable[..., DriveProcess]) -> Start:
    """start(key=value…): a drive at 10 rad/s and the record of what it publishes."""

    def running(*settings: str) -> tuple[DriveProcess, TelemetryRecord]:
        drive = start_drive(live_bus, "load.kind=imposed_speed", "load.speed_rad_s.value=10", *settings)
        return drive, TelemetryRecord(domain)

    return running


def at_zero(record: TelemetryRecord, silence: Callable[[], None]) -> Span:
    """What is published from the torque to none, once a drive in TORQUE hears nothing any more."""
    first = len(record.samples) - 1
    silence()
    span = until(
        record, lambda found: np.sum(found.torque_reference_nm == 0) >= ENOUGH, "no torque in a silence", first
    )
    # Not what came later: a test that was kept from looking may find the fault that follows.
    return Span(span.samples[: np.flatnonzero(span.torque_reference_nm == 0)[ENOUGH - 1] + 1])


def healed(
    record: TelemetryRecord, vehicle: Vehicle, silence: Callable[[], None], comes_back: Callable[[], None]
) -> Span:
    """The same, and then the torque comes back by itself, without a fault."""

    def both() -> Span:
        try:
            span = at_zero(record, silence)
        finally:
            comes_back()
        record.wait(lambda own: is_reference(own, TORQUE_NM) or state(own) == "FAULT", "the torque after a silence")
        return span

    return untripped(record, lambda: at_torque(record, vehicle, TORQUE_NM, 0.1), both)


def check_wound_down(span: Span) -> None:
    """From the whole torque to none, never up, by the ramp and not by a fault."""
    reference_nm = span.torque_reference_nm
    assert reference_nm[0] == pytest.approx(TORQUE_NM, abs=TORQUE_STEP_NM)
    assert np.all(np.diff(reference_nm) <= 0)
    gone = reference_nm == 0
    assert np.abs(np.median(span.where(gone).torque_mean_nm)) <= NO_TORQUE_NM
    assert set(span.states) == {"TORQUE"}
    # In what is past its time no command is new.
    assert len(set(span.where(gone).command_received_ns)) == 1


def test_short_silence_heals(start: Start, live_bus: str) -> None:
    _, record = start(*ZERO_FOR_LONG)
    with Vehicle(live_bus) as vehicle:
        for _ in range(2):
            span = healed(record, vehicle, vehicle.fall_silent, lambda: vehicle.demand(TORQUE_NM, enable=True))
            check_wound_down(span)


def test_long_silence_latches_and_the_way_back(start: Start, live_bus: str) -> None:
    _, record = start(*SOON_LOST)
    with Vehicle(live_bus) as vehicle:
        check_wound_down(lost(record, vehicle, vehicle.fall_silent, vehicle.demand))
        check_loss(record)
        check_way_back(record, vehicle)


def lost(record: TelemetryRecord, vehicle: Vehicle, silence: Callable[[], None], speech: Callable[[], None]) -> Span:
    """What is published from the torque to none; the drive is in FAULT then for the lost command alone."""

    def prepare() -> None:
        speech()
        at_torque(record, vehicle, TORQUE_NM, 0.1)

    end_s = time.monotonic() + PATIENCE_S
    while time.monotonic() < end_s:
        span = untripped(record, prepare, lambda: at_zero(record, silence))
        record.wait_for_state("FAULT")
        record.wait(lambda own: own.states[-1].first_fault >= 0, "the reason of the FAULT")
        if record.states[-1].faults_latched == COMMAND_LOST_BIT:
            return span
        check_excusable(record)
    raise pytest.fail.Exception(f"it was never the lost command alone: {record.last_words()}")


def check_loss(record: TelemetryRecord) -> None:
    """With the fault the gates are off and stay so."""
    record.run(0.1)
    span = record.run(0.1)
    assert set(span.states) == {"FAULT"}
    # The diodes have taken the current down, and nothing drives another.
    assert np.all(span.current_max_a < 0.1)
    told = record.states[-1]
    assert told.state.name == "FAULT"
    assert told.first_fault == COMMAND_LOST
    assert told.lockout


def check_way_back(record: TelemetryRecord, vehicle: Vehicle) -> None:
    """Reset, then disable, then enable; nothing else leads back."""
    stay_where_they_are(record, vehicle, "FAULT", enable=True)
    stay_where_they_are(record, vehicle, "FAULT", enable=False)

    def reset() -> None:
        vehicle.demand(fault_reset=True)
        record.wait_for_state("STANDBY")

    check_nothing_came(untripped(record, reset, lambda: from_standby(record, vehicle)), "STANDBY")
    record.wait(lambda own: own.states[-1].faults_latched == 0, "no fault any more")


def from_standby(record: TelemetryRecord, vehicle: Vehicle) -> Span:
    """What is published while an enable has no effect; then disable and enable, to the torque or a FAULT."""
    span = heard(record, vehicle, enable=True)
    vehicle.demand()
    record.wait(lambda own: state(own) in ("READY", "FAULT"), "READY after a disable")
    vehicle.demand(TORQUE_NM, enable=True)
    record.wait(lambda own: is_reference(own, TORQUE_NM) or state(own) == "FAULT", "the torque after the way back")
    return span


def heard(record: TelemetryRecord, vehicle: Vehicle, enable: bool) -> Span:
    """What is published once the drive has heard the demand."""
    received, _ = record.counted_commands()
    vehicle.demand(TORQUE_NM, enable=enable)
    record.wait(lambda own: own.counted_commands()[0] >= received + 10, "commands that the drive has heard")
    return record.run(0.1)


def check_nothing_came(span: Span, state: str) -> None:
    assert set(span.states) == {state}
    assert np.all(span.torque_reference_nm == 0)
    assert span.current_max_a.max() < 0.1


def stay_where_they_are(record: TelemetryRecord, vehicle: Vehicle, state: str, enable: bool) -> None:
    """The drive hears the demand, and nothing comes of it."""
    check_nothing_came(heard(record, vehicle, enable), state)


def test_enable_at_power_up_does_nothing(start: Start, live_bus: str) -> None:
    drive, record = start()
    with Vehicle(live_bus) as vehicle:
        record.wait_until_heard()
        vehicle.demand(TORQUE_NM, enable=True)
        record.wait(lambda own: own.counted_commands()[0] >= 50, "50 commands that the drive has heard")
        span = record.everything()
        assert record.counted_commands()[1] == 2  # they only make the E2E state VALID
        assert set(span.states) == {"STANDBY"}
        assert np.all(span.torque_reference_nm == 0)
        assert np.all(span.torque_max_nm == 0)
        assert np.all(span.current_max_a == 0)
        assert record.states[-1].lockout
        assert drive.is_running()
        # The same command is followed once a disable has been seen.
        bring_up(record, vehicle, TORQUE_NM)


@pytest.fixture
def interface(live_bus: str) -> Iterator[str]:
    if not live_bus.startswith("socketcan"):
        pytest.skip("only a CAN interface can be taken down; live.vcan does")
    name = bus.parse(live_bus).channel
    yield name
    set_up(name, True)


@pytest.mark.kernel_can
def test_an_interface_that_comes_back_heals(start: Start, live_bus: str, interface: str) -> None:
    drive, record = start(*ZERO_FOR_LONG)
    with Vehicle(live_bus) as vehicle:
        for _ in range(2):
            span = healed(record, vehicle, lambda: set_up(interface, False), lambda: set_up(interface, True))
            check_wound_down(span)
            assert drive.is_running(), drive.errors()


@pytest.mark.kernel_can
def test_an_interface_that_stays_away_trips_the_drive(start: Start, live_bus: str, interface: str) -> None:
    drive, record = start(*SOON_LOST)
    with Vehicle(live_bus) as vehicle:
        check_wound_down(
            lost(record, vehicle, lambda: set_up(interface, False), lambda: set_up(interface, True)),
        )
        check_loss(record)
        set_up(interface, True)
        check_way_back(record, vehicle)
        assert drive.is_running(), drive.errors()
