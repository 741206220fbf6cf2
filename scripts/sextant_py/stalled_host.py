"""Runs a command and stops all of its processes again and again, as a host does that takes its processors away.

Usage: stalled_host COMMAND [ARGUMENTS...]. Exit status: the command's own, or 128 and the signal that ended it.
"""

import ctypes
import os
import random
import signal
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

from .errors import UserError, run

STOP_S = 0.3
APART_S = (2.0, 4.0)  # from one stop's end to the next
SEED = 9
STANDING = {"T", "t", "Z", "X"}  # stopped by somebody else, traced, or gone
PR_SET_CHILD_SUBREAPER = 36


def processes() -> dict[int, tuple[int, str, int]]:
    """Of every process: its parent, its state, and who traces it (0: nobody)."""
    found = {}
    for folder in Path("/proc").iterdir():
        if not folder.name.isdigit():
            continue
        try:
            lines = (folder / "status").read_text(encoding="utf-8", errors="replace").splitlines()
        except OSError:
            continue  # it has ended
        fields = dict(line.split(":\t", 1) for line in lines if ":\t" in line)
        found[int(folder.name)] = (int(fields["PPid"]), fields["State"][0], int(fields["TracerPid"]))
    return found


def below(root: int, table: dict[int, tuple[int, str, int]]) -> set[int]:
    """The processes below one, however far."""
    children: dict[int, list[int]] = {}
    for process_id, (parent, _, _) in table.items():
        children.setdefault(parent, []).append(process_id)
    found: set[int] = set()
    left = [root]
    while left:
        new = children.get(left.pop(), [])
        found.update(new)
        left += new
    return found


def stop_all(root: int) -> list[int]:
    """Stops every process below one that runs, those born meanwhile too; which they were.

    One that stands still already is somebody else's to wake. One that is traced stands still with its tracer, which may
    not know what to make of a signal that is not its own (User Mode Linux does not).
    """
    stopped: list[int] = []
    while True:
        table = processes()
        running = [
            process_id
            for process_id in below(root, table)
            if table[process_id][1] not in STANDING and table[process_id][2] == 0 and process_id not in stopped
        ]
        if not running:
            return stopped
        stopped += [process_id for process_id in running if send(process_id, signal.SIGSTOP)]


def send(process_id: int, which: signal.Signals) -> bool:
    try:
        os.kill(process_id, which)
    except (ProcessLookupError, PermissionError):
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
        stopped: list[int] = []
        try:
            stopped = stop_all(os.getpid())
            time.sleep(STOP_S)
        finally:
            for process_id in reversed(stopped):
                send(process_id, signal.SIGCONT)
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
