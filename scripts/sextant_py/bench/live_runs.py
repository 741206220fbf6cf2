"""What the stage `live` runs: the live drive, the empty loop, cyclictest, and the two processes of a lockstep run."""

import contextlib
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from sextant_py.errors import UserError
from sextant_py.paths import LOOPBACK, ROOT

from .figure import NotMeasurableError
from .histogram import Histogram
from .lab import Lab

PROGRAMS = ROOT / "build" / "release" / "apps"
HARD = ROOT / "configs" / "ecu_hard.toml"
PROFILE = ROOT / "configs" / "profiles" / "demo.csv"
BUS = "udp_multicast:239.74.163.2:43177"
PRIORITY = 80


def measured_cpu() -> int:
    """The last of the CPUs that this process may use: the first gets most of the interrupts."""
    return max(os.sched_getaffinity(0))


def environment() -> dict[str, str]:
    return {
        **os.environ,
        "CYCLONEDDS_URI": LOOPBACK.read_text(encoding="utf-8"),
        "PYTHONPATH": str(ROOT / "scripts"),
    }


def settings(**values: object) -> list[str]:
    """`--set key=value` for each; "__" in a key stands for its dot."""
    return [word for key, value in values.items() for word in ("--set", f"{key.replace('__', '.')}={value}")]


def ecu_command(timing: Path, seconds: float, bus: str, **values: object) -> list[str]:
    return [
        str(PROGRAMS / "sextant-ecu"),
        str(HARD),
        *settings(realtime__required="false", realtime__cpu=measured_cpu(), realtime__priority=PRIORITY, **values),
        *("--can", bus, "--duration", str(seconds), "--timing-out", str(timing)),
    ]


def ecu(lab: Lab, name: str, seconds: float, **values: object) -> dict:
    """The timing of a run of the live drive in hard mode, without commands."""
    file = lab.out / f"{name}.json"
    file.unlink(missing_ok=True)
    lab.run("env", f"CYCLONEDDS_URI={environment()['CYCLONEDDS_URI']}", *ecu_command(file, seconds, BUS, **values))
    return json.loads(file.read_text(encoding="utf-8"))


def empty_loop(lab: Lab, seconds: float, period_us: float, wait: str, **options: float) -> dict:
    """options: of its command line, with "_" for each dash."""
    words = (word for key, value in options.items() for word in (f"--{key.replace('_', '-')}", str(value)))
    return json.loads(
        lab.run(
            lab.programs / "sextant_empty_loop",
            *("--period-us", str(period_us), "--duration", str(seconds), "--wait", wait),
            *("--cpu", str(measured_cpu()), "--priority", str(PRIORITY)),
            *words,
        )
    )


def cyclictest(lab: Lab, seconds: int, period_us: int) -> Histogram:
    """Latency of each of its wake-ups; with the same policy, priority and CPU as ours."""
    if shutil.which("cyclictest") is None:
        raise NotMeasurableError("cyclictest is missing; scripts/setup --gates installs it.")
    text = lab.run(
        *("cyclictest", "--mlockall", "--threads=1", f"--priority={PRIORITY}", f"--interval={period_us}"),
        *(f"--affinity={measured_cpu()}", "--nsecs", "--verbose", f"--duration={seconds}"),
    )
    return Histogram.of(int(value) for value in re.findall(r"^\s*0:\s*\d+:\s*(\d+)$", text, re.MULTILINE))


@dataclass(frozen=True)
class LockstepRun:
    realtime_factor: float
    digest: str


@contextlib.contextmanager
def process(*command: str) -> Iterator[subprocess.Popen]:
    running = subprocess.Popen(
        command,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        env=environment(),
    )
    try:
        yield running
    finally:
        if running.poll() is None:
            running.send_signal(signal.SIGTERM)
            try:
                running.wait(5)
            except subprocess.TimeoutExpired:
                running.kill()
        running.communicate()


def lockstep(lab: Lab, number: int, seconds: float) -> LockstepRun:
    """Plant and drive as two processes in lockstep, in virtual time, at 25 µs."""
    link = f"sextant_bench_{os.getpid()}_{number}"
    plant = [
        str(PROGRAMS / "sextant-plant"),
        str(ROOT / "configs" / "plant.toml"),
    ]
    with process(*plant, *settings(hil__pacing="lockstep", hil__link=link, period_us=25)):
        time.sleep(0.3)
        text = lab.run(
            *(PROGRAMS / "sextant-ecu", ROOT / "configs" / "ecu_hil.toml"),
            *settings(hil__pacing="lockstep", hil__link=link, control__period_us=25),
            *("--virtual-time", "--profile", PROFILE, "--duration", str(seconds)),
        )
    factor = re.search(r"virtual time ([\d.]+) s in ([\d.]+) s", text)
    digest = re.search(r"digest ([0-9a-f]+)", text)
    if factor is None or digest is None:
        raise UserError(f"sextant-ecu does not say how fast it was: {text.strip()[-200:]}")
    return LockstepRun(float(factor[1]) / float(factor[2]), digest[1])


def commanded(lab: Lab, name: str, bus: str, inside: tuple[str, ...] = ()) -> dict:
    """The timing of a run that follows commands at 100 Hz, with the kernel that it ran on as `where`. inside: the
    program that gives it its bus."""
    file = lab.out / f"{name}.json"
    file.unlink(missing_ok=True)
    own = [sys.executable, "-m", "sextant_py.bench.commanded_run", "--can", bus, "--timing-out", str(file)]
    passed = (f"{key}={value}" for key, value in environment().items() if key in ENVIRONMENT)
    where, period_us = lab.run("env", *passed, *inside, *own).split()[-2:]
    return json.loads(file.read_text(encoding="utf-8")) | {"where": where, "period_us": int(period_us)}


ENVIRONMENT = ("CYCLONEDDS_URI", "PYTHONPATH")
