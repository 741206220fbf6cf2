"""docs/images/latency.png: how late the control thread wakes, beside cyclictest; and how late a command acts."""

from pathlib import Path

from matplotlib.ticker import NullFormatter

from sextant_py.paper_style import EXACT, PAPER, REFERENCE, SAMPLED, THIRD, save, sheet

from .histogram import Histogram

COLOURS = (REFERENCE, EXACT, SAMPLED, PAPER, THIRD)


def draw_latency(wakes: dict[str, Histogram], commands: dict[str, Histogram], file: Path) -> None:
    """Both by what the legend says of them."""
    figure, ((left, right),) = sheet(1, 2, 3.8)
    for axes, curves, title in (
        (left, wakes, "deadline to wake-up, every 250 µs"),
        (right, commands, "CAN frame received to first gate pattern"),
    ):
        for colour, (label, histogram) in zip(COLOURS, curves.items(), strict=False):
            durations, parts = histogram.exceeded()
            axes.step(durations, parts, where="pre", color=colour, label=f"{label}, n = {histogram.count}")
        axes.set(title=title, xlabel="longer than [µs]", ylabel="part of all", xscale="log", yscale="log")
        if curves:
            axes.legend(loc="lower left", fontsize="small")
        axes.xaxis.set_major_formatter("{x:g}")
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.autoscale_view()
        axes.set_ylim(0.02 / max((h.count for h in curves.values()), default=1), 1.5)  # the legend is below
    save(figure, file)
