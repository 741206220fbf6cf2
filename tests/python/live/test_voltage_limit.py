"""Beyond base speed what the voltage allows is announced and made, with its cause; over-speed is a fault.

How much there is and how it is delivered is claimed in simulation (tests/run/voltage_limit_test.cpp).
"""

from collections.abc import Callable

import numpy as np
from drive_process import DriveProcess
from handling import FAULTS, make_ready
from kernel import native_kernel_only
from status_frames import StatusFrames
from telemetry_record import TelemetryRecord
from vehicle import Vehicle

TORQUE_NM = 60.0
WEAKENED_RAD_S = 300.0  # 530 V and 1.1 Wb: the flux is weakened from 139
AVAILABLE_NM = 45.3  # there, when motoring; 140 when regenerating
BEYOND_THE_TRIP_RAD_S = 500.0


def imposed(speed_rad_s: float) -> tuple[str, str]:
    return "load.kind=imposed_speed", f"load.speed_rad_s.value={speed_rad_s:g}"


def capability(frames: StatusFrames) -> dict:
    frames.forget()
    return frames.next("MCU_Capability")


def test_beyond_base_speed_the_torque_is_limited_with_its_cause(
    live_bus: str, domain: int, start_drive: Callable[..., DriveProcess]
) -> None:
    native_kernel_only()
    start_drive(live_bus, *imposed(WEAKENED_RAD_S))
    record = TelemetryRecord(domain)
    with Vehicle(live_bus) as vehicle, StatusFrames(live_bus) as frames:
        make_ready(record, vehicle)
        ready = capability(frames)
        assert str(ready["DeratingCause"]) == "GATES_OFF"
        assert abs(ready["TorqueMotoring"] - AVAILABLE_NM) < 1
        vehicle.demand(TORQUE_NM, enable=True)
        record.wait_for_state("DERATED")
        record.run(0.2)  # the flux comes
        span = record.run(0.3)
        assert set(span.states) == {"DERATED"}
        assert np.median(np.abs(span.torque_reference_nm - AVAILABLE_NM)) < 1  # less for a moment after missed periods
        assert abs(span.torque_mean_nm.mean() - AVAILABLE_NM) < 4
        derated = capability(frames)
        assert str(derated["DeratingCause"]) == "VOLTAGE_LIMIT"
        assert abs(derated["TorqueMotoring"] - AVAILABLE_NM) < 1
        assert abs(derated["TorqueRegenerating"] - 140) < 2


def test_over_speed_is_a_fault(live_bus: str, domain: int, start_drive: Callable[..., DriveProcess]) -> None:
    native_kernel_only()
    start_drive(live_bus, *imposed(BEYOND_THE_TRIP_RAD_S))
    record = TelemetryRecord(domain)
    with StatusFrames(live_bus) as frames:
        record.wait_for_state("FAULT")
        record.wait(lambda own: own.states[-1].first_fault >= 0, "the reason of the FAULT")
        assert record.states[-1].first_fault == FAULTS["OVER_SPEED"]
        assert frames.next("MCU_FaultsActive")["ActiveOverSpeed"] == 1
        assert str(capability(frames)["DeratingCause"]) == "GATES_OFF"
