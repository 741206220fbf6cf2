"""Two drives, each on a bus of its own, in one DDS domain: drive_id tells them apart."""

from collections.abc import Callable

import pytest
from drive_process import DriveProcess
from handling import bring_up
from kernel import native_kernel_only
from telemetry_record import TelemetryRecord
from vehicle import Vehicle


def test_two_drives_in_one_domain(
    live_bus: str, other_bus: str, domain: int, start_drive: Callable[..., DriveProcess]
) -> None:
    native_kernel_only()
    start_drive(live_bus, "drive_id=1")
    start_drive(other_bus, "drive_id=7", "load.kind=imposed_speed", "load.speed_rad_s.value=20")
    first, second = TelemetryRecord(domain, 1), TelemetryRecord(domain, 7)
    with Vehicle(other_bus) as vehicle:
        first.wait_until_heard()
        bring_up(second, vehicle, 15.0)
        second.run(0.1)
        begin = len(first.samples)
        span = second.run(0.3)
        first.poll()
    assert set(span.drive_id) == {7}
    assert span.torque_mean_nm.mean() == pytest.approx(15.0, abs=1.5)
    assert span.speed_rad_s == pytest.approx(20.0, abs=0.1)
    idle = first.everything()
    assert len(idle) > begin
    assert set(idle.drive_id) == {1}
    assert set(idle.states) == {"STANDBY"}
    assert idle.speed_rad_s == pytest.approx(0.0, abs=1e-6)
