"""A vehicle control unit as a process of its own, which gets its demands from the dashboard.

It reads one JSON object a line from its standard input and writes a report a line to its standard output:
  {"torque_nm": 10, "enable": true, "fault_reset": false}   the demand; it holds for --demand-timeout
  {"spoil": "crc", "frames": 3}                             the next frames are wrong
  {"release": true}                                         disable frames, then none
  {"stop": true}                                            no further frame
  {"end": true}                                             disable frames where it commands, then the process ends
A "session" beside them is a number that the reports repeat. Without commands on the bus the drive ramps to zero torque
by its contract (docs/can.md). So the process stops sending where a demand is not repeated in time, and where its input
ends, as it does when the dashboard crashes.
"""

import argparse
import json
import queue
import sys
import threading
import time
from dataclasses import dataclass
from typing import Any

from ..control_unit import Vcu
from ..errors import UserError, run
from ..reports import RUNNING_STATES, STATUS

REPORT_PERIODS = 10


@dataclass
class Demand:
    torque_nm: float
    enable: bool
    fault_reset: bool
    received_s: float


class Unit:
    """Sends a command each period as long as the demand is renewed."""

    def __init__(self, vcu: Vcu, demand_timeout_s: float) -> None:
        self._vcu = vcu
        self._reports = vcu.reports
        self._demand_timeout_s = demand_timeout_s
        self._demand: Demand | None = None
        self._is_tripped = False  # enabled, and the drive left its running states: the page has to disable first
        self._was_running = False
        self._not_sending = "no page has demanded anything yet"
        self._session = 0

    def take(self, order: dict[str, Any]) -> bool:
        """Takes an order; False where it is the last one."""
        self._session = order.get("session", self._session)
        if "torque_nm" in order:
            new = Demand(order["torque_nm"], order["enable"], order["fault_reset"], time.monotonic())
            if not new.enable:
                self._is_tripped = False
            if not new.enable and self._demand is not None and self._demand.enable:
                self._vcu.spoil_none()
            self._demand = new
        elif "spoil" in order:
            self._vcu.spoil(order["spoil"], order["frames"])
        elif "stop" in order:
            self._stop_sending("the page that commanded is gone")
        else:
            if self._demand is not None:
                self._vcu.disable()
            self._stop_sending("the page that commanded has released the drive")
        return "end" not in order

    def _stop_sending(self, reason: str) -> None:
        self._vcu.spoil_none()
        self._demand, self._not_sending = None, reason
        self._was_running = self._is_tripped = False

    def step(self) -> None:
        self._vcu.wait()
        demand = self._demand
        if demand is None:
            return
        if time.monotonic() - demand.received_s > self._demand_timeout_s:
            self._stop_sending(f"the page sent no demand for {self._demand_timeout_s:g} s")
            return
        self._interlock(demand)
        enable = demand.enable and not self._is_tripped
        reset = demand.fault_reset and not enable
        self._vcu.send(demand.torque_nm if enable else 0.0, enable, reset)

    def _interlock(self, demand: Demand) -> None:
        """A drive that tripped or was never ready is not enabled again before the page has demanded a disable."""
        is_running = self._reports.state() in RUNNING_STATES
        if demand.enable and not self._was_running and not is_running and not self._reports.ready():
            self._is_tripped = True
        lost = self._was_running and not is_running and not self._reports.ready()
        if demand.enable and (lost or not self._vcu.is_there or self._reports.other_contract()):
            self._is_tripped = True
        self._was_running = demand.enable and is_running

    def report(self) -> dict[str, Any]:
        reports, demand = self._reports, self._demand
        is_there = self._vcu.is_there
        status = reports.latest.get(STATUS, {}) if is_there else {}
        capability = reports.latest.get("MCU_Capability", {}) if is_there else {}
        temperatures = reports.latest.get("MCU_Temperatures", {}) if is_there else {}
        return {
            "session": self._session,
            "is_sending": demand is not None,
            "not_sending": None if demand else self._not_sending,
            "enable": bool(demand and demand.enable and not self._is_tripped),
            "torque_nm": demand.torque_nm if demand else 0.0,
            "tripped": self._is_tripped,
            "drive_state": str(status["DriveState"]) if status else None,
            "lockout": bool(status["Lockout"]) if status else None,
            "ready": is_there and reports.ready(),
            "first_fault": reports.first_fault() if status and str(status["DriveState"]) == "FAULT" else None,
            "motoring_nm": number(capability.get("TorqueMotoring")),
            "regenerating_nm": number(capability.get("TorqueRegenerating")),
            "temperatures": {name: number(value) for name, value in temperatures.items()},
            "refused_frames": reports.refused,
            "unsent": self._vcu.unsent,
            "missed": self._vcu.missed,
            "problem": reports.other_contract(),
        }


def number(value: Any) -> float | None:
    """A signal's number; None for what is not there or has a name in the place of a number."""
    return float(value) if isinstance(value, (int, float)) else None


def read_orders(orders: "queue.Queue[dict | None]") -> None:
    for line in sys.stdin:
        orders.put(json.loads(line))
    orders.put(None)


def serve(unit: Unit) -> None:
    orders: queue.Queue[dict | None] = queue.Queue()
    threading.Thread(target=read_orders, args=(orders,), name="orders", daemon=True).start()
    periods = 0
    while True:
        while not orders.empty():
            order = orders.get()
            if order is None or not unit.take(order):
                return
        unit.step()
        periods += 1
        if periods % REPORT_PERIODS == 0:
            print(json.dumps(unit.report()), flush=True)


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="vehicle_process", description=__doc__.partition("\n")[0])
    parser.add_argument("--can", required=True, metavar="BUS")
    parser.add_argument("--identifier-offset", type=int, default=0, metavar="N")
    parser.add_argument("--torque-limit", type=float, required=True, metavar="NM")
    parser.add_argument("--demand-timeout", type=float, required=True, metavar="S")
    options = parser.parse_args(arguments)
    vcu = Vcu(options.can, identifier_offset=options.identifier_offset, torque_limit_nm=options.torque_limit)
    try:
        serve(Unit(vcu, options.demand_timeout))
    except BrokenPipeError:
        raise UserError("the dashboard is gone.") from None
    finally:
        vcu.close()
    return 0


if __name__ == "__main__":
    run("vehicle_process", main)
