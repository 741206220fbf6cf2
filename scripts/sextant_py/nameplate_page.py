"""The report of a name plate as one page of HTML, which needs no network and follows the reader's light or dark."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from html import escape
from pathlib import Path

import numpy as np

from .nameplate_files import title
from .nameplate_limits import Limits
from .nameplate_report import Row, tables
from .nameplate_spread import Variant

WIDTH, HEIGHT = 480, 300  # of a picture, in its own units
LEFT, RIGHT, TOP, BOTTOM = 48, 10, 14, 40
POINTS = 200
LEAST_SLIP = 1e-6

STYLE = """
:root { color-scheme: light dark; --back: #fcfcfb; --text: #1d2126; --soft: #5c6670; --line: #d5d9dd;
  --main: #1f5fa8; --limit: #b03a2e; --band: #1f5fa833; }
@media (prefers-color-scheme: dark) { :root { --back: #14181c; --text: #e4e7ea; --soft: #9aa5af; --line: #343b42;
  --main: #78b0ee; --limit: #f08a7c; --band: #78b0ee40; } }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 1240px; padding: 1rem; background: var(--back); color: var(--text);
  font: 15px/1.45 system-ui, sans-serif; }
h1 { font-size: 1.35rem; margin: 0 0 .3rem; } h2 { font-size: 1.05rem; margin: 1.6rem 0 .4rem; }
p { margin: .3rem 0; color: var(--soft); }
.pictures { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 360px), 1fr)); gap: 1rem; }
figure { margin: 0; } figcaption { color: var(--soft); font-size: .9rem; }
svg { width: 100%; height: auto; display: block; } svg text { fill: var(--text); font-size: 12px;
  paint-order: stroke; stroke: var(--back); stroke-width: 3px; stroke-linejoin: round; }
.grid { stroke: var(--line); stroke-width: 1; } .curve { fill: none; stroke: var(--main); stroke-width: 2; }
.band { fill: var(--band); } .limit { fill: none; stroke: var(--limit); stroke-width: 2; stroke-dasharray: 6 4; }
.point { fill: var(--main); }
table { width: 100%; border-collapse: collapse; } td, th { text-align: left; vertical-align: top;
  padding: .3rem .9rem .3rem 0; border-bottom: 1px solid var(--line); font-weight: normal; overflow-wrap: anywhere; }
th { width: 19.5rem; } td:nth-child(2) { width: 18rem; font-variant-numeric: tabular-nums; }
td:last-child { color: var(--soft); }
@media (max-width: 760px) { tr { display: block; border-bottom: 1px solid var(--line); padding: .3rem 0; }
  td, th, td:nth-child(2) { display: block; width: auto; border: 0; padding: 0; } th { color: var(--soft); } }
"""


@dataclass(frozen=True)
class Axes:
    """Of a picture, from zero."""

    x_ticks: list[float]
    y_ticks: list[float]
    y_label: str

    def x(self, value: float) -> float:
        return LEFT + (WIDTH - LEFT - RIGHT) * value / self.x_ticks[-1]

    def y(self, value: float) -> float:
        return HEIGHT - BOTTOM - (HEIGHT - TOP - BOTTOM) * value / self.y_ticks[-1]

    def path(self, xs: np.ndarray, ys: np.ndarray) -> str:
        return " ".join(f"{self.x(x):.1f},{self.y(y):.1f}" for x, y in zip(xs, ys, strict=True))

    def frame(self) -> str:
        lines = []
        for tick in self.y_ticks:
            y = self.y(tick)
            lines.append(f'<line class="grid" x1="{LEFT}" x2="{WIDTH - RIGHT}" y1="{y:.1f}" y2="{y:.1f}"/>')
            lines.append(f'<text x="{LEFT - 6}" y="{y + 4:.1f}" text-anchor="end">{tick:g}</text>')
        for tick in self.x_ticks:
            x, anchor = self.x(tick), "end" if tick == self.x_ticks[-1] else "middle"
            lines.append(f'<text x="{x:.1f}" y="{HEIGHT - BOTTOM + 16}" text-anchor="{anchor}">{tick:g}</text>')
        lines.append(f'<text x="{WIDTH - RIGHT}" y="{HEIGHT - 6}" text-anchor="end">speed (r/min)</text>')
        lines.append(f'<text x="{LEFT}" y="{HEIGHT - 6}">{escape(self.y_label)}</text>')
        return "".join(lines)


def ticks(most: float) -> list[float]:
    from matplotlib.ticker import MaxNLocator

    return [float(tick) for tick in MaxNLocator(5, steps=[1, 2, 2.5, 5, 10]).tick_values(0, most)]


def rpm(speed_rad_s: float) -> float:
    return speed_rad_s * 30 / math.pi


def curve(variant: Variant, quantity: Callable[[Variant, float], float], speeds: np.ndarray) -> np.ndarray:
    """Over mechanical speeds [rad/s]."""
    slips = np.maximum(LEAST_SLIP, 1 - speeds / variant.plate.synchronous_rad_s)
    return np.array([quantity(variant, float(slip)) for slip in slips])


def torque(variant: Variant, slip: float) -> float:
    return variant.fit.circuit.torque(variant.plate.phase_voltage, variant.plate.omega_s, slip)


def current(variant: Variant, slip: float) -> float:
    plate, fit = variant.plate, variant.fit
    return abs(
        fit.circuit.current(plate.phase_voltage, plate.omega_s, slip) + fit.other_losses_w / (3 * plate.phase_voltage)
    )


def picture(of: list[Variant], quantity: Callable[[Variant, float], float], label: str, limits: np.ndarray,
            points: list[tuple[str, float]]) -> str:  # fmt: skip
    """A quantity over speed with the band of its variants, the limit as (speed [rad/s], value), and points by slip."""
    synchronous = of[0].plate.synchronous_rad_s
    speeds = np.concatenate([np.linspace(0, 0.7, POINTS // 2, endpoint=False), np.linspace(0.7, 1, POINTS // 2)])
    speeds = speeds * synchronous
    values = np.array([curve(one, quantity, speeds) for one in of])
    most = max(values[0].max() * 1.15, limits[:, 1].max() * 1.1)
    axes = Axes(ticks(rpm(synchronous)), ticks(most), label)
    low, high = (np.clip(part, 0, axes.y_ticks[-1]) for part in (values.min(axis=0), values.max(axis=0)))
    x = rpm(speeds)
    parts = [
        axes.frame(),
        f'<polygon class="band" points="{axes.path(x, low)} {axes.path(x[::-1], high[::-1])}"/>',
        f'<polyline class="curve" points="{axes.path(x, values[0])}"/>',
        f'<polyline class="limit" points="{axes.path(rpm(limits[:, 0]), limits[:, 1])}"/>',
    ]
    for name, slip in points:
        x_point, y_point = axes.x(rpm((1 - slip) * synchronous)), axes.y(quantity(of[0], slip))
        falls = quantity(of[0], 1.01 * slip) > 1.001 * quantity(of[0], slip)
        anchor, shift = ("start", 8) if falls or slip == 1 else ("end", -8)
        if x_point > 0.8 * WIDTH:
            anchor, shift = "end", -10
        parts.append(f'<circle class="point" cx="{x_point:.1f}" cy="{y_point:.1f}" r="4"/>')
        parts.append(f'<text x="{x_point + shift:.1f}" y="{y_point - 8:.1f}" text-anchor="{anchor}">{name}</text>')
    return f'<svg viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="{escape(label)}">{"".join(parts)}</svg>'


def torque_limit(of: list[Variant], limits: Limits) -> np.ndarray:
    """The drive's up to the base speed; from there at least by constant power, as the flux is weakened."""
    plate = of[0].plate
    speeds = np.linspace(limits.base_speed_rad_s, plate.synchronous_rad_s, 20)
    speeds = speeds[speeds >= limits.base_speed_rad_s]
    weakened = [(speed, limits.torque_nm * limits.base_speed_rad_s / speed) for speed in speeds]
    return np.array([(0.0, limits.torque_nm), *weakened])


def table(rows: list[Row]) -> str:
    cells = (f"<tr><th>{escape(r.name)}</th><td>{escape(r.value)}</td><td>{escape(r.note)}</td></tr>" for r in rows)
    return f"<table>{''.join(cells)}</table>"


def page(name: str, of: list[Variant], limits: Limits) -> str:
    plate, circuit = of[0].plate, of[0].fit.circuit
    breakdown = circuit.breakdown(plate.phase_voltage, plate.omega_s)[0]
    points = [("rated", plate.slip), ("breakdown", breakdown), ("starting", 1.0)]
    effective = limits.current_limit_a / math.sqrt(2)
    current_limit = np.array([(0.0, effective), (plate.synchronous_rad_s, effective)])
    pictures = (
        (picture(of, torque, "torque (N·m)", torque_limit(of, limits), points), "Torque", "torque limit"),
        (picture(of, current, "current (A, RMS)", current_limit, points), "Current of a line", "current limit"),
    )
    shown = "".join(
        f"<figure>{svg}<figcaption>{what} at rated voltage and frequency; band: what the plate leaves open; dashed: "
        f"the drive's {limit}.</figcaption></figure>"
        for svg, what, limit in pictures
    )
    sections = "".join(f"<h2>{escape(heading)}</h2>{table(rows)}" for heading, rows in tables(of, limits))
    return (
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        f'<meta name="viewport" content="width=device-width, initial-scale=1"><title>{escape(name)}</title>'
        f"<style>{STYLE}</style></head>\n<body><h1>{escape(name)}</h1><p>{escape(title(plate))}</p>\n"
        f'<div class="pictures">{shown}</div>\n{sections}</body></html>\n'
    )


def write(directory: Path, name: str, of: list[Variant], limits: Limits) -> Path:
    file = directory / "report.html"
    file.write_text(page(name, of, limits), encoding="utf-8")
    return file
