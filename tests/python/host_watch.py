"""When the host stood still, by processor: what tells a drive that trips from one that was not let run.

As a program, host_watch.py CPU: sleeps a millisecond again and again on that processor and prints begin and end
[s, CLOCK_MONOTONIC] of each sleep that took much longer.
"""

import gc
import os
import subprocess
import sys
import time
from pathlib import Path

from sextant_py.host_stalls import stalls
from sextant_py.paths import ROOT

SHORTEST_S = 0.001  # a thread of real-time priority wakes up within some 0.1 ms
PRIORITY = 20  # below plant and drive, above all else
SETTLING_S = 0.02  # a watcher that stood still has told of it by then, unless it still does


class HostWatch:
    """One watcher for each processor for the time of a `with`."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._watchers: dict[Path, subprocess.Popen] = {}
        self._more_logs: list[Path] = []

    def __enter__(self) -> "HostWatch":
        environment = {**os.environ, "PYTHONPATH": str(ROOT / "scripts")}
        for cpu in sorted(os.sched_getaffinity(0)):
            log = self._folder / f"host_watch.{cpu}"
            with log.open("wb") as out:
                command = [sys.executable, __file__, str(cpu)]
                self._watchers[log] = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=out, env=environment)
        for log, watcher in self._watchers.items():
            while not log.read_text().startswith("watching\n"):
                assert watcher.poll() is None, f"{log.name} has ended"
                time.sleep(0.01)
        return self

    def __exit__(self, *_: object) -> None:
        for watcher in self._watchers.values():
            watcher.terminate()
            watcher.wait()

    @property
    def process_ids(self) -> list[int]:
        return [watcher.pid for watcher in self._watchers.values()]

    def listen_to(self, log: Path) -> None:
        """From now on also counts as a stall what another program has written of itself, in the same form."""
        self._more_logs.append(log)

    def stood_still_ns(self, begin_ns: int, end_ns: int) -> int:
        """How long the processors stood still between two times of CLOCK_MONOTONIC, the sum of all [ns]."""
        time.sleep(SETTLING_S)
        total = 0
        for log in [*self._watchers, *self._more_logs]:
            # The last line may still be being written.
            for line in log.read_text().split("\n")[1:-1]:
                stall_begin_ns, stall_end_ns = (round(float(word) * 1e9) for word in line.split())
                total += max(0, min(end_ns, stall_end_ns) - max(begin_ns, stall_begin_ns))
        return total


def main() -> None:
    os.sched_setaffinity(0, {int(sys.argv[1])})
    try:
        os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(PRIORITY))
    except PermissionError:
        print("host_watch: no right to real-time scheduling here", file=sys.stderr)
    gc.disable()
    print("watching", flush=True)
    for begin, end in stalls(SHORTEST_S):
        print(f"{begin:.6f} {end:.6f}", flush=True)


if __name__ == "__main__":
    main()
