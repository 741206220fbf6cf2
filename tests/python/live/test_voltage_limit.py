"""Beyond the voltage of machine and link no torque is announced, admitted or made; over-speed is a fault.

How much there is below and how it is delivered is claimed in simulation (tests/sim/voltage_limit_test.cpp).
"""

from collections.abc import Callable

import numpy as np
from drive_process import DriveProcess
from handling import FAULTS, make_ready
from kernel import native_kernel_only
from status_frames import StatusFrames
from telemetry_record import TelemetryRecord
from vehicle import Vehicle

TORQUE_NM = 20.0
BEYOND_THE_VOLTAGE_RAD_S = 150.0  # of 530 V and 1.1 Wb: it lasts up to 136
BEYOND_THE_TRIP_RAD_S = 170.0


def imposed(speed_rad_s: float) -> tuple[str, str]:
    return "load.kind=imposed_speed", f"load.speed_rad_s.value={speed_rad_s:g}"


def check_nothing_is_available(frames: StatusFrames) -> None:
    frames.forget()
    capability = frames.next("MCU_Capability")
    assert capability["TorqueMotoring"] == 0
    assert capability["TorqueRegenerating"] == 0


def test_beyond_the_voltage_there_is_no_torque(
    live_bus: str, domain: int, start_drive: Callable[..., DriveProcess]
) -> None:
    native_kernel_only()
    start_drive(live_bus, *imposed(BEYOND_THE_VOLTAGE_RAD_S))
    record = TelemetryRecord(domain)
    with Vehicle(live_bus) as vehicle, StatusFrames(live_bus) as frames:
        make_ready(record, vehicle)
        check_nothing_is_available(frames)
        vehicle.demand(TORQUE_NM, enable=True)
        record.wait(lambda own: own.samples[-1].torque_requested_nm > 0, "the request")
        span = record.run(0.3)
        assert set(span.states) == {"READY"}
        assert np.all(span.torque_reference_nm == 0)
        assert span.current_max_a.max() < 0.1
        check_nothing_is_available(frames)


def test_over_speed_is_a_fault(live_bus: str, domain: int, start_drive: Callable[..., DriveProcess]) -> None:
    native_kernel_only()
    start_drive(live_bus, *imposed(BEYOND_THE_TRIP_RAD_S))
    record = TelemetryRecord(domain)
    with StatusFrames(live_bus) as frames:
        record.wait_for_state("FAULT")
        record.wait(lambda own: own.states[-1].first_fault >= 0, "the reason of the FAULT")
        assert record.states[-1].first_fault == FAULTS["OVER_SPEED"]
        assert frames.next("MCU_FaultsActive")["ActiveOverSpeed"] == 1
        check_nothing_is_available(frames)
