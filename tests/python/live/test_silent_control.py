"""A control thread that stands still while the rest of the drive runs on: the bus tells of a fault, not of torque."""

import time
from collections.abc import Callable

from drive_process import DriveProcess
from handling import WATCHDOG, at_torque, bring_up
from held_thread import HeldThread
from status_frames import ANSWER_S, StatusFrames
from telemetry_record import TelemetryRecord
from vehicle import Vehicle

TORQUE_NM = 40.0
WATCHDOG_MS = 1000
STATUSES = 50
MEASUREMENTS = {"MCU_Motion", "MCU_Electrical"}


def check_silent(frames: StatusFrames) -> None:
    """From the first frame that says so on every one tells of the fault."""
    end_s = time.monotonic() + ANSWER_S
    while str(frames.next("MCU_TorqueStatus")["DriveState"]) != "FAULT":
        assert time.monotonic() < end_s, f"no FAULT for {ANSWER_S:g} s"
    seen: set[str] = set()
    for _ in range(STATUSES):
        status = frames.next("MCU_TorqueStatus", seen)
        assert str(status["DriveState"]) == "FAULT"
        assert status["TorqueEstimated"] == 0
        assert status["TorqueReference"] == 0
        assert status["Lockout"] == 1
    assert not seen & MEASUREMENTS
    assert str(frames.next("MCU_Faults")["FirstFault"]) == "WATCHDOG"
    assert frames.next("MCU_FaultsActive")["ActiveWatchdog"] == 1
    assert frames.next("MCU_FaultsLatched")["LatchedWatchdog"] == 1
    capability = frames.next("MCU_Capability")
    assert capability["TorqueMotoring"] == 0
    assert capability["TorqueRegenerating"] == 0


def test_a_silent_control_thread_is_a_fault_on_the_bus(
    live_bus: str, domain: int, start_drive: Callable[..., DriveProcess]
) -> None:
    drive = start_drive(live_bus, f"realtime.watchdog_ms={WATCHDOG_MS}", "load.kind=imposed_speed")
    record = TelemetryRecord(domain)
    with Vehicle(live_bus) as vehicle, StatusFrames(live_bus) as frames:
        bring_up(record, vehicle, TORQUE_NM)
        record.run(0.2)
        with HeldThread(drive.pid, "sextant-control"):
            frames.forget()
            check_silent(frames)
            vehicle.demand()  # a disable changes nothing of what is true
            check_silent(frames)
        record.wait_for_state("FAULT")
        assert record.states[-1].faults_latched & 1 << WATCHDOG
        frames.forget()
        assert str(frames.next("MCU_TorqueStatus")["DriveState"]) == "FAULT", "what was said has become true"
        at_torque(record, vehicle, TORQUE_NM)
