"""The live drive in hard mode beside a vehicle control unit that commands it, on one bus, and beside cyclictest in the
receive thread's place. Runs where the bus is, which may be a guest. Its last line tells what it was, as JSON."""

import argparse
import json
import os
import signal
import subprocess
import sys
from pathlib import Path

from sextant_py.errors import UserError, run

from .live_runs import PROFILE, RECEIVE_PRIORITY, cyclictest_command, ecu_command, end, other_cpus, refusal_of_real_time

ANSWER_S = {"native": 20.0, "uml": 60.0, "qemu": 90.0}  # until the drive is heard on its bus
COMMANDED_S = 14.0  # hand-shake and profile
# Not in step with the commands, which come every 10 ms, and about as seldom: the thread sleeps as deeply.
REFERENCE_PERIOD_US = 3700
# An emulated processor has no time for 250 µs, nor for spinning; in User Mode Linux each reading of the clock is a
# system call, so that time stamps by stage are more than the work between them.
SETTINGS = {
    "native": (250, {}),
    "uml": (250, {"realtime__stage_statistics": "false", "realtime__watchdog_ms": 200}),
    "qemu": (1000, {"drive__period_us": 1000, "realtime__wait": "sleep", "realtime__watchdog_ms": 1000}),
}


def command_it(address: str, answer_s: float) -> str:
    """Plays the profile to the drive. Returns why it ended early, where it did: only the frames' way counts here."""
    vcu = [sys.executable, "-m", "sextant_py.vcu", "--can", address, "--profile", str(PROFILE), "--quiet"]
    vcu += ["--reset-faults", "--timeout", str(answer_s)]
    try:
        done = subprocess.run(vcu, capture_output=True, text=True, timeout=answer_s + COMMANDED_S + 90.0)
    except subprocess.TimeoutExpired as error:
        raise UserError("the vehicle control unit did not end within its time") from error
    if done.returncode not in (0, 1):
        raise UserError(f"the vehicle control unit failed: {done.stderr.strip()[-200:]}")
    return done.stderr.strip().removeprefix("vcu: ")


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--can", required=True)
    parser.add_argument("--timing-out", type=Path, required=True)
    parser.add_argument("--reference-out", type=Path, required=True, help="what cyclictest prints")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="as of sextant-ecu")
    arguments = parser.parse_args(argv)
    # On the host's own kernel only those threads shall be real time that the programs make so.
    os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
    where = os.environ.get("WITH_VCAN", "native")
    period_us, settings = SETTINGS[where]
    told: dict = {"where": where, "period_us": period_us, "refused": refusal_of_real_time()}
    if not told["refused"]:
        seconds = ANSWER_S[where] + COMMANDED_S + 120.0  # it is ended before
        command = ecu_command(arguments.timing_out, seconds, arguments.can, **settings)
        command += [word for setting in arguments.set for word in ("--set", setting)]
        beside = cyclictest_command(600, REFERENCE_PERIOD_US, RECEIVE_PRIORITY, other_cpus())
        with (
            arguments.reference_out.open("wb") as text,
            subprocess.Popen(command, stdout=sys.stderr) as drive,
            subprocess.Popen(beside, stdout=text) as reference,
        ):
            try:
                told["ended_early"] = command_it(arguments.can, ANSWER_S[where])
            finally:
                reference.send_signal(signal.SIGINT)
                end(drive, 30.0)
        if drive.returncode != 0:
            raise UserError(f"sextant-ecu failed with status {drive.returncode}")
    print(json.dumps(told))
    return 0


if __name__ == "__main__":
    run("commanded_run", main)
