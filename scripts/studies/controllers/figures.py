"""The pictures of the bench of control methods."""

import math
from pathlib import Path

from studies.picture import picture

from . import step
from .cases import REFERENCE
from .measure import Results

TITLES = {"sampling": "every method at 25 µs", "switching": "every method near 10 kHz"}


def _values(results: Results, section: str, method: str) -> tuple[list, list, list[list[float]]]:
    records = results.of(section, method)
    speeds = sorted({record.what[0] for record in records})
    torques = sorted({record.what[1] for record in records})
    found = {tuple(r.what): r.metrics.get("torque_ripple_rms_nm") for r in records if not r.reason}
    grid = [[found.get((s, t)) or float("nan") for s in speeds] for t in torques]
    return speeds, torques, grid


def _draw(results: Results, section: str, file: Path) -> None:
    from matplotlib.colors import LogNorm

    count = len(results.methods)
    columns = min(count, 3)
    rows = -(-count // columns)
    size = (3.6 * columns + 1, 2.7 * rows + 0.4)
    with picture(file, rows, columns, size, {"axes.grid": False}, sharey=True) as (figure, axes):
        for number, method in enumerate(results.methods):
            ax = axes[number // columns][number % columns]
            speeds, torques, grid = _values(results, section, method)
            image = ax.imshow(grid, origin="lower", aspect="auto", cmap="viridis", norm=LogNorm(0.02, 5))
            ax.set_xticks(range(0, len(speeds), 2), [f"{s:g}" for s in speeds[::2]])
            ax.set_yticks(range(len(torques)), [f"{t:g}" for t in torques])
            period = 25 if section == "sampling" else results.periods_us[method]
            ax.set_title(f"{method}, {period:g} µs")
            ax.set_xlabel("speed [rad/s]")
            if number % columns == 0:
                ax.set_ylabel("torque [N·m]")
        for number in range(count, rows * columns):
            axes[number // columns][number % columns].set_visible(False)
        figure.colorbar(image, ax=axes, extend="min", label="torque ripple, RMS [N·m]")
        figure.suptitle(TITLES[section], x=0.01, ha="left")


def radar_axes(results: Results) -> dict[str, dict[str, float | None]]:
    """What the radar shows, by axis and method; the less the better."""

    def metric(section: str, what: tuple, name: str) -> dict[str, float | None]:
        return {m: results.metric(section, m, what, name) for m in results.methods}

    return {
        "ripple\n25 µs": metric("sampling", REFERENCE, "torque_ripple_rms_nm"),
        "ripple\n10 kHz": metric("switching", REFERENCE, "torque_ripple_rms_nm"),
        "THD\n10 kHz": metric("switching", REFERENCE, "current_thd_percent"),
        "step\n25 µs": metric("sampling", REFERENCE, "response_time_ms"),
        "real\nsensors": metric("detuned", ("exact parameters", "real"), "torque_ripple_rms_nm"),
        "leakage\n×0.5": metric("detuned", ("leakage ×0.5", "real"), "torque_ripple_rms_nm"),
        "NYCC": metric("cycle", ("constant",), "torque_error_rms_nm"),
        "CPU\ntime": {m: results.step_ns.get(m) for m in results.methods},
    }


def _radar(results: Results, file: Path) -> None:
    axes_of = radar_axes(results)
    angles = [2 * math.pi * n / len(axes_of) for n in range(len(axes_of))]
    rows = -(-len(results.methods) // 4)
    size, polar = (11, 3.1 * rows + 0.4), {"projection": "polar"}
    with picture(file, rows, 4, size, subplot_kw=polar) as (figure, axes):
        for number, ax in enumerate(axes.flat):
            if number >= len(results.methods):
                ax.set_visible(False)
                continue
            method = results.methods[number]
            scores = [score(values, method) for values in axes_of.values()]
            ax.plot([*angles, angles[0]], [*scores, scores[0]], linewidth=1.5)
            ax.fill(angles, scores, alpha=0.2)
            ax.set_xticks(angles, axes_of, fontsize=7.5)
            ax.set_ylim(0, 1)
            ax.set_yticks((0.25, 0.5, 0.75, 1), ("", "", "", ""))
            ax.tick_params(axis="x", pad=7)  # the names of the axes stand clear of the circle
            ax.set_title(method, loc="center", pad=14)
        figure.suptitle(
            "each axis: the best of all methods outside, a tenth as good in the centre", x=0.01, ha="left", fontsize=10
        )


def score(values: dict[str, float | None], method: str) -> float:
    """1 for the least of all, 0 for ten times as much and more, by the logarithm; 0 without a figure."""
    known = [v for v in values.values() if v]
    value = values.get(method)
    return max(0.0, 1 - math.log10(value / min(known))) if value and known else 0.0


def draw(results: Results, directory: Path) -> list[Path]:
    files = [directory / f"controllers_{name}.png" for name in ("radar", "step")]
    _radar(results, files[0])
    step.draw(results.step, files[1])
    for section in TITLES:
        file = directory / f"controllers_{section}.png"
        _draw(results, section, file)
        files.append(file)
    return files
