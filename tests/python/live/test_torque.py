"""A torque command over CAN turns the motor, in all four quadrants.

How soon it does and how exactly is claimed in virtual time (tests/virtual_time/torque_step_test.cpp).
"""

from collections.abc import Callable

import numpy as np
import pytest
from drive_process import DriveProcess
from handling import TORQUE_STEP_NM, at_torque, bring_up
from kernel import native_kernel_only
from telemetry_record import TelemetryRecord
from vehicle import Vehicle

# Up and down in both directions of torque; at either direction of speed these are the four quadrants.
STEPS_NM = [15.0, 40.0, 15.0, -15.0, -40.0, -15.0, 15.0, 0.0]
NEAR_NM = 5.0  # this torque and none of the others
SLOW_RAD_S = 30.0


@pytest.mark.parametrize("speed_rad_s", [0.0, 30.0, -30.0, 100.0, -100.0])
def test_steps(speed_rad_s: float, live_bus: str, domain: int, start_drive: Callable[..., DriveProcess]) -> None:
    if abs(speed_rad_s) > SLOW_RAD_S:
        native_kernel_only()
    start_drive(live_bus, "load.kind=imposed_speed", f"load.speed_rad_s.value={speed_rad_s:g}")
    record = TelemetryRecord(domain)
    with Vehicle(live_bus) as vehicle:
        bring_up(record, vehicle, 0.0)
        for torque_nm in STEPS_NM:
            span = at_torque(record, vehicle, torque_nm, 0.2)
            # Half of the samples at least: those beside a gap of the machine's do not decide.
            found_nm = float(np.median(span.torque_mean_nm))
            print(f"{speed_rad_s:+5.0f} rad/s, {torque_nm:+4.0f} N·m: {found_nm:+6.2f} N·m, {len(span)} samples")
            assert span.speed_rad_s == pytest.approx(speed_rad_s, abs=0.1)
            assert np.all(np.abs(span.torque_requested_nm - torque_nm) < TORQUE_STEP_NM)
            assert np.all(np.abs(span.torque_reference_nm - torque_nm) < TORQUE_STEP_NM)
            assert found_nm == pytest.approx(torque_nm, abs=NEAR_NM)
