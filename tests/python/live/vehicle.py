"""The vehicle's side of the bus: commands every 10 ms, and frames that no honest vehicle sends."""

import json
import socket
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import can
from can.interfaces.socketcan.socketcan import build_can_frame
from can.interfaces.udp_multicast.utils import pack_message
from sextant_py import bus, e2e
from sextant_py.commander import COMMAND
from sextant_py.contract import Contract

SENDER = Path(__file__).with_name("vehicle_sender.py")
TORQUE_LIMIT_NM = 150.0
ANSWER_S = 60.0  # nothing is judged by time


class Vehicle:
    """Repeats its demand every 10 ms from a process of its own until it falls silent; a context."""

    def __init__(self, address: str, identifier_offset: int = 0) -> None:
        self.contract = Contract(identifier_offset=identifier_offset)
        self._address = bus.parse(address)
        self._pack = build_can_frame if self._address.interface == "socketcan" else pack_message
        self._control: socket.socket | None = None
        self._process: subprocess.Popen | None = None

    def __enter__(self) -> "Vehicle":
        self._control, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._control.settimeout(ANSWER_S)
        address = (self._address.interface, self._address.channel, str(self._address.port))
        with theirs:
            command = [sys.executable, "-I", "-S", SENDER, str(theirs.fileno()), *address]
            self._process = subprocess.Popen(command, stdin=subprocess.DEVNULL, pass_fds=[theirs.fileno()])
        return self

    def __exit__(self, *_: object) -> None:
        try:
            self._order(end=True)
            log = self._answer()
            print(
                f"vehicle: {log['sent']} commands, at most {log['apart_ms']:.1f} ms apart,"
                f" {log['missed']} periods missed, {log['unsent']} not sent"
            )
        finally:
            self._control.close()
            try:
                self._process.wait(ANSWER_S)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()

    def _order(self, **order: Any) -> None:
        self._control.send(json.dumps(order).encode())

    def _answer(self) -> dict[str, Any]:
        return json.loads(self._control.recv(65536))

    def _packed(self, make: Callable[[int], can.Message]) -> list[str]:
        """One frame for each value of the counter, as the bus takes it."""
        return [self._pack(make(counter)).hex() for counter in range(e2e.COUNTER_COUNT)]

    def _command(self, torque_nm: float, enable: bool, fault_reset: bool, counter: int) -> can.Message:
        signals = {
            "TorqueRequest": torque_nm,
            "TorqueLimit": TORQUE_LIMIT_NM,
            "Enable": int(enable),
            "FaultReset": int(fault_reset),
        }
        return self.contract.encode(COMMAND, signals, counter % e2e.COUNTER_COUNT)

    def demand(self, torque_nm: float = 0.0, enable: bool = False, fault_reset: bool = False) -> None:
        self._order(demand=self._packed(lambda counter: self._command(torque_nm, enable, fault_reset, counter)))

    def fall_silent(self) -> None:
        self._order(demand=None)

    def slip_in(self, make: Callable[[int], can.Message]) -> None:
        """Sends one more frame right after a command; `make` is given that command's counter."""
        self._order(extra=self._packed(make))
        self._answer()

    def forged(self, torque_nm: float, counter: int) -> can.Message:
        """An enabling command that the drive would follow if it took it."""
        return self._command(torque_nm, True, False, counter)
