"""The live drive in hard mode beside a vehicle control unit that commands it, on one bus, and beside cyclictest in the
receive thread's place. Runs where the bus is, which may be a guest. Its last line tells what it was, as JSON."""

import argparse
import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

from sextant_py import bus as can_bus
from sextant_py.contract import Contract
from sextant_py.errors import UserError, run
from sextant_py.vcu import Reports

from .live_runs import PROFILE, RECEIVE_PRIORITY, cyclictest_command, ecu_command, other_cpus, refusal_of_real_time

ANSWER_S = {"native": 20.0, "uml": 60.0, "qemu": 90.0}  # until the drive is heard on its bus
COMMANDED_S = 14.0  # hand-shake and profile
# Not in step with the commands, which come every 10 ms, and about as seldom: the thread sleeps as deeply.
REFERENCE_PERIOD_US = 3700
# An emulated processor has no time for 250 µs, nor for spinning; in User Mode Linux each reading of the clock is a
# system call, so that time stamps by stage are more than the work between them.
SETTINGS = {
    "native": (250, {}),
    "uml": (250, {"realtime__stage_statistics": "false", "realtime__watchdog_ms": 200}),
    "qemu": (1000, {"control__period_us": 1000, "realtime__wait": "sleep", "realtime__watchdog_ms": 1000}),
}


def drive_answers(address: str, drive: subprocess.Popen, within_s: float) -> bool:
    """Waits until the drive's status is heard on the bus."""
    bus = can_bus.open_bus(can_bus.parse(address))
    reports = Reports(bus, Contract())
    reports.start()
    try:
        end = time.monotonic() + within_s
        while reports.state() is None:
            if drive.poll() is not None:
                raise UserError(f"sextant-ecu ended at once, with status {drive.returncode}")
            if time.monotonic() > end:
                return False
            time.sleep(0.05)
        return True
    finally:
        reports.stop()
        bus.shutdown()


def command_it(address: str) -> str:
    """Plays the profile to the drive. Returns why it ended early, where it did: only the frames' way counts here."""
    vcu = [sys.executable, "-m", "sextant_py.vcu", "--can", address, "--profile", str(PROFILE)]
    try:
        done = subprocess.run(
            [*vcu, "--quiet", "--reset-faults", "--timeout", "30"],
            capture_output=True,
            text=True,
            timeout=COMMANDED_S + 90.0,
        )
    except subprocess.TimeoutExpired as error:
        raise UserError("the vehicle control unit did not end within its time") from error
    sys.stderr.write(done.stderr)
    if done.returncode not in (0, 1):
        raise UserError(f"the vehicle control unit failed: {done.stderr.strip()[-200:]}")
    return done.stderr.strip().removeprefix("vcu: ")


@contextlib.contextmanager
def cyclictest_beside(out: Path | None) -> Iterator[None]:
    """Where the receive thread runs, with its priority, while that works."""
    if out is None:
        yield
        return
    command = cyclictest_command(600, REFERENCE_PERIOD_US, RECEIVE_PRIORITY, other_cpus())
    with out.open("wb") as text, subprocess.Popen(command, stdout=text) as reference:
        try:
            yield
        finally:
            reference.send_signal(signal.SIGINT)


def leave(drive: subprocess.Popen) -> None:
    """In order, so that it writes its timing; a drive that does not is killed."""
    drive.terminate()
    try:
        drive.wait(30.0)
    except subprocess.TimeoutExpired:
        drive.kill()
        drive.wait()


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--can", required=True)
    parser.add_argument("--timing-out", type=Path, required=True)
    parser.add_argument("--reference-out", type=Path, help="what cyclictest prints; without it there is none")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="as of sextant-ecu")
    arguments = parser.parse_args(argv)
    # On the host's own kernel only those threads shall be real time that the programs make so.
    os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
    where = os.environ.get("WITH_VCAN", "native")
    period_us, settings = SETTINGS[where]
    told: dict = {"where": where, "period_us": period_us, "refused": refusal_of_real_time()}
    if told["refused"]:
        print(json.dumps(told))
        return 0
    seconds = ANSWER_S[where] + COMMANDED_S + 120.0  # it is ended before
    command = ecu_command(arguments.timing_out, seconds, arguments.can, **settings)
    for setting in arguments.set:
        command += ["--set", setting]
    with subprocess.Popen(command, stdout=sys.stderr) as drive:
        try:
            told["answered"] = drive_answers(arguments.can, drive, ANSWER_S[where])
            if told["answered"]:
                with cyclictest_beside(arguments.reference_out):
                    told["ended_early"] = command_it(arguments.can)
        finally:
            leave(drive)
    if drive.returncode != 0:
        raise UserError(f"sextant-ecu failed with status {drive.returncode}")
    print(json.dumps(told))
    return 0


if __name__ == "__main__":
    run("commanded_run", main)
