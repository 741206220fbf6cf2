"""The path of the stator flux or of the stator current in the α–β plane."""

from dataclasses import dataclass
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from ..errors import UserError
from ..figure_style import STYLE
from . import html, png
from .series import Series, SeriesFile

QUANTITIES = ("flux", "current")
UNITS = {"flux": "Wb", "current": "A"}
NAMES = {"flux": "Stator flux linkage", "current": "Stator current"}
MOST_POINTS = 50_000
SECTORS = 6
# The pairs along and across phase a, in the order of preference; then what they are computed from.
PAIRS = {
    "flux": (("flux_alpha_wb", "flux_beta_wb"), ("psi_s_alpha_wb", "psi_s_beta_wb")),
    "current": (("i_s_alpha_a", "i_s_beta_a"),),
}


@dataclass(frozen=True)
class Locus:
    label: str
    alpha: np.ndarray
    beta: np.ndarray


def _first(file: SeriesFile, *names: str) -> list[Series] | None:
    """The signals of these names in one group, the drive's before the others."""
    groups = dict.fromkeys(name.rpartition("/")[0] for name in file.series)
    for group in sorted(groups):
        full = [f"{group}/{name}" if group else name for name in names]
        if all(name in file.series for name in full):
            return [file.series[name] for name in full]
    return None


def components(file: SeriesFile, quantity: str) -> tuple[np.ndarray, np.ndarray]:
    """Along and across phase a; currents by the Clarke transformation that keeps the amplitude."""
    for pair in PAIRS[quantity]:
        if found := _first(file, *pair):
            return found[0].values, found[1].values
    if quantity == "current" and (found := _first(file, "i_a_a", "i_b_a", "i_c_a")):
        a, b, c = (series.values.astype(float) for series in found)
        return (2 * a - b - c) / 3, (b - c) / np.sqrt(3)
    if quantity == "flux" and (found := _first(file, "flux_mean_wb", "flux_angle_rad")):
        magnitude, angle = (series.values.astype(float) for series in found)
        return magnitude * np.cos(angle), magnitude * np.sin(angle)
    raise UserError(f"{file.path} has no signals of the stator {quantity} in the α–β plane; --list shows its signals.")


def compute(files: list[SeriesFile], quantity: str) -> list[Locus]:
    found = []
    for file in files:
        alpha, beta = components(file, quantity)
        if len(alpha) > MOST_POINTS:
            raise UserError(
                f"{file.path} has {len(alpha)} points in the span, of which a locus shows up to {MOST_POINTS};"
                " --from and --to choose a shorter span."
            )
        found.append(Locus(file.label, alpha, beta))
    return found


def _radius(loci: list[Locus]) -> float:
    return max(float(np.nanmax(np.hypot(locus.alpha, locus.beta))) for locus in loci)


def _sector_ends(radius: float) -> list[tuple[float, float]]:
    """The borders of the six sectors, which are centred on the axes of the phases."""
    angles = np.deg2rad(30 + 60 * np.arange(SECTORS))
    return [(1.1 * radius * float(np.cos(angle)), 1.1 * radius * float(np.sin(angle))) for angle in angles]


def draw_png(loci: list[Locus], quantity: str, title: str, output: Path) -> None:
    plt.rcParams.update(STYLE)
    figure, axes = plt.subplots(figsize=(7.5, 7.5))
    for x, y in _sector_ends(_radius(loci)):
        axes.plot([0, x], [0, y], color="0.8", linewidth=0.8, zorder=0)
    for locus in loci:
        axes.plot(locus.alpha, locus.beta, linewidth=0.8, marker=".", markersize=2, label=locus.label)
    axes.set_aspect("equal")
    axes.set(xlabel=f"α [{UNITS[quantity]}]", ylabel=f"β [{UNITS[quantity]}]")
    axes.set_title(f"{title}\n{NAMES[quantity]}; lines: borders of the sectors")
    if len(loci) > 1:
        axes.legend(loc="upper right")
    png.save(figure, output)


def draw_html(loci: list[Locus], quantity: str, title: str, output: Path) -> None:
    figure = html.Figure()
    for x, y in _sector_ends(_radius(loci)):
        border = {"mode": "lines", "line": {"color": "#8a929b", "width": 1}, "showlegend": False, "hoverinfo": "skip"}
        figure.add_scatter(x=[0, x], y=[0, y], **border)
    for number, locus in enumerate(loci):
        figure.add_scatter(
            x=locus.alpha, y=locus.beta, mode="lines", name=locus.label, line={"width": 1} | html.style_of(number)
        )
    figure.update_layout(template="plotly_white", margin={"l": 60, "r": 20, "t": 20, "b": 50})
    figure.update_layout(legend={"orientation": "h", "x": 0, "y": 1, "yanchor": "bottom"}, showlegend=len(loci) > 1)
    figure.update_xaxes(title_text=f"α [{UNITS[quantity]}]")
    figure.update_yaxes(title_text=f"β [{UNITS[quantity]}]", scaleanchor="x")
    html.save(figure, f"{title}: {NAMES[quantity]}", output)
