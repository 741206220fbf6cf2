"""The picture of the torque step of both drives."""

from pathlib import Path

from studies.picture import picture

from .cases import SHOWN
from .measure import Results

DRIVES = {"motulator": ("motulator", "#d95f02"), "sextant": ("Sextant", "#1b4f9c")}


def _panel(axes, curves: dict, period_us: str) -> None:
    for name, (label, colour) in DRIVES.items():
        one = curves[name]
        axes.fill_between(one["end_ms"], one["min"], one["max"], step="pre", color=colour, alpha=0.25, linewidth=0)
        half_ms = 0.5e-3 * float(period_us)
        middle = [end - half_ms for end in one["end_ms"]]
        axes.plot(middle, one["mean"], color=colour, linewidth=1.4, label=f"{label}: mean, range")
    axes.axhline(0.95 * SHOWN[1], color="grey", linewidth=0.8, linestyle="--", label="95 % of the step")
    axes.set_title(f"control period {period_us} µs")
    axes.set_xlabel("time after the step [ms]")


def draw(results: Results, file: Path) -> Path:
    count = len(results.curves)
    with picture(file, 1, count, (3.9 * count, 3.6), sharey=True) as (_, axes):
        periods = sorted(results.curves, key=float, reverse=True)
        for ax, period_us in zip(axes[0], periods, strict=True):
            _panel(ax, results.curves[period_us], period_us)
        axes[0][0].set_ylabel("torque [N·m]")
        axes[0][0].legend(loc="lower right")
    return file
