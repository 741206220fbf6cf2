"""Pictures of a sweep: a metric against one key as a line or points, against two as a heat map or coloured points."""

import itertools
import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from .errors import UserError
from .figure_style import STYLE
from .sweep_file import Sweep, shown
from .sweep_point import EXPECT_FAILED, FAILED
from .sweep_store import SweepStore

OK_COLOUR, MISSED_COLOUR, FAILED_COLOUR = "#1b4f9c", "#d95f02", "#b0b0b0"
LARGEST_LABELLED = 120  # cells with their value written in
TEXTS = ((4, 9.0), (3, 9.0), (3, 7.5), (2, 7.5), (2, 6.0))  # significant digits and size of the values in cells
COLUMN_IN, LARGEST_IN = 0.6, 16.0  # a column of a heat map; the width of a picture
FOOTNOTE = "* an [expect] of the scenario does not hold   × failed or without a value"


@dataclass
class Axis:
    """A key as a position on an axis. Numbers are themselves; anything else is a place in a list."""

    key: str
    unit: str
    log: bool
    values: list[Any]  # of every point
    ticks: list[Any] = field(init=False)

    def __post_init__(self) -> None:
        self.ticks = list({shown(value): value for value in self.values}.values())
        if self.is_number:
            self.ticks.sort()

    @property
    def is_number(self) -> bool:
        return all(isinstance(value, int | float) and not isinstance(value, bool) for value in self.values)

    @property
    def label(self) -> str:
        return f"{self.key} [{self.unit}]" if self.unit else self.key

    def texts(self) -> list[str]:
        return [f"{value:.4g}" if self.is_number else shown(value).strip('"') for value in self.ticks]

    def index(self) -> np.ndarray:
        places = {shown(value): place for place, value in enumerate(self.ticks)}
        return np.array([places[shown(value)] for value in self.values])

    def positions(self) -> np.ndarray:
        return np.array(self.values, dtype=float) if self.is_number else self.index().astype(float)

    def dress(self, axes: Axes, side: str) -> None:
        """Scale, ticks and label of the side, x or y, that shows positions."""
        label = {f"{side}label": self.label}
        if not self.is_number:
            axes.set(**label, **{f"{side}ticks": range(len(self.ticks)), f"{side}ticklabels": self.texts()})
        else:
            axes.set(**label, **{f"{side}scale": "log" if self.log else "linear"})
        if self.log:
            which = axes.xaxis if side == "x" else axes.yaxis
            which.set_major_locator(LogLocator(subs=(1, 2, 5)))
            which.set_major_formatter("{x:g}")
            which.set_minor_formatter(NullFormatter())


@dataclass
class Data:
    """A metric of every point: nan where there is none."""

    label: str
    values: np.ndarray
    missed: np.ndarray  # an [expect] does not hold
    failed: np.ndarray

    @property
    def drawn(self) -> np.ndarray:
        return ~self.failed & np.isfinite(self.values)


def collect(sweep: Sweep, store: SweepStore, metric: str, unit: str) -> Data:
    records = [store.records.get(k, {"status": FAILED, "metrics": {}}) for k in range(len(sweep.points))]
    values = [record["metrics"].get(metric) for record in records]
    return Data(
        f"{metric} [{unit}]" if unit else metric,
        np.array([math.nan if value is None else value for value in values], dtype=float),
        np.array([record["status"] == EXPECT_FAILED for record in records]),
        np.array([record["status"] == FAILED for record in records]),
    )


def heat_map(axes: Axes, x: Axis, y: Axis, data: Data) -> bool:
    """Cells of a grid: the mean over the points in each. Whether any cell needs the footnote."""
    shape = (len(y.ticks), len(x.ticks))
    total, count, missed = np.zeros(shape), np.zeros(shape), np.zeros(shape, dtype=bool)
    places = y.index(), x.index()
    drawn = data.drawn
    np.add.at(total, (places[0][drawn], places[1][drawn]), data.values[drawn])
    np.add.at(count, (places[0][drawn], places[1][drawn]), 1)
    missed[places[0][data.missed], places[1][data.missed]] = True
    cells = np.full(shape, math.nan)
    np.divide(total, count, out=cells, where=count > 0)
    axes.set_facecolor("#eeeeee")
    image = axes.imshow(cells, origin="lower", aspect="auto", cmap="viridis")
    axes.figure.colorbar(image, ax=axes, label=data.label)
    for axis, which in ((x, axes.xaxis), (y, axes.yaxis)):
        step = -(-len(axis.ticks) // 12)
        which.set_ticks(range(0, len(axis.ticks), step), axis.texts()[::step])
        which.set_label_text(axis.label)
    axes.grid(visible=False)
    if cells.size > LARGEST_LABELLED:
        return False
    write_cells(axes, cells, missed)
    return bool(missed.any() or np.isnan(cells).any())


def write_cells(axes: Axes, cells: np.ndarray, missed: np.ndarray) -> None:
    """The values into their cells with as many digits as the cells have room for; without room the marks alone."""
    middle = np.nanmean([np.nanmin(cells), np.nanmax(cells)]) if np.isfinite(cells).any() else 0.0
    marks = {place: "*" if missed[place] else "" for place in np.ndindex(cells.shape)}
    texts = {
        (row, place): axes.text(
            place, row, "", ha="center", va="center", color="white" if cells[row, place] < middle else "black"
        )
        for row, place in marks
    }
    axes.figure.canvas.draw()  # the layout has given the cells their size
    renderer = axes.figure.canvas.get_renderer()
    width, height = np.abs(np.diff(axes.transData.transform([(0, 0), (1, 1)]), axis=0)[0])
    for digits, size in (*TEXTS, (0, 9.0)):
        for place, text in texts.items():
            value = f"{float(f'{cells[place]:.{digits}g}'):g}" if digits else ""  # no exponent below a million
            text.set(text=f"{value}{marks[place]}" if math.isfinite(cells[place]) else "×", fontsize=size)
        boxes = [text.get_window_extent(renderer) for text in texts.values() if text.get_text()]
        if all(box.width < 0.95 * width and box.height < height for box in boxes):
            return


def clear_ticks(axes: Axes) -> None:
    """Turns the texts of the x axis where they would run into each other."""
    axes.figure.canvas.draw()
    renderer = axes.figure.canvas.get_renderer()
    boxes = [label.get_window_extent(renderer) for label in axes.get_xticklabels() if label.get_text()]
    boxes.sort(key=lambda box: box.x0)
    if any(right.x0 < left.x1 + 4 for left, right in itertools.pairwise(boxes)):
        plt.setp(axes.get_xticklabels(), rotation=40, ha="right", rotation_mode="anchor")


def points_along(axes: Axes, x: Axis, data: Data, joined: bool) -> None:
    """A metric against one key; joined where the points are a grid's."""
    where, drawn = x.positions(), data.drawn
    if joined and drawn.any():
        ticks = np.unique(where[drawn])
        means = [data.values[drawn & (where == tick)].mean() for tick in ticks]
        axes.plot(ticks, means, color=OK_COLOUR, linewidth=1.2, zorder=1)
    good, missed = drawn & ~data.missed, drawn & data.missed
    axes.scatter(where[good], data.values[good], s=22, color=OK_COLOUR, zorder=2)
    if missed.any():
        axes.scatter(
            where[missed], data.values[missed], s=26, facecolors="white", edgecolors=MISSED_COLOUR, zorder=2,
            label="an [expect] does not hold",
        )  # fmt: skip
    gone = ~drawn
    if gone.any():
        bottom = np.zeros(int(gone.sum()))
        axes.scatter(
            where[gone], bottom, s=26, marker="x", color=FAILED_COLOUR, clip_on=False, zorder=3,
            transform=axes.get_xaxis_transform(), label="failed or without a value",
        )  # fmt: skip
    x.dress(axes, "x")
    axes.set_ylabel(data.label)


def coloured_points(axes: Axes, x: Axis, y: Axis, data: Data) -> None:
    """The points of a sample or a list, or of keys that move together, over two keys."""
    across, up, drawn = x.positions(), y.positions(), data.drawn
    edges = np.where(data.missed, MISSED_COLOUR, "none")
    points = axes.scatter(across[drawn], up[drawn], c=data.values[drawn], s=36, cmap="viridis", edgecolors=edges[drawn])
    axes.figure.colorbar(points, ax=axes, label=data.label)
    if data.missed.any():
        axes.scatter([], [], s=36, facecolors="none", edgecolors=MISSED_COLOUR, label="an [expect] does not hold")
    if (~drawn).any():
        axes.scatter(across[~drawn], up[~drawn], marker="x", color=FAILED_COLOUR, label="failed or without a value")
    x.dress(axes, "x")
    y.dress(axes, "y")


def keys_to_draw(sweep: Sweep) -> list[str]:
    """Those that the file names, or those that take more than one value, one of keys that move together: two of a
    grid, all of a sample or a list."""
    if sweep.plot.keys:
        return sweep.plot.keys
    counts = {key: len({shown(point[key]) for point in sweep.points}) for key in sweep.varied}
    # Of keys that move together the first one that tells most points apart.
    varied = [key for group in sweep.groups() if counts[key := max(group, key=counts.get)] > 1]
    varied = varied or sweep.varied[:1]
    return varied[:2] if sweep.kind == "grid" else varied


def fill_a_map(sweep: Sweep, keys: list[str]) -> bool:
    """Whether the points have every combination of two keys."""
    return len(keys) == 2 and sweep.kind == "grid" and not any(set(keys) <= set(group) for group in sweep.groups())


def averaged(sweep: Sweep, keys: list[str]) -> list[str]:
    """The keys that take several values where the drawn ones have one."""
    of_place: dict[tuple, dict[str, set]] = {}
    for point in sweep.points:
        values = of_place.setdefault(tuple(shown(point[key]) for key in keys), {key: set() for key in sweep.varied})
        for key in sweep.varied:
            values[key].add(shown(point[key]))
    return [key for key in sweep.varied if any(len(values[key]) > 1 for values in of_place.values())]


def heading(sweep: Sweep, keys: list[str]) -> str:
    has_means = (len(keys) == 1 and sweep.kind == "grid") or fill_a_map(sweep, keys)
    others = averaged(sweep, keys) if has_means else []
    seed = "" if sweep.seed is None else f", seed {sweep.seed}"
    text = f"{sweep.name}: {sweep.kind} of {len(sweep.points)} points{seed}"
    return text + (f"\nmean over {', '.join(others)}" if others else "")


def panels(count: int, cells: int = 0) -> tuple[Figure, list[Axes]]:
    """The panels; a heat map of `cells` columns is as wide as these need."""
    columns = 2 if count == 4 else min(count, 3)
    rows = -(-count // columns)
    width = max(7.5, min(COLUMN_IN * cells + 2.5, LARGEST_IN)) if columns == 1 else 5.2 * columns
    figure, grid = plt.subplots(rows, columns, squeeze=False, figsize=(width, 5.2 * rows))
    for spare in grid.flat[count:]:
        spare.set_visible(False)
    return figure, list(grid.flat[:count])


def draw(sweep: Sweep, store: SweepStore, metric: str, units: dict[str, str]) -> Figure:
    data = collect(sweep, store, metric, units.get(metric, ""))
    keys = keys_to_draw(sweep)
    axes_of = [
        Axis(key, units.get(key, ""), key in sweep.log_keys, [point[key] for point in sweep.points]) for key in keys
    ]
    plt.rcParams.update(STYLE)
    is_map = fill_a_map(sweep, keys)
    figure, grid = panels(1 if len(keys) == 2 else len(keys), len(axes_of[0].ticks) if is_map else 0)
    if len(keys) != 2:
        for axes, axis in zip(grid, axes_of, strict=True):
            points_along(axes, axis, data, joined=sweep.kind == "grid")
    elif not is_map:
        coloured_points(grid[0], *axes_of, data)
    elif heat_map(grid[0], *axes_of, data):
        figure.supxlabel(FOOTNOTE, fontsize=8, color="grey")
    handles, labels = grid[0].get_legend_handles_labels()
    if labels:
        figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), fontsize=9, frameon=False)
    figure.suptitle(heading(sweep, keys), fontsize=11)
    for axes in grid:
        clear_ticks(axes)
    return figure


def write(sweep: Sweep, store: SweepStore, directory: Path, units: dict[str, str]) -> list[Path]:
    """One picture for each metric that the file names."""
    written = []
    for metric in sweep.plot.metrics:
        figure = draw(sweep, store, metric, units)
        file = directory / f"{metric}.png"
        try:
            figure.savefig(file)
        except OSError as error:
            raise UserError(f"the plot {file} cannot be written: {error.strerror}.") from None
        finally:
            plt.close(figure)
        written.append(file)
    return written
