"""The ratios of a benchmark run beside their targets."""

import argparse
import json
import re
import statistics
import sys
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Target:
    """What a figure should be, and how it follows from the figures of the benchmarks."""

    name: str
    limit: float
    at_most: bool
    value: "callable"
    unit: str = ""


def real_time(name: str):
    """Simulated seconds of a scenario by seconds of CPU."""
    return lambda t: t[f"scenario/{name}"]


SAMPLED = (("sampled_3_1_cvode", 1.5), ("sampled_3_1_fixed", 60.0), ("sampled_nycc_traced", 150.0))
EXACT = ("3_1", "3_2", "3_3", "3_4", "nycc", "table6")
EXACT_ON_CVODE = ("3_1", "3_2", "3_3", "3_4")

TARGETS = (
    Target("DTC step / hand-written", 1.5, True, lambda t: t["dtc_step_ratio"], "x"),
    Target(
        "drive step / hand-written DTC", float("inf"), True, lambda t: t["drive_step"] / t["dtc_step_reference"], "x"
    ),
    Target("fixed-step plant / hand RK4", 1.3, True, lambda t: t["plant_period_ratio"], "x"),
    Target("CVODE plant, 25 us period", 15.0, True, lambda t: t["plant_period/cvode"] * 1e-3, "us"),
    *(Target(f"{name}, real time", limit, False, real_time(name), "x") for name, limit in SAMPLED),
    *(
        Target(f"exact {name}, fixed step, real time", 30.0, False, real_time(f"exact_{name}_fixed"), "x")
        for name in EXACT
    ),
    *(
        Target(f"exact {name}, CVODE 1e-8, real time", 0.7, False, real_time(f"exact_{name}_cvode"), "x")
        for name in EXACT_ON_CVODE
    ),
)


def figures(result: dict) -> dict[str, float]:
    """By benchmark: the least CPU time over its repetitions [ns], the median of its counter `ratio`, or the largest
    of its counter `realtime_factor`."""
    scale = {"ns": 1.0, "us": 1e3, "ms": 1e6, "s": 1e9}
    times: dict[str, list[float]] = {}
    ratios: dict[str, list[float]] = {}
    factors: dict[str, list[float]] = {}
    for run in result["benchmarks"]:
        if run.get("run_type") != "iteration":
            continue
        name = re.sub(r"/(iterations|repeats):\d+", "", run["run_name"])
        times.setdefault(name, []).append(run["cpu_time"] * scale[run["time_unit"]])
        if "ratio" in run:
            ratios.setdefault(name, []).append(run["ratio"])
        if "realtime_factor" in run:
            factors.setdefault(name, []).append(run["realtime_factor"])
    least = {name: min(values) for name, values in times.items()}
    medians = {name: statistics.median(values) for name, values in ratios.items()}
    return least | medians | {name: max(values) for name, values in factors.items()}


def unit(name: str) -> str:
    return "x" if name.endswith("_ratio") or name.startswith("scenario/") else "ns"


def met(target: Target, value: float) -> bool:
    return value <= target.limit if target.at_most else value >= target.limit


def main() -> int:
    parser = argparse.ArgumentParser(prog="bench", description=__doc__)
    parser.add_argument("file", help="JSON of Google Benchmark")
    parser.add_argument("--judge", action="store_true", help="exit status 1 when a target is missed")
    arguments = parser.parse_args()
    times = figures(json.loads(Path(arguments.file).read_text(encoding="utf-8")))
    for name, value in times.items():
        print(f"{name:<34} {value:>14.2f} {unit(name)}")
    print()
    missed = 0
    for target in TARGETS:
        value = target.value(times)
        judged = target.limit != float("inf")
        good = met(target, value)
        missed += not good
        bound = f"{'<=' if target.at_most else '>='} {target.limit:g}" if judged else ""
        verdict = ("ok" if good else "MISSED") if judged else ""
        print(f"{target.name:<38} {value:>8.2f} {target.unit:<3} {bound:<8} {verdict}")
    return 1 if arguments.judge and missed else 0


if __name__ == "__main__":
    sys.exit(main())
