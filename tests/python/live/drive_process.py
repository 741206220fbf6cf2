"""sextant-ecu as a process."""

import signal
import subprocess
import time
from pathlib import Path

from programs import ProgramProcess, overrides, program
from sextant_py.paths import ROOT

STATISTICS_HZ = 10
# So wide that no machine that stands still trips the drive. A test of a timeout sets its own.
WIDE = (
    *("command.timeout_ms=10000", "command.lost_ms=60000"),
    *("command.status_timeout_ms=10000", "command.status_lost_ms=60000"),
    "realtime.watchdog_ms=60000",
)
LEAVE_S = 60.0


class DriveProcess(ProgramProcess):
    """The drives of a configuration on a bus and in a DDS domain."""

    def __init__(
        self,
        address: str,
        domain: int,
        folder: Path,
        settings: tuple[str, ...] = (),
        words: tuple[str | Path, ...] = (),
        config: Path = ROOT / "configs" / "ecu.toml",
    ) -> None:
        own = (f"dds.domain={domain}", f"dds.statistics_rate_hz={STATISTICS_HZ}")
        super().__init__(
            [
                *(program("sextant-ecu"), config, "--can", address),
                *overrides((*own, *settings)),
                *words,
            ],
            folder / f"sextant-ecu.{time.monotonic_ns()}.stderr",
            stdout=subprocess.DEVNULL,
        )

    @property
    def pid(self) -> int:
        return self._process.pid

    @property
    def status(self) -> int | None:
        """Its exit status; None while it runs."""
        return self._process.poll()

    def errors(self) -> str:
        return self.text()

    def ended(self, within_s: float) -> int:
        """Its exit status, once it has ended by itself."""
        return self._process.wait(within_s)

    def leave(self, how: signal.Signals) -> int:
        """Sends the signal; the exit status."""
        self._process.send_signal(how)
        return self._process.wait(LEAVE_S)
