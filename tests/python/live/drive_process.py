"""sextant-ecu as a process."""

import os
import select
import signal
import subprocess
import time
from pathlib import Path

from sextant_py.paths import ROOT

STATISTICS_HZ = 10


def program(name: str) -> Path:
    """A program of the project, from the directory that SEXTANT_BIN names or else from a preset's build."""
    places = [Path(os.environ["SEXTANT_BIN"])] if "SEXTANT_BIN" in os.environ else []
    places += [ROOT / "build" / preset / "apps" for preset in ("dev", "release")] if not places else []
    for place in places:
        if (place / name).is_file():
            return place / name
    raise FileNotFoundError(f"{name} is in none of {', '.join(map(str, places))}; SEXTANT_BIN names its directory")


def _ordinary_scheduling() -> None:
    """The drive gets no real-time scheduling from the test; what it wants it has to ask for itself."""
    os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))


class DriveProcess:
    """One drive on a bus and in a DDS domain; a context that ends the process whatever happened."""

    def __init__(self, address: str, domain: int, folder: Path, settings: tuple[str, ...] = ()) -> None:
        integrator = os.environ.get("SEXTANT_LIVE_INTEGRATOR", "cvode")
        own = (f"dds.domain={domain}", f"dds.statistics_rate_hz={STATISTICS_HZ}", f"plant.integrator={integrator}")
        self.command = [program("sextant-ecu"), ROOT / "configs" / "ecu.toml", "--can", address]
        for setting in (*own, *settings):
            self.command += ["--set", setting]
        self._errors_path = folder / f"sextant-ecu.{time.monotonic_ns()}.stderr"
        self._process: subprocess.Popen | None = None

    def __enter__(self) -> "DriveProcess":
        with self._errors_path.open("wb") as errors:
            self._process = subprocess.Popen(
                self.command,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=errors,
                preexec_fn=_ordinary_scheduling,
            )
        return self

    def __exit__(self, *_: object) -> None:
        if self.is_running():
            self._process.terminate()
            try:
                self._process.wait(5)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()

    def is_running(self) -> bool:
        return self._process.poll() is None

    def errors(self) -> str:
        return self._errors_path.read_text(encoding="utf-8")

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
