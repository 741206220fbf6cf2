"""What a scenario expects, as sextant-mil reads it: its own reader checks names, ranges, windows and units."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from . import printed_configuration

NO_FAULT = "none"


@dataclass(frozen=True)
class Window:
    """Both ends included; to_s None: to the end of the run. [s]"""

    from_s: float
    to_s: float | None

    def __str__(self) -> str:
        """As sextant-mil writes it."""
        return f"{self.from_s:g} s to {'the end' if self.to_s is None else f'{self.to_s:g} s'}"


@dataclass(frozen=True)
class Limit:
    metric: str
    low: float | None
    high: float | None
    window: Window
    is_own: bool  # the window is that of [[expect.window]]

    @property
    def text(self) -> str:
        """As sextant-mil writes it."""
        if self.low is None:
            return f"≤ {self.high:g}"
        return f"≥ {self.low:g}" if self.high is None else f"{self.low:g} … {self.high:g}"

    @property
    def name(self) -> str:
        own = f", {self.window}" if self.is_own else ""
        return f"{self.metric}{own} {self.text}"


@dataclass(frozen=True)
class Scenario:
    name: str
    limits: tuple[Limit, ...]
    fault: str | None  # that has to come first
    fault_window: Window
    step_s: float | None
    duration_s: float

    @property
    def expects_something(self) -> bool:
        return bool(self.limits) or self.fault is not None


def _limits(table: dict[str, Any], window: Window, is_own: bool) -> list[Limit]:
    return [
        Limit(metric, limit.get("min"), limit.get("max"), window, is_own)
        for metric, limit in table.items()
        if isinstance(limit, dict) and limit
    ]


def of_printed(tree: dict[str, Any]) -> Scenario:
    """Of what --print-config prints."""
    expect, metrics = tree["expect"], tree["metrics"]
    limits = _limits(expect, Window(metrics["window_from_s"], metrics.get("window_to_s")), False)
    for own in expect.get("window", []):
        limits += _limits(own, Window(own["from_s"], own.get("to_s")), True)
    fault = None if expect["fault"] == NO_FAULT else expect["fault"]
    window = Window(expect["fault_from_s"], expect.get("fault_to_s"))
    return Scenario(tree["name"], tuple(limits), fault, window, metrics.get("step_s"), tree["duration_s"])


def read(program: Path, file: Path, settings: list[str]) -> Scenario:
    """UserError: sextant-mil refuses the scenario."""
    words = [word for setting in settings for word in ("--set", setting)]
    return of_printed(printed_configuration.tables_of(program, file, words))
