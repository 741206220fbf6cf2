"""The timing of a control thread: the file of sextant-ecu --timing-out."""

from pathlib import Path
from typing import Any

from ..errors import UserError
from .model import BAD, NEUTRAL, Run, Table, shown

PERCENTILES = ("p50_ns", "p99_ns", "p99_9_ns", "p99_99_ns", "max_ns")
HEAD = ("time [µs]", "count", "median", "99 %", "99.9 %", "99.99 %", "largest")
HISTOGRAMS = {
    "wake_latency": "wake-up latency",
    "execution": "execution time",
    "command_to_gate": "command to gate",
    "command_hand_over": "command hand-over",
}


def is_timing(content: Any) -> bool:
    return isinstance(content, dict) and {"wake_latency", "execution", "periods"} <= content.keys()


def _row(name: str, histogram: dict[str, float]) -> tuple[str, ...]:
    return name, str(histogram["count"]), *(f"{histogram[key] / 1e3:.1f}" for key in PERCENTILES)


def read(path: Path, content: dict[str, Any]) -> Run:
    try:
        rows = [_row(text, content[key]) for key, text in HISTOGRAMS.items() if key in content]
        rows += [_row(f"stage {name}", histogram) for name, histogram in content.get("stages", {}).items()]
        missed = content["periods_missed"]
        run = Run(
            path.stem, "timing of the control thread", path, f"{missed} periods missed", BAD if missed else NEUTRAL
        )
        facts = ("periods", "periods_missed", "overruns", "overruns_without_gap", "gaps", "longest_gap_ns")
        run.facts = [(key.replace("_", " "), shown(content[key])) for key in facts if key in content]
        causes = tuple((name, shown(count)) for name, count in content.get("overruns_by_cause", {}).items())
    except (KeyError, TypeError, AttributeError):
        raise UserError(f"{path} is no whole file of sextant-ecu --timing-out.") from None
    run.tables = [Table("Times of a wake-up", HEAD, tuple(row for row in rows if row[1] != "0"))]
    if causes:
        run.tables.append(Table("Overruns by cause", ("cause", "overruns"), causes))
    return run
