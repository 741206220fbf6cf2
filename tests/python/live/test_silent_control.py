"""A control thread that stands still while the rest of the drive runs on: the bus tells of a fault, not of torque."""

import time
from collections.abc import Callable

from drive_process import DriveProcess
from handling import at_torque, bring_up
from held_thread import HeldThread
from sextant_py import bus
from sextant_py.contract import Contract
from telemetry_record import TelemetryRecord
from vehicle import Vehicle

TORQUE_NM = 40.0
WATCHDOG_MS = 1000
ANSWER_S = 60.0  # nothing here is judged by time
STATUSES = 50
WATCHDOG = 18
MEASUREMENTS = {"MCU_Motion", "MCU_Electrical"}


class StatusFrames:
    """The drive's frames, decoded, in the order in which they come."""

    def __init__(self, address: str) -> None:
        self._contract = Contract()
        self._bus = bus.open_bus(bus.parse(address))

    def __enter__(self) -> "StatusFrames":
        return self

    def __exit__(self, *_: object) -> None:
        self._bus.shutdown()

    def next(self, name: str, seen: set[str] | None = None) -> dict:
        """The signals of the next message of this name; the names of all that came before go to `seen`."""
        deadline_s = time.monotonic() + ANSWER_S
        while time.monotonic() < deadline_s:
            frame = bus.receive(self._bus, 0.5)
            decoded = frame and self._contract.decode(frame)
            if decoded and seen is not None:
                seen.add(decoded[0])
            if decoded and decoded[0] == name:
                return decoded[1]
        raise AssertionError(f"no {name} for {ANSWER_S:g} s")

    def forget(self) -> None:
        """Drops what has piled up unread."""
        while bus.receive(self._bus, 0.0) is not None:
            pass


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
        assert status["TorqueAdmitted"] == 0
        assert status["Lockout"] == 1
    assert not seen & MEASUREMENTS
    faults = frames.next("MCU_Faults")
    assert faults["ActiveWatchdog"] == 1
    assert faults["LatchedWatchdog"] == 1
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
