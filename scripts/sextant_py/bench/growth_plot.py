"""docs/images/growth.png: what N drives of one process cost."""

from pathlib import Path

from sextant_py.paper_style import EXACT, REFERENCE, save, sheet


def draw_growth(cost_us: dict[int, float], file: Path) -> None:
    """cost_us: CPU time [µs] of a simulated millisecond of one drive, by the number of drives."""
    figure, ((left, right),) = sheet(1, 2, 3.2)
    sizes = sorted(cost_us)
    alone = cost_us[sizes[0]]
    total = [n * cost_us[n] * 1e-3 for n in sizes]
    left.loglog(sizes, [n * alone * 1e-3 for n in sizes], color=REFERENCE, lw=0.8, label="N times one drive")
    left.loglog(sizes, total, "o", color=EXACT, label="measured")
    left.set(title="all drives", ylabel="CPU time per simulated time", xlabel="drives in the process, N")
    left.legend()
    right.semilogx(sizes, [cost_us[n] / alone for n in sizes], "o-", color=EXACT)
    right.axhline(1.0, color=REFERENCE, lw=0.8)
    right.set(
        title="one of them", ylabel="cost of a drive / one alone", ylim=(0, 1.5), xlabel="drives in the process, N"
    )
    for axes in (left, right):
        axes.set_xticks(sizes, [str(n) for n in sizes])
        axes.minorticks_off()
        axes.set_xmargin(0.05)
        axes.autoscale_view()
    save(figure, file)
