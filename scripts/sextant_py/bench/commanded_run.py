"""The live drive in hard mode beside a vehicle control unit that commands it, on one bus. Runs where the bus is, which
may be a guest."""

import argparse
import os
import subprocess
import sys
import time
from pathlib import Path

from sextant_py.errors import UserError, run

from .live_runs import PROFILE, ecu_command


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--can", required=True)
    parser.add_argument("--timing-out", type=Path, required=True)
    parser.add_argument("--seconds", type=float, default=14.0)
    arguments = parser.parse_args(argv)
    where = os.environ.get("WITH_VCAN", "native")
    period_us, settings = 250, {}
    if where == "qemu":  # an emulated processor has no time for 250 µs, nor for spinning
        period_us, settings = (
            1000,
            {"control__period_us": 1000, "realtime__wait": "sleep", "realtime__watchdog_ms": 1000},
        )
    command = ecu_command(arguments.timing_out, arguments.seconds, arguments.can, **settings)
    with subprocess.Popen(command, stdout=sys.stderr) as drive:
        time.sleep(1.0)
        vcu = [sys.executable, "-m", "sextant_py.vcu", "--can", arguments.can, "--profile", str(PROFILE), "--quiet"]
        # What it reports of the drive is not judged here: only the frames' way counts.
        try:
            commands = subprocess.run(vcu, stdout=sys.stderr, timeout=arguments.seconds + 60.0)
        except subprocess.TimeoutExpired as error:
            drive.terminate()
            raise UserError("the vehicle control unit did not end within its time") from error
        if drive.wait() != 0:
            raise UserError("sextant-ecu failed")
    print(where, period_us)
    return 0 if commands.returncode in (0, 1) else commands.returncode


if __name__ == "__main__":
    run("commanded_run", main)
