"""Frames that the drive must not follow: each changes a counter and nothing else."""

from collections.abc import Callable

import can
import numpy as np
import pytest
from drive_process import DriveProcess
from handling import at_torque, untripped
from sextant_py import e2e
from telemetry_record import Span, TelemetryRecord
from vehicle import Vehicle

TORQUE_NM = 12.0
FORGED_NM = 60.0
MORE = 20  # commands: more than the window of ten results over which errors are judged


def bad_crc(vehicle: Vehicle, counter: int) -> can.Message:
    frame = vehicle.forged(FORGED_NM, counter + 1)
    frame.data[0] ^= 0x01
    return frame


def repeated_counter(vehicle: Vehicle, counter: int) -> can.Message:
    return vehicle.forged(FORGED_NM, counter)


def counter_jump(vehicle: Vehicle, counter: int) -> can.Message:
    return vehicle.forged(FORGED_NM, counter + 8)


def invalid_counter(vehicle: Vehicle, counter: int) -> can.Message:
    frame = vehicle.forged(FORGED_NM, counter + 1)
    frame.data[1] |= 0x0F
    frame.data[0] = e2e.crc(bytes(frame.data), frame.arbitration_id)
    return frame


def wrong_data_id(vehicle: Vehicle, counter: int) -> can.Message:
    frame = vehicle.forged(FORGED_NM, counter + 1)
    e2e.protect(frame.data, 0x120, (counter + 1) % e2e.COUNTER_COUNT)
    return frame


def out_of_range(vehicle: Vehicle, counter: int) -> can.Message:
    """300 N·m, which the signal can hold and the contract does not allow."""
    frame = vehicle.forged(FORGED_NM, counter + 1)
    frame.data[2:4] = (30000).to_bytes(2, "little")
    e2e.protect(frame.data, frame.arbitration_id, (counter + 1) % e2e.COUNTER_COUNT)
    return frame


def seven_bytes(vehicle: Vehicle, counter: int) -> can.Message:
    frame = vehicle.forged(FORGED_NM, counter + 1)
    return can.Message(arbitration_id=frame.arbitration_id, is_extended_id=False, data=frame.data[:7])


def no_bytes(vehicle: Vehicle, counter: int) -> can.Message:
    frame = vehicle.forged(FORGED_NM, counter + 1)
    return can.Message(arbitration_id=frame.arbitration_id, is_extended_id=False, data=b"")


def remote_frame(vehicle: Vehicle, counter: int) -> can.Message:
    frame = vehicle.forged(FORGED_NM, counter + 1)
    return can.Message(arbitration_id=frame.arbitration_id, is_extended_id=False, is_remote_frame=True, dlc=8)


def extended_alias(vehicle: Vehicle, counter: int) -> can.Message:
    frame = vehicle.forged(FORGED_NM, counter + 1)
    return can.Message(arbitration_id=frame.arbitration_id, is_extended_id=True, data=frame.data)


def fd_alias(vehicle: Vehicle, counter: int) -> can.Message:
    frame = vehicle.forged(FORGED_NM, counter + 1)
    return can.Message(arbitration_id=frame.arbitration_id, is_extended_id=False, is_fd=True, data=frame.data)


FORGERIES = [
    bad_crc,
    repeated_counter,
    counter_jump,
    invalid_counter,
    wrong_data_id,
    out_of_range,
    seven_bytes,
    no_bytes,
    remote_frame,
    extended_alias,
    fd_alias,
]


@pytest.mark.kernel_can
def test_bad_frames_change_only_a_counter(live_bus: str, domain: int, start_drive: Callable[..., DriveProcess]) -> None:
    start_drive(live_bus, "load.kind=imposed_speed", "load.speed_rad_s.value=10")
    record = TelemetryRecord(domain)
    with Vehicle(live_bus) as vehicle:
        for forge in FORGERIES:
            check_forgery(record, vehicle, forge)
        # That the frames would have been followed, had they been good.
        at_torque(record, vehicle, FORGED_NM)


def slipped_in(
    record: TelemetryRecord, vehicle: Vehicle, forge: Callable[[Vehicle, int], can.Message]
) -> tuple[int, int, Span]:
    """Sends the frame; commands accepted and rejected until some more have been accepted, and the telemetry."""
    received, rejected = record.counted_commands()
    first = len(record.samples) - 1
    vehicle.slip_in(lambda counter: forge(vehicle, counter))
    record.wait(lambda own: own.counted_commands()[0] >= received + MORE, f"commands after {forge.__name__}")
    received_then, rejected_then = record.counted_commands()
    return received_then - received, rejected_then - rejected, Span(record.samples[first:])


def check_forgery(record: TelemetryRecord, vehicle: Vehicle, forge: Callable[[Vehicle, int], can.Message]) -> None:
    received, rejected, span = untripped(
        record, lambda: at_torque(record, vehicle, TORQUE_NM), lambda: slipped_in(record, vehicle, forge)
    )
    # Frames with a valid CRC move the counter: then the vehicle's next one jumps back or repeats it.
    expected = 2 if forge in (counter_jump, out_of_range) else 1
    assert rejected == expected, forge.__name__
    assert received >= MORE, forge.__name__
    assert set(span.states) == {"TORQUE"}, forge.__name__
    assert np.all(np.abs(span.torque_requested_nm - TORQUE_NM) < 0.006), forge.__name__
    assert np.all(np.abs(span.torque_reference_nm - TORQUE_NM) < 0.006), forge.__name__
    assert record.states[-1].faults_latched == 0
    assert record.states[-1].faults_active == 0
