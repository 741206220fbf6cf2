"""The overview of a file: torque, stator flux, speed and current over time, and what else a trace holds."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from ..signal_file import Signals
from . import png

MAX_POINTS = 4000
REFERENCE, MEASURED, BAND = "#d95f02", "#1b4f9c", "#9ecae1"


def blocks(values: np.ndarray, reduce: str) -> np.ndarray:
    """No more than MAX_POINTS values: means, minima, maxima or last ones of blocks of equal length."""
    size = -(-len(values) // MAX_POINTS)
    if size == 1:
        return values.astype(float)
    starts = np.arange(0, len(values), size)
    if reduce == "last":
        return values[np.append(starts[1:], len(values)) - 1].astype(float)
    if reduce == "mean":
        return np.add.reduceat(values.astype(float), starts) / np.diff(np.append(starts, len(values)))
    return (np.minimum if reduce == "min" else np.maximum).reduceat(values.astype(float), starts)


def times(signals: Signals) -> np.ndarray:
    """Those of the blocks: a block stands at its end, as a row does."""
    return blocks(signals.time_s, "last")


def draw_quantity(axes: Axes, signals: Signals, quantity: str, unit: str) -> None:
    """Mean with its band of minimum and maximum. In a trace sampled each period the signal itself has both."""
    time_s = times(signals)
    mean = signals.get(f"{quantity}_mean_{unit}", f"{quantity}_{unit}", f"plant/{quantity}_{unit}")
    if mean is None:
        axes.text(0.5, 0.5, "not recorded", transform=axes.transAxes, ha="center", color="grey")
        return
    smallest, largest = signals.get(f"{quantity}_min_{unit}"), signals.get(f"{quantity}_max_{unit}")
    low = blocks(mean if smallest is None else smallest, "min")
    high = blocks(mean if largest is None else largest, "max")
    axes.fill_between(time_s, low, high, color=BAND, linewidth=0, label="minimum to maximum")
    axes.plot(time_s, blocks(mean, "mean"), color=MEASURED, linewidth=1.2, label="mean")


def draw_torque(axes: Axes, signals: Signals) -> None:
    draw_quantity(axes, signals, "torque", "nm")
    time_s = times(signals)
    requested, reference = signals.get("torque_requested_nm"), signals.get("torque_reference_nm")
    if requested is not None:
        axes.plot(time_s, blocks(requested, "mean"), color="grey", linewidth=1.0, linestyle=":", label="requested")
    if reference is not None:
        axes.plot(time_s, blocks(reference, "mean"), color=REFERENCE, linewidth=1.4, linestyle="--", label="reference")


def draw_speed(axes: Axes, signals: Signals) -> None:
    speed = signals.get("speed_rad_s", "plant/omega_m_rad_s")
    if speed is None:
        axes.text(0.5, 0.5, "not recorded", transform=axes.transAxes, ha="center", color="grey")
        return
    axes.plot(times(signals), blocks(speed, "mean"), color=MEASURED, linewidth=1.2)


# What a trace holds beside its standard signals: heading and signals of a panel.
FURTHER_PANELS = (
    ("Switching states of the legs a, b, c", ("plant/switch_a", "plant/switch_b", "plant/switch_c")),
    ("Comparator outputs", ("control/torque_comparator", "control/flux_comparator")),
    ("Stator voltage [V]", ("plant/u_s_alpha_v", "plant/u_s_beta_v")),
    ("DC-link current at the end of each row [A]", ("plant/i_dc_a",)),
    ("Rotor current [A]", ("plant/i_r_alpha_a", "plant/i_r_beta_a")),
    ("Shaft angle [rad]", ("plant/theta_m_rad",)),
    (
        "Energies [J]",
        (
            "plant/energy_link_j",
            "plant/energy_shaft_j",
            "plant/energy_copper_j",
            "plant/energy_iron_j",
            "plant/energy_field_j",
        ),
    ),
)
LEVELS = {"plant/switch_a": 0, "plant/switch_b": 2, "plant/switch_c": 4, "control/flux_comparator": 3}


def further_panels(signals: Signals) -> list[tuple[str, tuple[str, ...]]]:
    """The panels of which there is at least one signal; the channels of a controller by their units."""
    known = ((heading, tuple(n for n in names if n in signals.values)) for heading, names in FURTHER_PANELS)
    panels = [(heading, names) for heading, names in known if names]
    drawn = {name for _, names in FURTHER_PANELS for name in names}
    channels: dict[str, list[str]] = {}
    for name in signals.values:
        if name.startswith("control/") and name not in drawn:
            channels.setdefault(signals.units.get(name, ""), []).append(name)
    return panels + [(f"Channels of the controller [{unit or '?'}]", tuple(names)) for unit, names in channels.items()]


def draw_lines(axes: Axes, signals: Signals, names: tuple[str, ...]) -> None:
    """Each signal by its name. Those of two or three levels stand above each other, as steps from their rows on."""
    for name in names:
        values = signals.values[name]
        label = name.split("/")[-1]
        if np.issubdtype(values.dtype, np.integer):
            axes.step(signals.time_s, values + LEVELS.get(name, 0), where="post", linewidth=0.8, label=label)
            axes.set_yticks([])
        else:
            axes.plot(times(signals), blocks(values, "mean"), linewidth=1.2, label=label)


def draw(signals: Signals, title: str, output: Path) -> None:
    """Four panels over one time axis, and one for each further group of signals that there is, to a PNG."""
    further = further_panels(signals)
    count = 4 + len(further)
    sizes = {"figsize": (11, 2 + 2.5 * count), "height_ratios": (3, *(2 for _ in range(count - 1)))}
    figure, panels = plt.subplots(count, 1, sharex=True, layout="constrained", **sizes)
    figure.suptitle(title, fontsize=13)
    draw_torque(panels[0], signals)
    draw_quantity(panels[1], signals, "flux", "wb")
    draw_speed(panels[2], signals)
    draw_quantity(panels[3], signals, "current", "a")
    headings = (
        "Torque [N·m]",
        "Stator flux linkage [Wb]",
        "Rotor speed, mechanical [rad/s]",
        "Stator current vector [A]",
        *(heading for heading, _ in further),
    )
    for axes, (_, names) in zip(panels[4:], further, strict=True):
        draw_lines(axes, signals, names)
    for axes, heading in zip(panels, headings, strict=True):
        axes.set_title(heading, loc="left", fontsize=11)
        axes.grid(True, alpha=0.3)
        axes.margins(x=0.01)
        if axes.get_legend_handles_labels()[1]:
            axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, fontsize=9, frameon=False)
    panels[-1].set_xlabel("Time [s]")
    png.save(figure, output)
