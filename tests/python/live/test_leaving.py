"""SIGTERM and SIGINT: torque to zero, gates off, exit status 0.

How long the ramp takes is claimed in virtual time (tests/virtual_time), how soon the process is gone by scripts/bench.
"""

import signal
from collections.abc import Callable

import numpy as np
import pytest
from drive_process import DriveProcess
from handling import at_torque
from telemetry_record import Span, TelemetryRecord
from vehicle import Vehicle

TORQUE_NM = 20.0


@pytest.mark.parametrize("how", [signal.SIGTERM, signal.SIGINT])
def test_leaves_in_good_order(
    how: signal.Signals, live_bus: str, domain: int, start_drive: Callable[..., DriveProcess]
) -> None:
    record = TelemetryRecord(domain)
    drive = start_drive(live_bus, "load.kind=imposed_speed", "load.speed_rad_s.value=10")
    with Vehicle(live_bus) as vehicle:
        running = at_torque(record, vehicle, TORQUE_NM)
        assert np.median(running.torque_mean_nm) == pytest.approx(TORQUE_NM, abs=5.0)
        begin = len(record.samples)
        status = drive.leave(how)
    assert status == 0, drive.errors()
    record.wait(lambda own: own.states[-1].state.name == "SHUTDOWN", "the last DriveState")
    check_end(record, Span(record.samples[begin - 1 :]))


def check_end(record: TelemetryRecord, span: Span) -> None:
    """The torque ramps to zero and never back, the gates turn off, and the last word is SHUTDOWN, without a fault.

    DriveTelemetry is best effort: what is heard of it holds, its last samples may be lost.
    """
    assert np.all(np.diff(span.torque_reference_nm) <= 0)
    assert set(span.states) <= {"TORQUE", "SHUTDOWN"}
    shut_down = np.array([state == "SHUTDOWN" for state in span.states])
    assert np.all(np.diff(shut_down.astype(int)) >= 0)
    assert np.all(span.torque_reference_nm[shut_down] == 0)
    assert record.states[-1].faults_latched == 0
