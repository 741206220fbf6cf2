"""The CAN side of a drive, as far as a vehicle control unit sees it: status frames, lockout, E2E check of commands."""

import time

from background import Background
from frame_checker import Checker
from sextant_py import bus, e2e
from sextant_py.contract import Contract

COMMAND = "VCU_TorqueCommand"


class FakeDrive(Background):
    """Answers on a bus until it is closed; remembers every command it accepted or refused."""

    def __init__(
        self,
        address: str,
        fault_after: int | None = None,
        stubborn: bool = False,
        contract_major: int | None = None,
        identifier_offset: int = 0,
    ) -> None:
        self.accepted: list[tuple[float, dict]] = []
        self.refused = 0
        self.state = "STANDBY"
        self.available_nm = 150.0
        self.faults: tuple[str, ...] = ()  # reported as latched; the first one also as active
        self._fault_after = fault_after
        self._stubborn = stubborn
        self._contract = Contract(identifier_offset=identifier_offset)
        self._contract_major = self._contract.version()[0] if contract_major is None else contract_major
        self._checker = Checker(self._contract.data_id(COMMAND))
        self._bus = bus.open_bus(bus.parse(address))
        super().__init__()

    def __exit__(self, *details: object) -> None:
        super().__exit__(*details)
        self._bus.shutdown()

    def never_faults(self) -> None:
        self._fault_after = None

    def _run(self) -> None:
        due, counter = time.monotonic(), 0
        while not self._stop.is_set():
            frame = bus.receive(self._bus, max(due - time.monotonic(), 0))
            if frame is not None:
                self._take(frame)
            if time.monotonic() >= due:
                due += 0.01
                self._report(counter)
                counter = (counter + 1) % e2e.COUNTER_COUNT

    def _take(self, frame: object) -> None:
        decoded = self._contract.decode(frame)
        if decoded is None or decoded[0] != COMMAND:
            return
        if not self._checker.check(bytes(frame.data)).usable:
            self.refused += 1
            return
        command = decoded[1]
        self.accepted.append((time.monotonic(), command))
        enabled = str(command["Enable"]) == "ENABLE"
        if self.state == "FAULT":
            self.state = "STANDBY" if command["FaultReset"] else "FAULT"
        elif not enabled:
            self.state = "STANDBY" if self._stubborn else "READY"
        elif self.state == "READY":
            self.state = "TORQUE"
        running = [entry for entry in self.accepted if str(entry[1]["Enable"]) == "ENABLE"]
        if self._fault_after is not None and len(running) > self._fault_after:
            self.state = "FAULT"

    def _report(self, counter: int) -> None:
        last = self.accepted[-1][1] if self.accepted else {}
        torque = last.get("TorqueRequest", 0.0) if self.state == "TORQUE" else 0.0
        status = {
            "TorqueEstimated": torque,
            "TorqueReference": torque,
            "DriveState": self.state,
            "Lockout": int(self.state in ("STANDBY", "FAULT")),
            "CommandCounter": last.get("Counter", 15),
        }
        self._bus.send(self._contract.encode("MCU_TorqueStatus", status, counter))
        available = {"TorqueMotoring": self.available_nm, "TorqueRegenerating": self.available_nm / 2}
        self._bus.send(self._contract.encode("MCU_Capability", {**available, "DeratingCause": "NONE"}, counter))
        temperatures = {"StatorTemperature": 71.5, "RotorTemperature": 90.0}
        temperatures["InverterTemperature"] = "NOT_AVAILABLE"
        self._bus.send(self._contract.encode("MCU_Temperatures", temperatures, counter))
        if self.faults:
            self._report_faults(counter)
        identification = {"ContractMajor": self._contract_major, "ContractMinor": 0}
        identification |= {"SoftwareMajor": 0, "SoftwareMinor": 1, "SoftwarePatch": 0}
        self._bus.send(self._contract.encode("MCU_Identification", identification, counter))

    def _report_faults(self, counter: int) -> None:
        first = {"FirstFault": self.faults[0], "FaultTotal": len(self.faults)}
        self._bus.send(self._contract.encode("MCU_Faults", first, counter))
        for message, present in (("MCU_FaultsActive", self.faults[:1]), ("MCU_FaultsLatched", self.faults)):
            signals = self._contract.message(message).signals
            values = {signal.name: 0 for signal in signals if signal.name not in Contract.PROTECTION_SIGNALS}
            prefix = message.removeprefix("MCU_Faults")
            values |= {prefix + name.title().replace("_", ""): 1 for name in present}
            self._bus.send(self._contract.encode(message, values, counter))
