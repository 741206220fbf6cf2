"""What a program of Google Benchmark measured."""

import re
import statistics

from .figure import Figure, failed

NS = {"ns": 1.0, "us": 1e3, "ms": 1e6, "s": 1e9}
FIXED_KEYS = {
    "family_index", "per_family_instance_index", "repetitions", "repetition_index", "threads", "iterations",
    "real_time", "cpu_time",
}  # fmt: skip


class GoogleResult:
    """By benchmark its repetitions: its counters, and as `cpu_ns` the CPU time of an item. A benchmark that reported an
    error has none."""

    def __init__(self, result: dict) -> None:
        self.counters: dict[str, dict[str, list[float]]] = {}
        self.errors: dict[str, str] = {}
        for run in result["benchmarks"]:
            if run.get("run_type") != "iteration":
                continue
            name = re.sub(r"/(iterations|repeats):\d+", "", run["run_name"])
            if run.get("error_occurred"):
                self.errors[name] = run.get("error_message", "it failed")
                continue
            counters = self.counters.setdefault(name, {})
            for key, value in run.items():
                if isinstance(value, int | float) and not isinstance(value, bool) and key not in FIXED_KEYS:
                    counters.setdefault(key, []).append(float(value))
            # Of one item where an iteration is several.
            items = run.get("items_per_second")
            counters.setdefault("cpu_ns", []).append(1e9 / items if items else run["cpu_time"] * NS[run["time_unit"]])

    def names(self, pattern: str) -> list[str]:
        return [name for name in self.counters if re.search(pattern, name)]

    def has(self, name: str, counter: str) -> bool:
        return name not in self.errors and counter in self.counters.get(name, {})

    def median(self, name: str, counter: str) -> float:
        return statistics.median(self.counters[name][counter])

    def figure(self, measure: str, name: str, counter: str, pick: str = "median", **options) -> Figure:
        """The counter of a benchmark, by its median, least or most over the repetitions.

        An error that the benchmark reported is a miss, and so is a benchmark that is gone."""
        if not self.has(name, counter):
            why = self.errors.get(name, f"the program has no benchmark {name} with a counter {counter}")
            return failed(measure, why, **options)
        pickers = {"median": statistics.median, "least": min, "most": max}
        return Figure(measure, pickers[pick](self.counters[name][counter]), **options)
