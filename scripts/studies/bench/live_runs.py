"""What the stage `live` runs: the live drive, the empty loop, cyclictest, and the two processes of a lockstep run."""

import contextlib
import json
import os
import re
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

from sextant_py.errors import UserError
from sextant_py.paths import LOOPBACK, ROOT

from .figure import NotMeasurableError
from .histogram import Histogram
from .lab import Lab

PROGRAMS = ROOT / "build" / "release" / "apps"
CONFIGS = ROOT / "configs"
HARD = CONFIGS / "ecu_hard.toml"
PROFILE = CONFIGS / "profiles" / "demo.csv"
BUS = "udp_multicast:239.74.163.2:43177"
PRIORITY = 80
RECEIVE_PRIORITY = PRIORITY - 10  # of the drive's receive thread
# What cyclictest says where it may not do what ours may not either.
REFUSED = re.compile(r"scheduling policy|mlockall|permission|permitted|privileges", re.IGNORECASE)
Command = list[str | Path]


def measured_cpu() -> int:
    """The last of the CPUs that this process may use: the first gets most of the interrupts."""
    return max(os.sched_getaffinity(0))


def other_cpus() -> str:
    """Where the drive's other threads run, as taskset and cyclictest write it."""
    cpus = os.sched_getaffinity(0)
    return ",".join(map(str, sorted(cpus - {measured_cpu()} or cpus)))


def refusal_of_real_time() -> str:
    """Why threads of this process get no SCHED_FIFO, in a sentence; empty where they do. Our programs would run on
    without it, and their latencies would say nothing."""
    done = subprocess.run(["chrt", "--fifo", str(PRIORITY), "true"], capture_output=True, text=True)
    return "" if done.returncode == 0 else "SCHED_FIFO is refused here; scripts/rt_check says how to get it"


def require_real_time() -> None:
    """Throws NotMeasurableError where the control thread would be refused SCHED_FIFO."""
    if refusal := refusal_of_real_time():
        raise NotMeasurableError(refusal)


def own_environment() -> dict[str, str]:
    return {"CYCLONEDDS_URI": LOOPBACK.read_text(encoding="utf-8"), "PYTHONPATH": str(ROOT / "scripts")}


def settings(**values: object) -> list[str]:
    """`--set key=value` for each; "__" in a key stands for its dot."""
    return [word for key, value in values.items() for word in ("--set", f"{key.replace('__', '.')}={value}")]


def ecu_command(timing: Path, seconds: float, bus: str, **values: object) -> Command:
    values = {"realtime__required": "false", "realtime__cpu": measured_cpu(), "realtime__priority": PRIORITY} | values
    words = ("--can", bus, "--duration", str(seconds), "--timing-out", str(timing))
    return [str(PROGRAMS / "sextant-ecu"), str(HARD), *settings(**values), *words]


def ecu(lab: Lab, name: str, seconds: float, **values: object) -> dict:
    """The timing of a run of the live drive in hard mode, without commands."""
    require_real_time()
    file = lab.out / f"{name}.json"
    file.unlink(missing_ok=True)
    uri = own_environment()["CYCLONEDDS_URI"]
    lab.run("env", f"CYCLONEDDS_URI={uri}", *ecu_command(file, seconds, BUS, **values))
    return json.loads(file.read_text(encoding="utf-8"))


def empty_loop(lab: Lab, seconds: float, period_us: float, wait: str, **options: float) -> dict:
    """options: of its command line, with "_" for each dash."""
    options = {"period_us": period_us, "duration": seconds, "wait": wait, **options}
    options |= {"cpu": measured_cpu(), "priority": PRIORITY}
    words = (word for key, value in options.items() for word in (f"--{key.replace('_', '-')}", str(value)))
    return json.loads(lab.run(lab.programs / "sextant_empty_loop", *words))


def cyclictest_command(seconds: int, period_us: int, priority: int, cpus: str) -> list[str]:
    if shutil.which("cyclictest") is None:
        raise NotMeasurableError("cyclictest is missing; scripts/setup --gates installs it.")
    return [
        *("cyclictest", "--mlockall", "--threads=1", f"--priority={priority}", f"--interval={period_us}"),
        *(f"--affinity={cpus}", "--nsecs", "--verbose", f"--duration={seconds}"),
    ]


def cyclictest(lab: Lab, seconds: int, period_us: int) -> Histogram:
    """Latency of each of its wake-ups; with the same policy, priority and CPU as ours."""
    try:
        return cyclictest_latency(lab.run(*cyclictest_command(seconds, period_us, PRIORITY, str(measured_cpu()))))
    except UserError as error:
        raise NotMeasurableError(str(error)) if REFUSED.search(str(error)) else error from error


def cyclictest_latency(text: str) -> Histogram:
    return Histogram.of(int(value) for value in re.findall(r"^\s*0:\s*\d+:\s*(\d+)$", text, re.MULTILINE))


def end(running: subprocess.Popen, within_s: float) -> None:
    """In order, so that it writes its timing; a program that does not is killed."""
    running.terminate()
    try:
        running.wait(within_s)
    except subprocess.TimeoutExpired:
        running.kill()
        running.wait()


@contextlib.contextmanager
def program(command: Command, out: Path) -> Iterator[subprocess.Popen]:
    """Its output goes to a file, where it can be read while it runs."""
    with out.open("wb") as text:
        environment = os.environ | own_environment()
        running = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=text, stderr=text, env=environment)
    try:
        yield running
    finally:
        end(running, 10.0)


def lockstep(lab: Lab, number: int, seconds: float) -> tuple[float, str]:
    """Plant and drive as two processes in lockstep, in virtual time, at 25 µs: virtual by real time, and the digest."""
    link = {"hil__pacing": "lockstep", "hil__link": f"sextant_bench_{os.getpid()}_{number}"}
    plant = [PROGRAMS / "sextant-plant", CONFIGS / "plant.toml", *settings(**link, period_us=25)]
    with program(plant, lab.out / "lockstep_plant.txt"):
        time.sleep(0.3)
        text = lab.run(
            *(PROGRAMS / "sextant-ecu", CONFIGS / "ecu_hil.toml", *settings(**link, drive__period_us=25)),
            *("--virtual-time", "--profile", PROFILE, "--duration", str(seconds)),
        )
    factor = re.search(r"virtual time ([\d.]+) s in ([\d.]+) s", text)
    digest = re.search(r"digest ([0-9a-f]+)", text)
    if factor is None or digest is None:
        raise UserError(f"sextant-ecu does not say how fast it was: {text.strip()[-200:]}")
    return float(factor[1]) / float(factor[2]), digest[1]


def commanded(lab: Lab, name: str, bus: str, inside: tuple[str, ...] = (), *options: str) -> dict:
    """The timing of a run that follows commands at 100 Hz, with what the run tells of itself (`where`, `period_us`,
    `ended_early`), and as `reference` the wake-ups of cyclictest in the receive thread's place. inside: the program
    that gives it its bus."""
    files = {kind: lab.out / f"{name}.{kind}" for kind in ("json", "cyclictest")}
    for file in files.values():
        file.unlink(missing_ok=True)
    own = [sys.executable, "-m", "studies.bench.commanded_run", "--can", bus, "--timing-out", str(files["json"])]
    own += ["--reference-out", str(files["cyclictest"]), *options]
    passed = (f"{key}={value}" for key, value in own_environment().items())
    told = json.loads(lab.run("env", *passed, *inside, *own).splitlines()[-1])
    if told["refused"]:
        raise NotMeasurableError(told["refused"])
    reference = cyclictest_latency(files["cyclictest"].read_text(encoding="utf-8"))
    return json.loads(files["json"].read_text(encoding="utf-8")) | told | {"reference": reference}
