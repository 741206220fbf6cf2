"""The picture of docs/paper on the drive cycle with a vehicle and its driver."""

import numpy as np
from matplotlib.axes import Axes
from sextant_py.plots.sheets import EXACT, PAPER, REFERENCE, TORQUE, band, line, reference, thinned
from sextant_py.plots.trace import Trace

from studies.picture import Sheets

from .lab import Lab
from .vehicle import speeds, vehicle_run

ALL = Sheets()
PARTS = {  # titles and spans [s]
    "NYCC, 598 s": (0.0, 598.0),
    "Departure": (94.5, 100.5),
    "Braking": (63.5, 72.0),
}


def with_speeds(trace: Trace) -> Trace:
    wanted, reached = speeds(trace)
    more = {"wanted_kmh": wanted, "reached_kmh": reached, "error_kmh": reached - wanted}
    return Trace(trace.t_s, trace.values | more | {"power_kw": trace["power_w"] / 1e3})


def between_extremes(axes: Axes, trace: Trace, name: str) -> None:
    t_s, low, high = thinned(trace, name, name)
    axes.fill_between(t_s, low, high, color=EXACT, linewidth=0.7)
    axes.axhline(0, color="grey", linewidth=0.7)


def column(panels: list[Axes], trace: Trace, title: str) -> None:
    """One span of time, from top to bottom."""
    speed, error, torque, power, flux = panels
    line(speed, trace, "reached_kmh", EXACT, "vehicle", linewidth=2.0)
    line(speed, trace, "wanted_kmh", REFERENCE, "cycle", linestyle="--", linewidth=0.9)
    between_extremes(error, trace, "error_kmh")
    band(torque, trace, TORQUE, EXACT, "torque")
    reference(torque, trace)
    between_extremes(power, trace, "power_kw")
    band(flux, trace, "flux_{}_wb", EXACT, "flux")
    flux.axhline(1.1, color=PAPER, linestyle=":", linewidth=0.9)
    speed.set_title(title)
    flux.set_xlabel("Time [s]")


@ALL.sheet(5, 3, 9.4, width_ratios=(5, 3, 3), sharex="col", sharey="row")
def vehicle(lab: Lab, panels: np.ndarray) -> None:
    trace = with_speeds(vehicle_run(lab, "exact").trace)
    for axes, (title, span) in zip(panels.T, PARTS.items(), strict=True):
        column(list(axes), trace.between(*span), title)
        axes[0].set_xlim(*span)
    labels = ("Speed [km/h]", "Speed error [km/h]", "Torque [N·m]", "Link power [kW]", "Flux [Wb]")
    for axes, label in zip(panels[:, 0], labels, strict=True):
        axes.set_ylabel(label)
    panels[0, 0].set_ylim(-2, 52)
    panels[0, 1].legend(loc="upper left")
    panels[2, 1].legend(loc="lower right")
    panels[4, 0].set_ylim(0, 1.3)
    panels[0, 0].figure.align_ylabels(panels[:, 0])
