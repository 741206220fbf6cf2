"""The vehicle's side of the bus: commands every 10 ms, and frames that no honest vehicle sends."""

import sys
import threading
from collections.abc import Callable
from dataclasses import dataclass

import can
from sextant_py import bus, e2e
from sextant_py.contract import Contract
from sextant_py.vcu import COMMAND, Commander

PERIOD_S = 0.01
TORQUE_LIMIT_NM = 150.0


@dataclass(frozen=True)
class Demand:
    torque_nm: float = 0.0
    enable: bool = False
    fault_reset: bool = False


class Vehicle:
    """Repeats its demand every 10 ms from a thread of its own until the demand is None; a context."""

    def __init__(self, address: str) -> None:
        self.contract = Contract()
        self._bus = open_fd_bus(address)
        self._commander = Commander(self._bus, self.contract, PERIOD_S, TORQUE_LIMIT_NM)
        self._demand: Demand | None = None
        self._extra: Callable[[int], can.Message] | None = None
        self._extra_sent = threading.Event()
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="vehicle", daemon=True)

    def __enter__(self) -> "Vehicle":
        # A frame takes several turns of the interpreter's lock; each may cost what the other thread may hold it.
        sys.setswitchinterval(0.001)
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stop.set()
        self._thread.join()
        self._bus.shutdown()

    def _run(self) -> None:
        while not self._stop.is_set():
            self._commander.wait()
            demand, extra = self._demand, self._extra
            if demand is None:
                continue
            self._commander.send(demand.torque_nm, demand.enable, demand.fault_reset)
            if extra is not None:
                self._extra = None
                self._bus.send(extra(self._commander.sent[-1][3]))
                self._extra_sent.set()

    def demand(self, torque_nm: float = 0.0, enable: bool = False, fault_reset: bool = False) -> None:
        self._demand = Demand(torque_nm, enable, fault_reset)

    def fall_silent(self) -> None:
        self._demand = None

    def slip_in(self, make: Callable[[int], can.Message]) -> None:
        """Sends one more frame right after a command; `make` is given that command's counter."""
        self._extra_sent.clear()
        self._extra = make
        if not self._extra_sent.wait(2.0):
            raise TimeoutError("the vehicle did not send the extra frame")

    def forged(self, torque_nm: float, counter: int) -> can.Message:
        """An enabling command that the drive would follow if it took it."""
        signals = {"TorqueRequest": torque_nm, "TorqueLimit": TORQUE_LIMIT_NM, "Enable": 1, "FaultReset": 0}
        return self.contract.encode(COMMAND, signals, counter % e2e.COUNTER_COUNT)


def open_fd_bus(address: str) -> can.BusABC:
    """A bus that also sends CAN FD frames."""
    parsed = bus.parse(address)
    if parsed.interface == "socketcan":
        return can.Bus(interface="socketcan", channel=parsed.channel, fd=True, ignore_config=True)
    return bus.open_bus(parsed)
