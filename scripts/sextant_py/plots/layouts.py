"""The layouts of the paper's figures, drawn of any trace or recording by the functions that draw docs/paper."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from ..errors import UserError
from . import png
from .series import SeriesFile
from .sheets import EXACT, PAPER, SAMPLED, THIRD, TORQUE, band, legend, line, reference, sheet
from .trace import Trace

COLOURS = (EXACT, SAMPLED, THIRD, PAPER)  # of the files
TIME, NM = "Time [s]", "Torque [N·m]"
Named = list[tuple[str, Trace]]


def trace_of(file: SeriesFile) -> Trace:
    """As the figures of the paper know a trace: the plant's signals, and the drive's where the plant has none."""
    drive = {name: series for name, series in file.series.items() if "/" not in name}
    plant = {name.removeprefix("plant/"): series for name, series in file.series.items() if name.startswith("plant/")}
    both = drive | plant
    if "omega_m_rad_s" not in both and "speed_rad_s" in both:
        both["omega_m_rad_s"] = both["speed_rad_s"]
    if not both:
        raise UserError(f"{file.path} has no signals.")
    time_s = next(iter(both.values())).time_s
    return Trace(time_s, {name: series.values for name, series in both.items()})


def _label(label: str, of: str) -> str:
    return f"{of}, {label}" if label else of


def bands(axes: Axes, traces: Named, quantity: str, what: str) -> None:
    """The band of each file, the widest behind the others."""
    low, high = quantity.format("min"), quantity.format("max")
    coloured = list(zip(traces, COLOURS, strict=False))
    coloured.sort(key=lambda item: -float(np.nanmean(item[0][1][high] - item[0][1][low])))
    for (label, trace), colour in coloured:
        band(axes, trace, quantity, colour, _label(label, what), alpha=0.8)


def torque(traces: Named, output: Path) -> None:
    figure, ((axes,),) = sheet(1, 1, 3.6)
    bands(axes, traces, TORQUE, "torque")
    reference(axes, traces[0][1])
    axes.set(title="Torque, minimum to maximum", ylabel=NM, xlabel=TIME)
    legend(axes)
    png.save(figure, output)


def speed_and_load(traces: Named, output: Path) -> None:
    figure, ((axes,),) = sheet(1, 1, 3.2)
    load = axes.twinx()
    for (label, trace), colour in zip(traces, COLOURS, strict=False):
        line(axes, trace, "omega_m_rad_s", colour, _label(label, "speed"))
        load.step(trace.t_s, trace["tau_l_nm"], color=PAPER, linewidth=1.2, where="pre")
    load.set_ylabel("Load torque [N·m]", color=PAPER)
    load.grid(visible=False)
    axes.set(title="Speed at various load conditions", xlabel=TIME, ylabel="Speed [rad/s]")
    legend(axes)
    png.save(figure, output)


def flux(traces: Named, output: Path) -> None:
    figure, ((axes,),) = sheet(1, 1, 3.4)
    bands(axes, traces, "flux_{}_wb", "stator flux")
    axes.set(title="Stator flux, minimum to maximum", xlabel=TIME, ylabel="Stator flux [Wb]")
    legend(axes)
    png.save(figure, output)


def currents(traces: Named, output: Path) -> None:
    figure, panels = sheet(len(traces), 2, 3.2 * len(traces), width_ratios=(2, 3))
    for (label, trace), (vector, phases) in zip(traces, panels, strict=True):
        line(vector, trace, "current_max_a", EXACT, "vector")
        vector.set(title=_label(label, "Current vector"), xlabel=TIME, ylabel="Magnitude of stator current [A]")
        for name, colour, phase in (("i_a_a", EXACT, "a"), ("i_b_a", SAMPLED, "b"), ("i_c_a", THIRD, "c")):
            line(phases, trace, name, colour, f"phase {phase}", linewidth=0.9)
        phases.set(title="Phase currents", xlabel=TIME, ylabel="Current [A]")
        legend(phases)
    png.save(figure, output)


def torque_and_speed(traces: Named, output: Path) -> None:
    figure, ((top,), (bottom,)) = sheet(2, 1, 5.0, height_ratios=(3, 2), sharex=True)
    bands(top, traces, TORQUE, "torque")
    for (_, trace), colour in zip(traces, COLOURS, strict=False):
        line(bottom, trace, "omega_m_rad_s", colour, "")
    first = traces[0][1]
    reference(top, first)
    regenerates = first["omega_m_rad_s"] * first["torque_mean_nm"] < 0
    shade = {"transform": bottom.get_xaxis_transform(), "color": THIRD, "alpha": 0.18, "linewidth": 0}
    bottom.fill_between(first.t_s, 0, 1, where=regenerates, **shade)
    top.set(title="Torque, minimum to maximum", ylabel=NM)
    bottom.set(title="Speed; shaded: the machine regenerates", ylabel="Speed [rad/s]", xlabel=TIME)
    legend(top)
    png.save(figure, output)


def torque_and_error(traces: Named, output: Path) -> None:
    figure, ((top,), (bottom,)) = sheet(2, 1, 5.0, height_ratios=(3, 2), sharex=True)
    bands(top, traces, TORQUE, "torque")
    for (_, trace), colour in zip(traces, COLOURS, strict=False):
        low, high = trace.error
        bottom.fill_between(trace.t_s, low, high, color=colour, linewidth=0.5, alpha=0.8)
    reference(top, traces[0][1])
    top.set(title="Torque, minimum to maximum", ylabel=NM)
    bottom.set(title="Torque error", ylabel="Error [N·m]", xlabel=TIME)
    legend(top)
    png.save(figure, output)


# By the number of the paper's figure: what it shows, how it is drawn, and of which signals.
LAYOUTS: dict[str, tuple[str, Callable[[Named, Path], None], tuple[str, ...]]] = {
    "9": ("torque and its reference", torque, ("torque_min_nm", "torque_max_nm", "torque_reference_nm")),
    "10": ("speed and load torque", speed_and_load, ("omega_m_rad_s", "tau_l_nm")),
    "11": ("stator flux", flux, ("flux_min_wb", "flux_max_wb")),
    "12": ("current vector and phase currents", currents, ("current_max_a", "i_a_a", "i_b_a", "i_c_a")),
    "13": (
        "torque and speed of reversals",
        torque_and_speed,
        ("torque_min_nm", "torque_max_nm", "torque_mean_nm", "torque_reference_nm", "omega_m_rad_s"),
    ),
    "15": ("torque and its error", torque_and_error, ("torque_min_nm", "torque_max_nm", "torque_reference_nm")),
}


def listed() -> str:
    return "\n".join(f"  {name:>3}  {what}" for name, (what, _, _) in LAYOUTS.items())


def draw(files: list[SeriesFile], name: str, output: Path) -> None:
    if name not in LAYOUTS:
        raise UserError(f'--figure: no layout is called "{name}"; known are {", ".join(LAYOUTS)}.')
    _, function, needed = LAYOUTS[name]
    if len(files) > len(COLOURS):
        raise UserError(f"--figure draws up to {len(COLOURS)} files, got {len(files)}.")
    traces = []
    for file in files:
        trace = trace_of(file)
        if missing := [signal for signal in needed if signal not in trace.values]:
            raise UserError(f"--figure {name}: {file.path} lacks {', '.join(missing)}.")
        traces.append((file.label if len(files) > 1 else "", trace))
    function(traces, output)
