"""docs/images/growth.png, what N drives of one process cost; and latency.png, how late the control thread wakes beside
cyclictest, and how late a command acts."""

import numpy as np
from matplotlib.ticker import LogLocator, NullFormatter
from sextant_py.plots.sheets import EXACT, PAPER, REFERENCE, SAMPLED, THIRD

from studies.picture import Sheets

from .histogram import Histogram

FEW_TICKS = 300.0  # ratio of the ends of a logarithmic axis, below which its powers of ten are too few ticks
PICTURES = Sheets()


@PICTURES.sheet(1, 2, 3.2)
def draw_growth(cost_us: dict[int, float], panels: np.ndarray) -> None:
    """cost_us: CPU time [µs] of a simulated millisecond of one drive, by the number of drives."""
    ((left, right),) = panels
    sizes = sorted(cost_us)
    alone = cost_us[sizes[0]]
    total = [n * cost_us[n] * 1e-3 for n in sizes]
    left.loglog(sizes, [n * alone * 1e-3 for n in sizes], color=REFERENCE, lw=0.8, label="N times one drive")
    left.loglog(sizes, total, "o", color=EXACT, label="measured")
    left.set(title="all drives together", ylabel="CPU time per simulated time [s/s]")
    left.legend()
    right.semilogx(sizes, [cost_us[n] / alone for n in sizes], "o-", color=EXACT)
    right.axhline(1.0, color=REFERENCE, lw=0.8)
    right.set(title="each of them", ylabel="cost of a drive by that of one alone", ylim=(0, 1.5))
    for axes in (left, right):
        axes.set_xlabel("drives in the process, N")
        axes.set_xticks(sizes, [str(n) for n in sizes])
        axes.minorticks_off()
        axes.set_xmargin(0.05)
        axes.autoscale_view()


@PICTURES.sheet(1, 2, 3.8)
def draw_latency(wakes: dict[str, Histogram], commands: dict[str, Histogram], panels: np.ndarray) -> None:
    """Both by what the legend says of them."""
    titles = ("deadline to wake-up, every 250 µs", "CAN frame received to first gate pattern")
    for axes, curves, title in zip(panels[0], (wakes, commands), titles, strict=True):
        for colour, (label, histogram) in zip((REFERENCE, EXACT, SAMPLED, PAPER, THIRD), curves.items(), strict=False):
            durations, parts = histogram.exceeded()
            axes.step(durations, parts, where="pre", color=colour, label=f"{label}, n = {histogram.count}")
        axes.set(title=title, xlabel="longer than [µs]", ylabel="part of all", xscale="log", yscale="log")
        if curves:
            axes.legend(loc="lower left", fontsize="small")
        axes.autoscale_view()
        left, right = axes.get_xlim()
        axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5) if right < FEW_TICKS * left else (1,), numticks=12))
        axes.xaxis.set_major_formatter("{x:g}")
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.set_ylim(0.02 / max((h.count for h in curves.values()), default=1), 1.5)  # the legend is below
