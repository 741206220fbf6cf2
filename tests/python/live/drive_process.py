"""sextant-ecu as a process."""

import os
import select
import signal
import subprocess
import time
from pathlib import Path

from programs import ProgramProcess, overrides, program
from sextant_py.paths import ROOT

STATISTICS_HZ = 10


def _ordinary_scheduling() -> None:
    """The drive gets no real-time scheduling from the test; what it wants it has to ask for itself."""
    os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))


class DriveProcess(ProgramProcess):
    """One drive on a bus and in a DDS domain."""

    def __init__(self, address: str, domain: int, folder: Path, settings: tuple[str, ...] = ()) -> None:
        integrator = os.environ.get("SEXTANT_LIVE_INTEGRATOR", "cvode")
        own = (f"dds.domain={domain}", f"dds.statistics_rate_hz={STATISTICS_HZ}", f"plant.integrator={integrator}")
        super().__init__(
            [program("sextant-ecu"), ROOT / "configs" / "ecu.toml", "--can", address, *overrides((*own, *settings))],
            folder / f"sextant-ecu.{time.monotonic_ns()}.stderr",
            stdout=subprocess.DEVNULL,
            preexec_fn=_ordinary_scheduling,
        )

    def errors(self) -> str:
        return self.text()

    def leave(self, how: signal.Signals) -> tuple[int, float]:
        """Sends the signal; returns the exit status and the time until the process was gone [s]."""
        # Popen.wait() with a limit looks only every 50 ms.
        gone = os.pidfd_open(self._process.pid)
        try:
            began = time.monotonic()
            self._process.send_signal(how)
            select.select([gone], [], [], 10)
            leave_s = time.monotonic() - began
        finally:
            os.close(gone)
        return self._process.wait(0.1), leave_s
