"""What a drive reports over CAN."""

import threading
import time
from dataclasses import dataclass, field

import can

from . import bus as can_bus
from . import e2e
from .commander import COMMAND
from .contract import Contract

STATUS = "MCU_TorqueStatus"
IDENTIFICATION = "MCU_Identification"
STANDING_STATES = ("READY",)
RUNNING_STATES = ("MAGNETISING", "TORQUE", "DERATED")
FOLLOWING_STATES = ("TORQUE", "DERATED")  # in which the torque answers to the request
STATUS_TIMEOUT_S = 0.5


@dataclass
class Reports:
    """What the drive has reported, kept up by a thread of its own."""

    bus: can.BusABC
    contract: Contract
    latest: dict[str, dict] = field(default_factory=dict)
    refused: int = 0
    _periods_without_status: int = 0
    _stop: threading.Event = field(default_factory=threading.Event)
    _thread: threading.Thread | None = None

    def start(self) -> None:
        self._thread = threading.Thread(target=self._receive, name="reports", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        self._stop.set()
        if self._thread:
            self._thread.join(1.0)

    def _receive(self) -> None:
        while not self._stop.is_set():
            try:
                frame = can_bus.receive(self.bus, 0.1)
            except (can.CanError, OSError):
                time.sleep(0.1)
                continue
            if frame is not None:
                self.accept(frame)

    def accept(self, frame: can.Message) -> None:
        decoded = self.contract.decode(frame)
        if decoded is None or decoded[0] == COMMAND:
            return
        name, signals = decoded
        data_id = self.contract.data_id(name)
        if data_id is not None and not e2e.is_valid(bytes(frame.data), data_id):
            self.refused += 1
            return
        self.latest[name] = signals
        if name == STATUS:
            self._periods_without_status = 0

    def state(self) -> str | None:
        status = self.latest.get(STATUS)
        return str(status["DriveState"]) if status else None

    def ready(self) -> bool:
        status = self.latest.get(STATUS)
        return bool(status) and not status["Lockout"] and self.state() in STANDING_STATES

    def timed_out(self, period_s: float) -> bool:
        """Whether no status has come for STATUS_TIMEOUT_S; called once a period. Counted in periods in which this
        program ran: time in which the machine stood still does not count."""
        self._periods_without_status += 1
        return STATUS not in self.latest or self._periods_without_status * period_s > STATUS_TIMEOUT_S

    def other_contract(self) -> str | None:
        """What is wrong where the drive has said that its frames mean something else; None otherwise."""
        said = self.latest.get(IDENTIFICATION)
        if said is None or said["ContractMajor"] == self.contract.version()[0]:
            return None
        theirs = f"{said['ContractMajor']}.{said['ContractMinor']}"
        ours = ".".join(map(str, self.contract.version()))
        return f"the drive speaks version {theirs} of the CAN contract, this program {ours}."

    def first_fault(self) -> str:
        return str(self.latest.get("MCU_Faults", {}).get("FirstFault", "no reason reported"))
