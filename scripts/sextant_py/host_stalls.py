"""Counts how often the host stopped this machine while other work ran: sleeps of a millisecond that took much longer.

Usage: host_stalls.py FILE. Writes the count so far, and the longest [ms], to FILE until it is terminated.
"""

import sys
import time
from collections.abc import Iterator
from pathlib import Path

STALL_S = 0.01  # no scheduler of this machine explains a real-time thread that is this late


def stalls(longer_than_s: float = STALL_S) -> Iterator[tuple[float, float]]:
    """When each stall began and ended, on CLOCK_MONOTONIC [s]; for ever."""
    while True:
        due = time.monotonic() + 0.001
        time.sleep(0.001)
        now = time.monotonic()
        if now - due > longer_than_s:
            yield due, now


def main() -> None:
    report = Path(sys.argv[1])
    count, worst = 0, 0.0
    report.write_text("0 0")
    for begin, end in stalls():
        count, worst = count + 1, max(worst, end - begin)
        report.write_text(f"{count} {1e3 * worst:.0f}")


if __name__ == "__main__":
    main()
