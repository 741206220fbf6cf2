"""What a step of a control method costs: nanoseconds here, instructions on the Cortex-M4F."""

import json
import subprocess

from sextant_py.paths import ROOT

from studies.bench.google import GoogleResult
from studies.microcontroller import page as cortex_page

PROGRAM = ROOT / "build" / "release" / "tests" / "bench" / "sextant_bench"


def step_ns(methods: list[str]) -> dict[str, float]:
    """The least CPU time of a step, estimator included; empty where the benchmarks are not built."""
    if not PROGRAM.is_file():
        return {}
    command = [PROGRAM, "--benchmark_filter=^controller_step/", "--benchmark_format=json"]
    command += ["--benchmark_repetitions=5", "--benchmark_min_time=0.05"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    found = GoogleResult(json.loads(done.stdout))
    return {name: round(found.value(f"controller_step/{name}", "cpu_ns", "least"), 1) for name in methods}


def instructions() -> dict[str, dict[str, float]]:
    """By method mean and most, from the results of the microcontroller."""
    return cortex_page.load()["methods"]
