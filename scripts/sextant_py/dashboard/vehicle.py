"""The dashboard's side of the process that commands the drive."""

import json
import os
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path

from .. import bus as can_bus
from ..commander import COMMAND
from ..contract import Contract
from ..errors import UserError

END_S = 5.0
DEMAND_TIMEOUT_S = 0.4  # a page repeats its demand every 0.1 s
DEMAND_TIMEOUTS_S = (0.2, 30.0)
PACKAGES = Path(__file__).resolve().parents[2]


class Vehicle:
    """Starts the process, hands it demands and passes on its reports, from a thread of its own."""

    def __init__(self, address: str, identifier_offset: int, torque_limit_nm: float, demand_timeout_s: float) -> None:
        parsed = can_bus.parse(address)
        smallest_nm, largest_nm = Contract(identifier_offset=identifier_offset).limits(COMMAND, "TorqueLimit")
        if not smallest_nm < torque_limit_nm <= largest_nm:
            raise UserError(f"--torque-limit must be above {smallest_nm:g} and at most {largest_nm:g} N·m.")
        shortest_s, longest_s = DEMAND_TIMEOUTS_S
        if not shortest_s <= demand_timeout_s <= longest_s:
            raise UserError(f"--demand-timeout must be {shortest_s:g} to {longest_s:g} s.")
        can_bus.open_bus(parsed).shutdown()  # raises what is wrong with the bus
        self.address = str(parsed)
        self.torque_limit_nm = torque_limit_nm
        self._command = [sys.executable, "-m", "sextant_py.dashboard.vehicle_process", "--can", self.address]
        self._command += ["--identifier-offset", str(identifier_offset), "--torque-limit", str(torque_limit_nm)]
        self._command += ["--demand-timeout", str(demand_timeout_s)]
        self._process: subprocess.Popen[str] | None = None

    def start(self, report: Callable[[dict | None], None]) -> None:
        """Calls `report` with each report, and with None when the process has ended."""
        paths = [str(PACKAGES), *filter(None, [os.environ.get("PYTHONPATH")])]
        self._process = subprocess.Popen(
            self._command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)},
            start_new_session=True,  # Ctrl-C is for the dashboard, which then ends this process in good order
        )
        threading.Thread(target=self._read_reports, args=(report,), name="vehicle", daemon=True).start()

    def _read_reports(self, report: Callable[[dict | None], None]) -> None:
        for line in self._process.stdout:
            report(json.loads(line))
        report(None)

    def order(self, **order: object) -> bool:
        """Whether the process has taken the order."""
        try:
            self._process.stdin.write(json.dumps(order) + "\n")
            self._process.stdin.flush()
        except (OSError, ValueError):
            return False
        return True

    def end(self) -> None:
        """Disable frames where it commands; then the process ends."""
        if self._process is None:
            return
        self.order(end=True)
        try:
            self._process.wait(END_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
