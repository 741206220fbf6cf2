"""Runs a command and stops all of its processes again and again, as a host does that takes its processors away.

Usage: stalled_host COMMAND [ARGUMENTS...]. Exit status: the command's own, or 128 and the signal that ended it.
"""

import ctypes
import random
import signal
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

import psutil

from .errors import UserError, run

STOP_S = 0.3
APART_S = (2.0, 4.0)  # from one stop's end to the next
SEED = 9
STANDING = (psutil.STATUS_STOPPED, psutil.STATUS_TRACING_STOP, psutil.STATUS_ZOMBIE, psutil.STATUS_DEAD)
PR_SET_CHILD_SUBREAPER = 36


def runs(process: psutil.Process) -> bool:
    """Whether it is ours to stop. One that stands still already is somebody else's to wake. One that is traced stands
    still with its tracer, which may not know what to make of a signal that is not its own (User Mode Linux does not).
    """
    try:
        status = Path(f"/proc/{process.pid}/status").read_text(encoding="utf-8", errors="replace")
        return process.status() not in STANDING and "\nTracerPid:\t0\n" in status
    except (psutil.Error, OSError):
        return False  # it has ended


def stop_all() -> list[psutil.Process]:
    """Stops every process below this one that runs, those born meanwhile too; which they were."""
    stopped: list[psutil.Process] = []
    while running := [p for p in psutil.Process().children(recursive=True) if p not in stopped and runs(p)]:
        stopped += [process for process in running if done(process.suspend)]
    return stopped


def done(action: Callable[[], None]) -> bool:
    try:
        action()
    except psutil.Error:
        return False
    return True


def sleep_unless(ended: Callable[[], bool], seconds: float) -> bool:
    """Whether so many seconds passed before it ended."""
    end = time.monotonic() + seconds
    while not ended():
        if time.monotonic() >= end:
            return True
        time.sleep(0.05)
    return False


def disturb(command: subprocess.Popen) -> int:
    """Until the command ends; how often it was stopped."""
    pauses = random.Random(SEED)
    count = 0
    while sleep_unless(lambda: command.poll() is not None, pauses.uniform(*APART_S)):
        stopped: list[psutil.Process] = []
        try:
            stopped = stop_all()
            time.sleep(STOP_S)
        finally:
            for process in reversed(stopped):
                done(process.resume)
        count += 1
    return count


def main(arguments: list[str]) -> int:
    if not arguments:
        raise UserError("which command?")
    # Those whose parent has ended stay below this process.
    ctypes.CDLL(None, use_errno=True).prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)
    try:
        command = subprocess.Popen(arguments)
    except OSError as error:
        raise UserError(f"{arguments[0]} cannot be run: {error.strerror}.") from None
    for which in (signal.SIGINT, signal.SIGTERM):
        signal.signal(which, lambda number, _: command.send_signal(number))
    count = disturb(command)
    print(f"stalled_host: all processes were stopped {count} times for {STOP_S * 1e3:g} ms", flush=True)
    return command.returncode if command.returncode >= 0 else 128 - command.returncode


if __name__ == "__main__":
    run("stalled_host", main)
