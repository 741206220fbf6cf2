"""What a program of Google Benchmark measured."""

import re
import statistics

from sextant_py.errors import UserError

from .figure import Figure

NS = {"ns": 1.0, "us": 1e3, "ms": 1e6, "s": 1e9}
Row = tuple[Figure, str, str, str]
PICK = {"median": statistics.median, "least": min, "most": max}


def row(name: str, counter: str, measure: str, unit: str, pick: str = "median", **more: object) -> Row:
    """A row of a stage's table: benchmark and counter, the figure with its target, which of the repetitions counts."""
    return Figure(measure, unit, **more), name, counter, pick


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
                if isinstance(value, int | float):
                    counters.setdefault(key, []).append(float(value))
            # Of one item where an iteration is several.
            items = run.get("items_per_second")
            counters.setdefault("cpu_ns", []).append(1e9 / items if items else run["cpu_time"] * NS[run["time_unit"]])

    def names(self, pattern: str) -> list[str]:
        return [name for name in self.counters if re.search(pattern, name)]

    def value(self, name: str, counter: str, pick: str = "median") -> float:
        """Over the repetitions. UserError: the benchmark reported an error, or is gone."""
        if name in self.errors or counter not in self.counters.get(name, {}):
            raise UserError(self.errors.get(name, f"the program has no benchmark {name} with a counter {counter}"))
        return PICK[pick](self.counters[name][counter])

    def figure(self, row: Figure, name: str, counter: str, pick: str = "median") -> Figure:
        try:
            return row.of(self.value(name, counter, pick), row.note)
        except UserError as error:
            return row.failed(error)
