"""One point of a sweep: one run of sextant-mil, from its settings to its figures.

Only the standard library is used, and Dask carries this module to its workers by value: they need not have it.
"""

import json
import os
import signal
import socket
import subprocess
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

OK, EXPECT_FAILED, FAILED = "ok", "expect_failed", "failed"
# Verdicts of sextant-mil whose figures count: the run went to its end as it was meant to.
GOOD, WITH_FIGURES = {"pass", "nothing_expected"}, {"pass", "nothing_expected", "fail"}
REFUSED = 2  # exit status of a command that has not run
LONGEST_REASON = 500


@dataclass(frozen=True)
class Job:
    """What a worker has to know. Paths are those of a file system that all workers see."""

    point: int
    sweep: str  # the running sweep, by which its programs are found again
    command: tuple[str, ...]
    directory: str  # in which the program runs
    time_limit_s: float | None  # [s]


def own_state(worker: Any, sweep: str) -> dict[str, Any]:
    """What a worker knows of a sweep. Kept at the worker: this module is a new one in every task."""
    return worker.__dict__.setdefault("sextant_sweeps", {}).setdefault(sweep, {"programs": set(), "ended": False})


def end_programs(sweep: str, dask_worker: Any) -> None:
    """Ends what a worker still runs for a sweep, and what it has been given but not begun."""
    state = own_state(dask_worker, sweep)
    state["ended"] = True
    for program in list(state["programs"]):
        program.kill()


def clean_reason(text: str, program: str = "sextant-mil") -> str:
    """What the program reported, on one line and without its name."""
    lines = [line.strip().removeprefix(f"{program}: ") for line in text.splitlines()]
    reason = "; ".join(line for line in lines if line)
    return reason if len(reason) <= LONGEST_REASON else reason[:LONGEST_REASON] + "…"


def missed_expectations(summary: dict) -> str:
    """Which limits of [expect] do not hold."""
    missed = []
    for row in summary["expect"]:
        if not row["pass"]:
            limits = " and ".join(f"{name} {value:g}" for name, value in row["limit"].items())
            value = "no value" if row["value"] is None else f"{row['value']:.6g}"
            missed.append(f"{row['metric']} is {value}, expected {limits}")
    return "; ".join(missed)


def read_summary(directory: Path) -> dict | None:
    try:
        summary = json.loads((directory / "summary.json").read_text(encoding="utf-8"))
        return summary if isinstance(summary["metrics"], dict) and isinstance(summary["expect"], list) else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


def has_summary(status: int) -> bool:
    """Whether a run with that exit status has gone to its end, and a summary is its own."""
    return 0 <= status < 128 and status != REFUSED


def judge(status: int, said: str, summary: dict | None, program: str = "sextant-mil") -> tuple[str, str]:
    """Status and reason of a run that ended by itself."""
    if status < 0:
        try:
            name = signal.Signals(-status).name
        except ValueError:
            name = str(-status)
        return FAILED, clean_reason(f"{program} was ended by signal {name}\n{said}", program)
    reason = clean_reason(said, program)
    if not has_summary(status) or summary is None:
        return FAILED, reason or f"{program} left {'' if summary else 'no summary and '}exit status {status}"
    verdict = summary.get("verdict")
    if verdict in GOOD and status == 0:
        return OK, ""
    # An expected fault that did not come is said; figures that miss their limits need no sentence.
    missed = missed_expectations(summary) if verdict == "fail" else ""
    if reason or not missed:
        return FAILED, reason or f"{program} left exit status {status} and no reason"
    return EXPECT_FAILED, missed


def run_program(job: Job, out: Path, state: dict[str, Any]) -> tuple[str, str, dict]:
    """Status, reason and metrics."""
    # A session of its own: Ctrl-C at the terminal is for the sweep, which ends its programs itself.
    program = subprocess.Popen(
        [*job.command, "--out", str(out)],
        cwd=job.directory,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        start_new_session=True,
    )
    state["programs"].add(program)
    if state["ended"]:
        program.kill()
    try:
        _, said = program.communicate(timeout=job.time_limit_s)
    except subprocess.TimeoutExpired:
        program.kill()
        program.communicate()
        return FAILED, f"no result within the time limit of {job.time_limit_s:g} s", {}
    finally:
        state["programs"].discard(program)
    summary = read_summary(out)
    status, reason = judge(program.returncode, said.decode("utf-8", "replace"), summary, Path(job.command[0]).name)
    return status, reason, summary["metrics"] if summary else {}


def run_point(job: Job) -> dict:
    """The record of a point. Nothing that happens to the program raises."""
    from distributed import get_worker

    began, worker = time.monotonic(), get_worker()
    try:
        with tempfile.TemporaryDirectory(prefix="sextant-sweep-") as out:
            status, reason, metrics = run_program(job, Path(out), own_state(worker, job.sweep))
    except OSError as error:
        what = f": {error.filename}" if error.filename else ""
        status, reason, metrics = FAILED, f"cannot run on {socket.gethostname()}: {os.strerror(error.errno)}{what}", {}
    return {
        "point": job.point,
        "status": status,
        "reason": reason,
        "metrics": metrics,
        "elapsed_s": round(time.monotonic() - began, 6),
        "worker": str(worker.name),
    }
