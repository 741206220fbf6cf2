"""The picture of `identify`: a panel of each measurement with its fit, and below it what the fit leaves."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from .figure_style import STYLE
from .identify_files import Results
from .identify_impedance import Impedance, sampled_impedance
from .identify_inertia import Inertia
from .identify_no_load import NoLoad
from .identify_saturation import Saturation

if TYPE_CHECKING:
    from matplotlib.axes import Axes

BLUE, GREY, RED = "#1f5fa8", "#777777", "#b03a2e"


def _draw_levels(above: Axes, below: Axes, results: Results) -> None:
    found, setup = results.found, results.setup
    current = np.array([level.current_a for level in results.levels])
    voltage = np.array([level.voltage_v for level in results.levels])
    used = np.array(found.used)
    most = 1.05 * float(np.max(np.abs(current)))
    half = np.linspace(1e-6 * most, most, 2)
    for side in (-half[::-1], half):
        above.plot(side, found.voltage(side, setup), color=BLUE, linewidth=1.2)
    above.plot(current[used], voltage[used], "o", color=BLUE, label="levels")
    rest = 1e3 * (voltage - found.voltage(current, setup))
    below.plot(current[used], rest[used], "o", color=BLUE)
    if not used.all():
        above.plot(current[~used], voltage[~used], "x", color=RED, label="not used: the sign is not certain")
    above.set_title(
        f"dead time {1e6 * found.dead_time_s:.3f} ± {1e6 * found.dead_time_sigma_s:.2g} µs,  "
        f"R_s {found.r_s_ohm:.4f} ± {found.r_s_sigma_ohm:.2g} Ω"
    )
    above.set_ylabel("commanded voltage along phase a [V]")
    below.set_ylabel("residual [mV]")
    below.set_xlabel("current along phase a [A]")
    below.sharex(above)


def _draw_tones(above: Axes, below: Axes, found: Impedance) -> None:
    from matplotlib.ticker import NullFormatter

    omega = np.array([tone.omega for tone in found.tones])
    measured = np.array([tone.impedance for tone in found.tones])
    fine = np.geomspace(0.8 * omega.min(), 1.25 * omega.max(), 200)
    curve = sampled_impedance(found.with_slope, fine, found.timing)
    rest = 100 * (measured / sampled_impedance(found.with_slope, omega, found.timing) - 1)
    hertz = 1 / (2 * math.pi)
    for part, color, name in ((np.real, BLUE, "real part"), (np.imag, RED, "imaginary part")):
        above.plot(hertz * fine, part(curve), color=color, linewidth=1.2)
        above.plot(hertz * omega, part(measured), "o", color=color, label=name)
        below.plot(hertz * omega, part(rest), "o", color=color)
    below.sharex(above)
    above.set_xscale("log")
    above.xaxis.set_minor_formatter(NullFormatter())
    machine, deviations = found.machine, found.deviations
    above.set_title(
        f"σL_s {1e3 * machine.leakage:.3g} mH ± {100 * deviations.leakage:.2g} %,\n"
        f"k_r² R_r {machine.r_rotor:.3g} Ω ± {100 * deviations.r_rotor:.2g} %,  "
        f"k_r L_m {1e3 * machine.l_magnetising:.3g} mH ± {100 * deviations.l_magnetising:.2g} %"
    )
    above.set_ylabel("impedance at standstill [Ω]")
    below.set_ylabel("residual [%]")
    below.set_xlabel("frequency [Hz]")


def _draw_no_load(above: Axes, below: Axes, points: list[NoLoad], curve: Saturation | None) -> None:
    """Flux over current with what is told of it, and by how much each point is off that."""
    whole, flux = points[-1], np.array([point.flux_wb for point in points])
    shown = np.linspace(0, whole.flux_wb, 60)

    def ratio(at: np.ndarray) -> np.ndarray:
        return curve.ratio(at) if curve else np.ones_like(at)

    above.plot(shown / (whole.l_s * ratio(shown)), shown, color=BLUE)
    above.plot([point.current_a for point in points], flux, "o", color=BLUE, label=f"at {whole.speed:.3g} rad/s")
    above.set_title(f"L_s {1e3 * whole.l_s:.4g} mH ± {100 * whole.sigma:.2g} % at {whole.flux_wb:.3g} Wb")
    above.set_ylabel("stator flux without torque [Wb]")
    above.set_xlabel("current [A]")
    inductance = np.array([point.l_s for point in points])
    below.plot(flux, 100 * (inductance / (whole.l_s * ratio(flux)) - 1), "o", color=BLUE)
    below.set_ylabel("residual [%]")
    below.set_xlabel("stator flux without torque [Wb]")


def _draw_inertia(above: Axes, below: Axes, found: Inertia) -> None:
    time = found.time_s - found.time_s[0]
    above.plot(time, found.speed, color=BLUE, linewidth=2.4, alpha=0.5, label="measured")
    above.plot(time, found.fitted, color=RED, linewidth=1.0, label="by torque, inertia and friction")
    above.set_title(f"J {found.inertia:.4g} ± {found.sigma:.2g} kg·m²")
    above.set_ylabel("speed [rad/s]")
    below.plot(time, found.speed - found.fitted, color=BLUE, linewidth=0.8)
    below.set_ylabel("residual [rad/s]")
    below.set_xlabel("time [s]")
    below.sharex(above)


def write_picture(directory: Path, results: Results) -> Path:
    """identify.png, with a panel for each of what was measured."""
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot

    panels = []
    if results.found:
        panels.append(lambda above, below: _draw_levels(above, below, results))
    if results.impedance:
        panels.append(lambda above, below: _draw_tones(above, below, results.impedance))
    if results.fluxes:
        panels.append(lambda above, below: _draw_no_load(above, below, results.fluxes, results.saturation))
    if results.inertia:
        panels.append(lambda above, below: _draw_inertia(above, below, results.inertia))
    with mpl.rc_context(STYLE):
        columns = min(2, len(panels))
        rows = -(-len(panels) // columns)
        figure, axes = pyplot.subplots(
            2 * rows, columns, figsize=(6.4 * columns, 5.4 * rows), squeeze=False,
            gridspec_kw={"height_ratios": [3, 1] * rows},
        )  # fmt: skip
        places = [
            (axes[2 * row, column], axes[2 * row + 1, column]) for row in range(rows) for column in range(columns)
        ]
        for draw, (above, below) in zip(panels, places, strict=False):
            draw(above, below)
            below.axhline(0, color=GREY, linewidth=0.8)
            above.legend(loc="best")
        for pair in places[len(panels) :]:
            for unused in pair:
                unused.set_axis_off()
        file = directory / "identify.png"
        figure.savefig(file)
        pyplot.close(figure)
    return file
