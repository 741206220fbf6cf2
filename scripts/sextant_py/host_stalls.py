"""Counts how often the host stopped this machine while other work ran: sleeps of a millisecond that took much longer.

Usage: host_stalls.py FILE. Writes the count so far, and the longest [ms], to FILE until it is terminated.
"""

import sys
import time
from pathlib import Path

STALL_S = 0.01  # no scheduler of this machine explains a real-time thread that is this late


def main() -> None:
    report = Path(sys.argv[1])
    count, worst = 0, 0.0
    report.write_text("0 0")
    while True:
        begin = time.monotonic()
        time.sleep(0.001)
        late = time.monotonic() - begin - 0.001
        if late > STALL_S:
            count, worst = count + 1, max(worst, late)
            report.write_text(f"{count} {1e3 * worst:.0f}")


if __name__ == "__main__":
    main()
