"""The report of a name plate as one page of HTML, which needs no network and follows the reader's light or dark."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .nameplate_files import title
from .nameplate_limits import Limits
from .nameplate_report import tables
from .nameplate_spread import Variant
from .report.page import filled

WIDTH, HEIGHT = 480, 300  # of a picture, in its own units
LEFT, RIGHT, TOP, BOTTOM = 48, 10, 14, 40
POINTS = 200
LEAST_SLIP = 1e-6


@dataclass(frozen=True)
class Axes:
    """Of a picture, from zero."""

    x_ticks: list[float]
    y_ticks: list[float]
    y_label: str
    width: int = WIDTH
    height: int = HEIGHT

    def x(self, value: float) -> float:
        return round(LEFT + (WIDTH - LEFT - RIGHT) * value / self.x_ticks[-1], 1)

    def y(self, value: float) -> float:
        return round(HEIGHT - BOTTOM - (HEIGHT - TOP - BOTTOM) * value / self.y_ticks[-1], 1)

    def path(self, xs: np.ndarray, ys: np.ndarray) -> str:
        return " ".join(f"{self.x(x)},{self.y(y)}" for x, y in zip(xs, ys, strict=True))


def ticks(most: float) -> list[float]:
    from matplotlib.ticker import MaxNLocator

    return [float(tick) for tick in MaxNLocator(5, steps=[1, 2, 2.5, 5, 10]).tick_values(0, most)]


def rpm(speed_rad_s: float) -> float:
    return speed_rad_s * 30 / math.pi


def curve(variant: Variant, quantity: Callable[[Variant, float], float], speeds: np.ndarray) -> np.ndarray:
    """Over mechanical speeds [rad/s]."""
    slips = np.maximum(LEAST_SLIP, 1 - speeds / variant.plate.synchronous_rad_s)
    return np.array([quantity(variant, float(slip)) for slip in slips])


def picture(of: list[Variant], quantity: Callable[[Variant, float], float], label: str, limits: np.ndarray,
            points: list[tuple[str, float]]) -> dict[str, object]:  # fmt: skip
    """A quantity over speed with the band of its variants, the limit as (speed [rad/s], value), and points by slip."""
    synchronous = of[0].plate.synchronous_rad_s
    speeds = np.concatenate([np.linspace(0, 0.7, POINTS // 2, endpoint=False), np.linspace(0.7, 1, POINTS // 2)])
    speeds = speeds * synchronous
    values = np.array([curve(one, quantity, speeds) for one in of])
    most = max(values[0].max() * 1.15, limits[:, 1].max() * 1.1)
    axes = Axes(ticks(rpm(synchronous)), ticks(most), label)
    low, high = (np.clip(part, 0, axes.y_ticks[-1]) for part in (values.min(axis=0), values.max(axis=0)))
    x = rpm(speeds)
    marks = []
    for name, slip in points:
        x_point, y_point = axes.x(rpm((1 - slip) * synchronous)), axes.y(quantity(of[0], slip))
        falls = quantity(of[0], 1.01 * slip) > 1.001 * quantity(of[0], slip)
        anchor, shift = ("start", 8) if falls or slip == 1 else ("end", -8)
        if x_point > 0.8 * WIDTH:
            anchor, shift = "end", -10
        marks.append((name, x_point, y_point, anchor, shift))
    band = f"{axes.path(x, low)} {axes.path(x[::-1], high[::-1])}"
    limit = axes.path(rpm(limits[:, 0]), limits[:, 1])
    return {"axes": axes, "band": band, "curve": axes.path(x, values[0]), "limit": limit, "points": marks}


def torque_limit(of: list[Variant], limits: Limits) -> np.ndarray:
    """The drive's up to the base speed; from there at least by constant power, as the flux is weakened."""
    plate = of[0].plate
    speeds = np.linspace(limits.base_speed_rad_s, plate.synchronous_rad_s, 20)
    speeds = speeds[speeds >= limits.base_speed_rad_s]
    weakened = [(speed, limits.torque_nm * limits.base_speed_rad_s / speed) for speed in speeds]
    return np.array([(0.0, limits.torque_nm), *weakened])


def write(directory: Path, name: str, of: list[Variant], limits: Limits) -> Path:
    plate, circuit = of[0].plate, of[0].fit.circuit
    breakdown = circuit.breakdown(plate.phase_voltage, plate.omega_s)[0]
    points = [("rated", plate.slip), ("breakdown", breakdown), ("starting", 1.0)]
    effective = limits.current_limit_a / math.sqrt(2)
    current_limit = np.array([(0.0, effective), (plate.synchronous_rad_s, effective)])
    torque = picture(of, Variant.torque, "torque (N·m)", torque_limit(of, limits), points)
    current = picture(of, lambda one, slip: abs(one.current(slip)), "current (A, RMS)", current_limit, points)
    pictures = [(torque, "Torque", "torque limit"), (current, "Current of a line", "current limit")]
    text = filled("plate.html", title=name, plate=title(plate), tables=tables(of, limits), pictures=pictures)
    file = directory / "report.html"
    file.write_text(text, encoding="utf-8")
    return file
