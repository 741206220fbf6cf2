"""Lockout at power-up, silence of the vehicle, a bus that goes down: what the drive does, by its own stamps."""

import time
from collections.abc import Callable

import numpy as np
import pytest
from attempts import silence_spoilt, undisturbed
from drive_process import DriveProcess
from handling import bring_up, regain
from network_interface import set_up
from sextant_py import bus
from telemetry_record import Span, TelemetryRecord
from vehicle import Vehicle

TORQUE_NM = 20.0
TELEMETRY_HZ = 500  # in a guest: 60 ms are judged
ZERO_S = 0.060
LOST_S = 0.200
NO_TORQUE_NM = 2.0  # mean over 1 ms at low speed: the chatter of the comparators about a reference of zero
COMMAND_LOST = 0
COMMAND_LOST_BIT = 1 << COMMAND_LOST


@pytest.fixture
def running(
    live_bus: str, domain: int, start_drive: Callable[..., DriveProcess]
) -> tuple[DriveProcess, TelemetryRecord]:
    """A drive at 10 rad/s and the record of what it publishes."""
    drive = start_drive(live_bus, "load.kind=imposed_speed", "load.speed_rad_s.value=10", telemetry_hz=TELEMETRY_HZ)
    return drive, TelemetryRecord(domain)


def after_last_command(span: Span) -> Span:
    """The samples in which the newest of all commands was in force."""
    return span.where(span.command_received_ns == span.command_received_ns.max())


def ages_ms(span: Span) -> np.ndarray:
    return (span.t_ns - span.command_received_ns) * 1e-6


def check_wound_down(span: Span) -> float:
    """No torque from 60 ms of age on; returns the age at which it was gone [ms]."""
    ages = ages_ms(span)
    gone = (span.torque_reference_nm == 0) & (np.abs(span.torque_mean_nm) <= NO_TORQUE_NM)
    assert gone.any()
    at_ms = float(ages[int(np.argmax(gone))])
    assert np.all(span.torque_reference_nm[ages > ZERO_S * 1e3] == 0)
    assert np.all(np.abs(span.torque_mean_nm[ages > ZERO_S * 1e3]) <= NO_TORQUE_NM)
    assert at_ms <= ZERO_S * 1e3
    # Not before the timeout either: one or two frames lost do nothing.
    assert np.all(span.torque_reference_nm[ages < 38] == pytest.approx(TORQUE_NM, abs=0.006))
    return at_ms


def silence(record: TelemetryRecord, vehicle: Vehicle) -> Span:
    begin = len(record.samples)
    record.run(0.05)
    vehicle.fall_silent()
    time.sleep(0.12)
    vehicle.demand(TORQUE_NM, enable=True)
    record.run(0.25)
    return Span(record.samples[begin:])


@pytest.mark.timing
def test_short_silence_heals(running: tuple[DriveProcess, TelemetryRecord], live_bus: str) -> None:
    _, record = running
    with Vehicle(live_bus) as vehicle:
        bring_up(record, vehicle, TORQUE_NM)
        record.run(0.3)
        for _ in range(5):
            span = undisturbed(
                "short silence",
                lambda: silence(record, vehicle),
                lambda found: silence_spoilt(found, LOST_S * 1e9),
                lambda: regain(record, vehicle, TORQUE_NM),
            )
            silent = longest_silence(span)
            silence_ms = ages_ms(silent).max()
            gone_ms = check_wound_down(silent)
            print(f"silent for {silence_ms:.0f} ms: no torque after {gone_ms:.1f} ms")
            assert ZERO_S * 1e3 < silence_ms < LOST_S * 1e3
            assert "FAULT" not in span.states
            assert span.torque_reference_nm[-1] == pytest.approx(TORQUE_NM, abs=0.006)
            assert span.last(0.05).torque_mean_nm.mean() == pytest.approx(TORQUE_NM, abs=1.5)


def lasting_silence(record: TelemetryRecord, vehicle: Vehicle) -> Span:
    begin = len(record.samples)
    vehicle.fall_silent()
    record.wait_for_state("FAULT")
    record.run(0.2)
    return Span(record.samples[begin:])


@pytest.mark.timing
def test_long_silence_latches_and_the_way_back(running: tuple[DriveProcess, TelemetryRecord], live_bus: str) -> None:
    _, record = running
    with Vehicle(live_bus) as vehicle:
        bring_up(record, vehicle, TORQUE_NM)
        record.run(0.3)
        span = undisturbed(
            "long silence",
            lambda: lasting_silence(record, vehicle),
            lambda found: silence_spoilt(found, wanted=0),
            lambda: regain(record, vehicle, TORQUE_NM),
        )
        check_loss(span)
        check_latched(record)
        check_way_back(record, vehicle)


def check_loss(span: Span) -> None:
    silent = after_last_command(span)
    gone_ms = check_wound_down(silent)
    ages, states = ages_ms(silent), np.array(silent.states)
    lost_ms = float(ages[int(np.argmax(states == "FAULT"))])
    print(f"silent for good: no torque after {gone_ms:.1f} ms, FAULT after {lost_ms:.1f} ms")
    assert lost_ms >= LOST_S * 1e3
    assert np.all(states[ages > LOST_S * 1e3 + 5] == "FAULT")
    assert set(states[ages < LOST_S * 1e3 - 2]) == {"TORQUE"}
    # Gates off: the diodes take the current down, and nothing drives another.
    assert np.all(silent.current_max_a[ages > LOST_S * 1e3 + 50] < 0.1)


def check_latched(record: TelemetryRecord) -> None:
    state = record.states[-1]
    assert state.state.name == "FAULT"
    assert state.first_fault == COMMAND_LOST
    assert state.faults_latched == COMMAND_LOST_BIT
    assert state.lockout


def check_way_back(record: TelemetryRecord, vehicle: Vehicle) -> None:
    """Reset, then disable, then enable; nothing else leads back."""
    stay_where_they_are(record, vehicle, "FAULT", enable=True)
    stay_where_they_are(record, vehicle, "FAULT", enable=False)
    vehicle.demand(fault_reset=True)
    record.wait_for_state("STANDBY")
    stay_where_they_are(record, vehicle, "STANDBY", enable=True)
    vehicle.demand()
    record.wait_for_state("READY")
    vehicle.demand(TORQUE_NM, enable=True)
    record.wait_for_state("TORQUE")
    record.run(0.05)
    assert record.run(0.2).torque_mean_nm.mean() == pytest.approx(TORQUE_NM, abs=1.5)
    assert record.states[-1].faults_latched == 0


def stay_where_they_are(record: TelemetryRecord, vehicle: Vehicle, state: str, enable: bool) -> None:
    vehicle.demand(TORQUE_NM, enable=enable)
    record.run(0.05)
    span = record.run(0.2)
    assert set(span.states) == {state}
    assert np.all(span.torque_reference_nm == 0)
    assert span.current_max_a.max() < 0.1


def test_enable_at_power_up_does_nothing(running: tuple[DriveProcess, TelemetryRecord], live_bus: str) -> None:
    drive, record = running
    with Vehicle(live_bus) as vehicle:
        record.wait_until_heard()
        vehicle.demand(TORQUE_NM, enable=True)
        record.run(1.0)
        span = record.everything()
        received, rejected = record.counted_commands()
        assert received >= 50
        assert rejected == 0
        assert set(span.states) == {"STANDBY"}
        assert np.all(span.torque_reference_nm == 0)
        assert np.all(span.torque_max_nm == 0)
        assert np.all(span.current_max_a == 0)
        assert record.states[-1].lockout
        assert drive.is_running()
        # The same command is followed once a disable has been seen.
        bring_up(record, vehicle, TORQUE_NM)


def interrupted(record: TelemetryRecord, address: str, down_s: float) -> Span:
    begin = len(record.samples)
    interface = bus.parse(address).channel
    set_up(interface, False)
    time.sleep(down_s)
    set_up(interface, True)
    record.run(0.3)
    return Span(record.samples[begin:])


@pytest.mark.timing
def test_interface_down_and_up(running: tuple[DriveProcess, TelemetryRecord], live_bus: str) -> None:
    if not live_bus.startswith("socketcan"):
        pytest.skip("only a CAN interface can be taken down")
    drive, record = running
    with Vehicle(live_bus) as vehicle:
        bring_up(record, vehicle, TORQUE_NM)
        for down_s in (0.08, 0.5, 0.08, 0.5):
            record.run(0.2)
            span = undisturbed(
                f"down for {down_s:g} s",
                lambda down_s=down_s: interrupted(record, live_bus, down_s),
                lambda found, down_s=down_s: silence_spoilt(found, LOST_S * 1e9 if down_s < LOST_S else None),
                lambda: regain(record, vehicle, TORQUE_NM),
            )
            if not drive.is_running():
                pytest.fail(f"the drive ended: {drive.errors()}")
            if down_s > LOST_S:
                check_loss(until_silence_ends(span))
                check_latched(record)
                vehicle.demand(fault_reset=True)
                record.wait_for_state("STANDBY")
                bring_up(record, vehicle, TORQUE_NM)
            else:
                check_wound_down(longest_silence(span))
                assert "FAULT" not in span.states
                assert span.torque_reference_nm[-1] == pytest.approx(TORQUE_NM, abs=0.006)


def longest_silence(span: Span) -> Span:
    times_ns = span.command_times_ns()
    return span.where(span.command_received_ns == times_ns[int(np.argmax(np.diff(times_ns)))])


def until_silence_ends(span: Span) -> Span:
    """Without the commands that came after the silence."""
    return span.where(span.command_received_ns <= longest_silence(span).command_received_ns[0])
