"""The pictures of the bench of control methods."""

from pathlib import Path

from .controller_bench import Results
from .figure_style import STYLE

TITLES = {"sampling": "every method at 25 µs", "switching": "every method near 10 kHz"}


def _values(results: Results, section: str, method: str) -> tuple[list, list, list[list[float]]]:
    records = results.of(section, method)
    speeds = sorted({record.what[0] for record in records})
    torques = sorted({record.what[1] for record in records})
    found = {tuple(r.what): r.metrics.get("torque_ripple_rms_nm") for r in records if not r.reason}
    grid = [[found.get((s, t)) or float("nan") for s in speeds] for t in torques]
    return speeds, torques, grid


def _draw(results: Results, section: str, file: Path) -> None:
    import matplotlib as mpl
    import matplotlib.pyplot as plt
    from matplotlib.colors import LogNorm

    with mpl.rc_context(STYLE | {"axes.grid": False}):
        count = len(results.methods)
        columns = min(count, 3)
        rows = -(-count // columns)
        figure, axes = plt.subplots(
            rows, columns, figsize=(3.6 * columns + 1, 2.7 * rows + 0.4), squeeze=False, sharey=True
        )
        for number, method in enumerate(results.methods):
            ax = axes[number // columns][number % columns]
            speeds, torques, grid = _values(results, section, method)
            image = ax.imshow(grid, origin="lower", aspect="auto", cmap="viridis", norm=LogNorm(0.05, 10))
            ax.set_xticks(range(0, len(speeds), 2), [f"{s:g}" for s in speeds[::2]])
            ax.set_yticks(range(len(torques)), [f"{t:g}" for t in torques])
            period = 25 if section == "sampling" else results.periods_us[method]
            ax.set_title(f"{method}, {period:g} µs")
            ax.set_xlabel("speed [rad/s]")
            if number % columns == 0:
                ax.set_ylabel("torque [N·m]")
        for number in range(count, rows * columns):
            axes[number // columns][number % columns].set_visible(False)
        figure.colorbar(image, ax=axes, label="torque ripple, RMS [N·m]")
        figure.suptitle(TITLES[section], x=0.01, ha="left")
        figure.savefig(file)
        plt.close(figure)


def draw(results: Results, directory: Path) -> list[Path]:
    files = []
    for section in TITLES:
        file = directory / f"controllers_{section}.png"
        _draw(results, section, file)
        files.append(file)
    return files
