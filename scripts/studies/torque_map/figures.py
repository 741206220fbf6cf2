"""Pictures of the torque map."""

import math
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, ListedColormap, LogNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from studies.picture import picture

from . import points
from .capability import largest_torque, limits_from
from .drive import GUARANTEED
from .points import Conditions
from .results import BRIEF, DERATED, FAILED, OFF, SILENT, TRIPPED, UNOBSERVABLE_RAD_S, UNSEEN, MapOf, Results, tolerance

WIDTH = 9.6
RATIO = LogNorm(1 / 32, 32)  # deviation by tolerance: up to 1 blue, beyond it red
COLOURS = LinearSegmentedColormap.from_list(
    "deviation", [(0, "#c6dbef"), (0.5, "#f4f8fc"), (0.5, "#fdc9a8"), (0.75, "#d7301f"), (1, "#5e0000")]
)
PLAIN = {BRIEF: "#ffe8a3", TRIPPED: "#b9a3d0", OFF: "#d4d4d4", FAILED: "#000000"}
SHOWN_SPEEDS = (-400, -200, -100, -35, 0, 35, 100, 200, 400)
ANALYTIC = {"color": "#111111", "linestyle": "--", "linewidth": 1}
# Colour, mark and its size of the drives; those that publish the same are seen around each other.
MARKS = (("#e08e2b", "s", 8.0), ("#1b4f9c", "o", 5.5), ("#4a9a5a", "^", 3.0))
Maps = dict[str, Results]


def _maps(file: Path, rows: int, columns: int, height: float) -> AbstractContextManager[tuple[Figure, np.ndarray]]:
    style = {"axes.grid": False, "font.size": 8.5, "axes.titlesize": 9}
    return picture(file, rows, columns, (WIDTH, height), style, sharex=True, sharey=True)


def _ticks(axes: Axes, results: Results, at: tuple[float, ...] = SHOWN_SPEEDS) -> None:
    shown = [k for k, speed in enumerate(results.speeds) if speed in at]
    axes.set_xticks(shown, [f"{results.speeds[k]:g}" for k in shown], fontsize=6.5)
    axes.set_yticks(range(len(results.torques)), [f"{torque:g}" for torque in results.torques], fontsize=7)
    axes.tick_params(length=2)


def zero_frequency_speed(results: Results, torque: float) -> float:
    """Mechanical speed at which the stator frequency p ω_m + ω_slip is zero, at the reference flux. [rad/s]"""
    m = results.capability["limits"]
    sigma, tau_r = 1 - m["l_m"] ** 2 / (m["l_s"] * m["l_r"]), m["l_r"] / m["r_r"]
    breakdown = 0.75 * m["pole_pairs"] * m["flux"] ** 2 * (1 - sigma) / (sigma * m["l_s"])
    share = max(-1.0, min(1.0, torque / breakdown))
    slip = share / (1 + math.sqrt(1 - share * share)) / (sigma * tau_r)
    return -slip / m["pole_pairs"]


def _mark_zero_frequency(axes: Axes, results: Results) -> None:
    """The region in which errors of R_r and L_m may be invisible, and where the stator frequency is zero."""
    columns = np.arange(len(results.speeds))
    for end in (-UNOBSERVABLE_RAD_S, UNOBSERVABLE_RAD_S):
        side = results.speeds.index(end) + math.copysign(0.5, end)
        axes.axvline(side, color="#333333", linewidth=0.7, linestyle=":")
    if results.capability:
        speeds = [zero_frequency_speed(results, torque) for torque in results.torques]
        axes.plot(np.interp(speeds, results.speeds, columns), range(len(speeds)), color="#333333", linewidth=0.7)


def panel(axes: Axes, results: Results, one: MapOf) -> object:
    """Deviation by tolerance, and what the drive did where that is not the answer."""
    ratio = np.full((len(results.torques), len(results.speeds)), np.nan)
    for row, (torque, values) in enumerate(zip(results.torques, one.deviations, strict=True)):
        ratio[row] = [np.nan if value is None else max(value, 1e-3) / tolerance(torque) for value in values]
    image = axes.imshow(ratio, origin="lower", aspect="auto", cmap=COLOURS, norm=RATIO, interpolation="nearest")
    letters = np.array([list(row) for row in one.outcomes])
    for letter, colour in PLAIN.items():
        cover = np.ma.masked_where(letters != letter, np.ones(letters.shape))
        axes.imshow(cover, origin="lower", aspect="auto", cmap=ListedColormap([colour]), interpolation="nearest")
    for letter, marker, colour, size in (
        (SILENT, "x", "#000000", 6),
        (UNSEEN, "+", "#000000", 6),
        (DERATED, ".", "#1c7c3c", 3),
    ):
        rows, columns = np.nonzero(letters == letter)
        axes.scatter(columns, rows, marker=marker, color=colour, s=size, linewidths=0.6)
    _mark_zero_frequency(axes, results)
    return image


def _legend(figure: Figure) -> None:
    names = {BRIEF: "deviates for 10 ms at most", TRIPPED: "tripped in time", OFF: "gates off, as published"}
    handles: list[object] = [Patch(color=PLAIN[letter], label=name) for letter, name in names.items()]
    for marker, label in (
        ("x", "silently wrong"),
        ("+", "unobservable, wrong"),
        (".", "derated"),
    ):
        colour = "#1c7c3c" if marker == "." else "#000000"
        handles.append(Line2D([], [], linestyle="", marker=marker, color=colour, markersize=5, label=label))
    handles += _lines()
    figure.legend(
        handles=handles, loc="outside lower center", ncols=8, fontsize=6.8, columnspacing=0.9, handletextpad=0.4
    )


def _lines() -> list[Line2D]:
    """The entries of a legend for what _mark_zero_frequency draws."""
    return [
        Line2D([], [], color="#333333", linewidth=0.8, label="stator frequency zero"),
        Line2D([], [], color="#333333", linewidth=0.8, linestyle=":", label=f"±{UNOBSERVABLE_RAD_S:g} rad/s"),
    ]


def grid(
    rows: list[tuple[str, list[tuple[Results, MapOf]]]], file: Path, shown: tuple[float, ...] | None = None
) -> None:
    """A panel for each map; rows with a name. shown: the speeds of the ticks [rad/s]."""
    columns = max(len(maps) for _, maps in rows)
    at = shown or ((-200, -50, 0, 50, 200) if columns > 3 else SHOWN_SPEEDS)
    image = None
    with _maps(file, len(rows), columns, 0.75 + 1.75 * len(rows)) as (figure, panels):
        for (name, maps), line in zip(rows, panels, strict=True):
            for axes, (results, one) in zip(line, maps, strict=False):
                image = panel(axes, results, one)
                axes.set_title(one.conditions.label, fontsize=8 if columns < 4 else 7)
                _ticks(axes, results, at)
            line[0].set_ylabel(f"{name}\ncommand [N·m]", fontsize=8)
            for axes in line[len(maps) :]:
                axes.set_visible(False)
        for axes in panels[-1]:
            axes.set_xlabel("speed [rad/s]", fontsize=8)
        bar = figure.colorbar(image, ax=panels, pad=0.01, aspect=30, shrink=0.9)
        bar.set_ticks([1 / 16, 1 / 4, 1, 4, 16], labels=["1/16", "1/4", "1", "4", "16"])
        bar.set_label("deviation / tolerance", fontsize=8)
        _legend(figure)


def _found(results: Results, wanted: list[Conditions]) -> list[tuple[Results, MapOf]]:
    return [(results, one) for c in wanted if (one := results.find(c)) is not None]


def _axis(maps: Maps, keep: Callable[[Conditions], bool]) -> list[tuple[str, list[tuple[Results, MapOf]]]]:
    """Rows of one-factor sets: for each drive the machine's factors, and those that the controller believes."""
    rows = []
    for results in maps.values():
        for detune in points.DETUNES:
            wanted = [c for c in points.axes(detune=detune) if keep(c)]
            wanted = [Conditions() if c == Conditions(detune=detune) else c for c in wanted]
            rows.append(
                (results.label, _found(results, sorted(wanted, key=lambda c: (c.l_m != 1, c.r_s, c.r_r, c.l_m))))
            )
    return rows


def resistance(maps: Maps, file: Path) -> None:
    grid(_axis(maps, lambda c: c.r_r == c.l_m == 1), file)


def rotor(maps: Maps, file: Path) -> None:
    grid(_axis(maps, lambda c: c.r_r != 1 or c.l_m != 1), file)


def all_corners(maps: Maps, file: Path) -> None:
    results = maps[GUARANTEED]
    rows = []
    for detune in points.DETUNES:
        found = _found(results, points.corners(detune=detune))
        rows += [(results.label, found[:4]), (results.label, found[4:])]
    grid(rows, file)


def surroundings(maps: Maps, file: Path) -> None:
    alone = (points.SENSORS_ALONE, points.DELAY_ALONE, points.FREE_ALONE)
    wanted = [Conditions(**around) for around in (*alone, points.ALL_AROUND)]
    grid([(results.label, found) for results in maps.values() if (found := _found(results, wanted))], file)


def share_of_silent(maps: Maps, file: Path) -> None:
    """In how many of all sets a point is silently wrong."""
    image = None
    with _maps(file, 1, len(maps), 3.1) as (figure, panels):
        for axes, results in zip(panels[0], maps.values(), strict=True):
            letters = np.array([[list(row) for row in one.outcomes] for one in results.maps])
            share = 100 * (letters == SILENT).mean(axis=0)
            look = {"cmap": "magma_r", "vmin": 0, "vmax": 100, "interpolation": "nearest"}
            image = axes.imshow(share, origin="lower", aspect="auto", **look)
            axes.set_title(f"{results.label}: {results.counts[SILENT]} of {results.points} points")
            _ticks(axes, results)
            _mark_zero_frequency(axes, results)
            axes.set_xlabel("speed [rad/s]")
        panels[0][0].set_ylabel("command [N·m]")
        bar = figure.colorbar(image, ax=panels, pad=0.01)
        bar.set_label("sets in which the point\nis silently wrong [%]", fontsize=8)
        figure.legend(handles=_lines(), loc="outside lower center", ncols=2, fontsize=7)


def capability(maps: Maps, file: Path) -> None:
    """What each drive publishes at exact parameters, and what the circuit allows."""
    limits = limits_from(maps[GUARANTEED].capability["limits"])
    speeds = np.linspace(-400, 400, 161)
    names = [*(results.label for results in maps.values()), f"analytic, limits of {maps[GUARANTEED].label}"]
    with picture(file, 1, 2, (WIDTH, 3.6), sharey=True) as (figure, (panels,)):
        for axes, direction, sign in zip(panels, ("motoring", "regenerating"), (1, -1), strict=True):
            for results, (colour, marker, size) in zip(maps.values(), MARKS, strict=False):
                published = [math.nan if value is None else value for value in results.capability[direction]]
                axes.plot(results.speeds, published, color=colour, marker=marker, markersize=size, linewidth=1)
            axes.plot(speeds, [largest_torque(limits, abs(speed), sign) for speed in speeds], **ANALYTIC)
            axes.set_title(direction)
            axes.set_xlabel("speed [rad/s]")
        panels[0].set_ylabel("available torque [N·m]")
        figure.legend(panels[0].lines, names, loc="outside lower center", ncols=4, fontsize=8.5)


PICTURES: dict[str, Callable[[Maps, Path], None]] = {
    "silent": share_of_silent,
    "stator_resistance": resistance,
    "rotor_and_field": rotor,
    "corners": all_corners,
    "surroundings": surroundings,
    "capability": capability,
}
