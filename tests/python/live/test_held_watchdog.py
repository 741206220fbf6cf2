"""A watchdog thread that stands still while the rest of the drive runs on: the drive makes no torque without it."""

from collections.abc import Callable

from drive_process import DriveProcess
from handling import WATCHDOG, at_torque, bring_up
from held_thread import HeldThread
from status_frames import StatusFrames
from telemetry_record import TelemetryRecord
from vehicle import Vehicle

TORQUE_NM = 40.0
STATUSES = 50


def test_a_watchdog_that_stands_still_is_a_fault_until_it_runs_again(
    live_bus: str, domain: int, start_drive: Callable[..., DriveProcess]
) -> None:
    drive = start_drive(live_bus, "load.kind=imposed_speed")
    record = TelemetryRecord(domain)
    with Vehicle(live_bus) as vehicle, StatusFrames(live_bus) as frames:
        bring_up(record, vehicle, TORQUE_NM)
        with HeldThread(drive.pid, "sextant-wdog"):
            record.wait_for_state("FAULT")
            assert record.states[-1].faults_active & 1 << WATCHDOG
            assert record.states[-1].first_fault == WATCHDOG
            vehicle.demand(fault_reset=True)
            frames.forget()
            for _ in range(STATUSES):
                assert str(frames.next("MCU_TorqueStatus")["DriveState"]) == "FAULT", "a reset changes nothing"
            assert frames.next("MCU_FaultsActive")["ActiveWatchdog"] == 1
        at_torque(record, vehicle, TORQUE_NM)
    assert drive.errors().count("the watchdog thread has stopped") == 1
    assert drive.errors().count("the watchdog thread runs again") == 1


def test_a_housekeeping_thread_that_stands_still_is_logged(
    live_bus: str, domain: int, start_drive: Callable[..., DriveProcess]
) -> None:
    drive = start_drive(live_bus)
    record = TelemetryRecord(domain)
    record.wait_until_heard()
    with HeldThread(drive.pid, "sextant-house"):
        record.wait(lambda _: "the housekeeping thread has stopped" in drive.errors(), "the log")
    record.wait(lambda _: "the housekeeping thread runs again" in drive.errors(), "the log")
