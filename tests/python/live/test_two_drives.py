"""Two drives: in one DDS domain drive_id tells them apart, on one bus can.identifier_offset."""

from collections.abc import Callable

import numpy as np
import pytest
from drive_process import DriveProcess
from handling import FAULTS, at_torque, bring_up, make_ready
from kernel import native_kernel_only
from telemetry_record import TelemetryRecord
from vehicle import Vehicle

SECOND_MASTER_BIT = 1 << FAULTS["SECOND_MASTER"]


def test_a_second_drive_on_the_bus_makes_no_torque(
    live_bus: str, domain: int, start_drive: Callable[..., DriveProcess]
) -> None:
    """Of two drives with the same identifiers."""
    native_kernel_only()
    start_drive(live_bus, "drive_id=1")
    record = TelemetryRecord(domain, 1)
    with Vehicle(live_bus) as vehicle:
        bring_up(record, vehicle, 15.0)
        second = start_drive(live_bus, "drive_id=7")
        record.wait(
            lambda own: second.status is not None or own.states[-1].faults_latched & SECOND_MASTER_BIT,
            "either drive's objection",
        )
        if second.status is None:  # it has listened while the first one stood still: now both object
            TelemetryRecord(domain, 7).wait(
                lambda own: own.states and own.states[-1].faults_latched & SECOND_MASTER_BIT, "the second one's"
            )
            return
        assert second.status == 2
        assert f"another drive sends MCU_TorqueStatus on {live_bus}" in second.errors()
        at_torque(record, vehicle, 15.0)


def test_two_drives_on_one_bus_each_follow_their_own_commands(
    live_bus: str, domain: int, start_drive: Callable[..., DriveProcess]
) -> None:
    native_kernel_only()
    offset = 96
    start_drive(live_bus, "drive_id=1")
    start_drive(live_bus, "drive_id=7", f"can.identifier_offset={offset}")
    first, second = TelemetryRecord(domain, 1), TelemetryRecord(domain, 7)
    with Vehicle(live_bus) as own, Vehicle(live_bus, offset) as other:
        bring_up(first, own, 15.0)
        make_ready(second, other)
        # One under torque while the other, which hears the same bus, has no enable.
        at_torque(first, own, 15.0)
        assert set(second.run(0.1).states) == {"READY"}
        # Both at once, each at its own torque.
        assert np.median(at_torque(second, other, -12.0).torque_mean_nm) == pytest.approx(-12.0, abs=5.0)
        span = at_torque(first, own, 15.0)
    assert np.median(span.torque_mean_nm) == pytest.approx(15.0, abs=5.0)
    for record in (first, second):
        assert not any(state.faults_latched & SECOND_MASTER_BIT for state in record.states)


def test_two_drives_in_one_domain(
    live_bus: str, other_bus: str, domain: int, start_drive: Callable[..., DriveProcess]
) -> None:
    native_kernel_only()
    start_drive(live_bus, "drive_id=1")
    start_drive(other_bus, "drive_id=7", "load.kind=imposed_speed", "load.speed_rad_s.value=20")
    first, second = TelemetryRecord(domain, 1), TelemetryRecord(domain, 7)
    with Vehicle(other_bus) as vehicle:
        first.wait_until_heard()
        second.wait_until_heard()
        begin = len(first.samples)
        span = at_torque(second, vehicle, 15.0)
        first.wait(lambda own: len(own.samples) > begin, "the first drive beside the second")
    assert set(span.drive_id) == {7}
    assert np.median(span.torque_mean_nm) == pytest.approx(15.0, abs=5.0)
    assert span.speed_rad_s == pytest.approx(20.0, abs=0.1)
    idle = first.everything()
    assert set(idle.drive_id) == {1}
    assert set(idle.states) == {"STANDBY"}
    assert idle.speed_rad_s == pytest.approx(0.0, abs=1e-6)
