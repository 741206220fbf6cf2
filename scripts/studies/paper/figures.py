"""The pictures of docs/paper: the paper's figures 7 to 17."""

import numpy as np
from matplotlib.axes import Axes
from sextant_py.plots.sheets import (
    EXACT,
    PAPER,
    REFERENCE,
    SAMPLED,
    THIRD,
    TORQUE,
    band,
    legend,
    line,
    reference,
)
from sextant_py.plots.trace import Trace

from studies.picture import Sheets

from . import steps
from .lab import SAMPLED as SAMPLED_SETTINGS
from .lab import Lab, Settings

ALL = Sheets()
TIME, NM = "Time [s]", "Torque [N·m]"
STATES = ((1.0, "hb_1", "(a) HB = 1 N·m"), (0.5, "hb_0_5", "(b) HB = 0.5 N·m"))


def gates(trace: Trace, r_s: float = 0.435, u_dc: float = 530) -> np.ndarray:
    """States of the three upper switches at each row, from the voltage that moved the flux: u = dψ/dt + R_s i.

    Both zero vectors look alike; the drive takes the one that is one switch away from the vector before.
    """
    vectors = [(1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 1, 1), (0, 0, 1), (1, 0, 1)]
    direction = 2 / 3 * u_dc * np.exp(1j * np.pi / 3 * np.arange(6))
    i_s = trace["i_a_a"] + 1j * (trace["i_b_a"] - trace["i_c_a"]) / np.sqrt(3)
    psi = trace["psi_s_alpha_wb"] + 1j * trace["psi_s_beta_wb"]
    u = np.diff(psi) / np.diff(trace.t_s) + r_s * 0.5 * (i_s[1:] + i_s[:-1])
    nearest = np.argmin(abs(u[:, None] - np.concatenate((direction, [0]))[None, :]), axis=1)
    states, zero = [], (0, 0, 0)
    for vector in nearest:
        if vector < 6:
            zero = (0, 0, 0) if vector % 2 == 0 else (1, 1, 1)
        states.append(zero if vector == 6 else vectors[vector])
    return np.array([states[0], *states])


def steady(lab: Lab, scenario: str) -> Trace:
    """0.5 ms of a magnetised machine at a row a microsecond."""
    fine = {"duration_s": 0.06, "metrics.window_from_s": 0.05, "drive.period_us": 1, "trace.interval_us": 1}
    return lab.run(scenario, fine, trace=True).trace.between(0.05, 0.0505)


def steady_sampled(lab: Lab, scenario: str, band_nm: float) -> Trace:
    bands = {f"control.dtc.torque_band_{side}_nm": band_nm for side in ("upper", "lower")}
    fine = {"duration_s": 0.3, "metrics.window_from_s": 0.2, "trace.interval_us": 25, "plant.fixed.max_step_us": 5}
    return lab.run(scenario, SAMPLED_SETTINGS | fine | bands, trace=True).trace.between(0.25, 0.2525)


@ALL.sheet(2, 2, 5.6, sharey="row")
def figure_07(lab: Lab, panels: np.ndarray) -> None:
    for axes, (hb, scenario, title) in zip(panels[0], STATES, strict=True):
        trace = steady(lab, scenario)
        t_us = (trace.t_s - trace.t_s[0]) * 1e6
        axes.fill_between(t_us, trace["torque_min_nm"], trace["torque_max_nm"], color=EXACT, linewidth=1.0)
        axes.axhline(15, color=REFERENCE, linestyle="--", linewidth=1.0, label="reference")
        axes.axhline(15 - hb, color="grey", linestyle=":", linewidth=0.9, label="less HB")
        axes.set(title=f"{title}, event-exact", xlabel="Time [µs]", ylim=(13.6, 15.4))
    for axes, (hb, scenario, _) in zip(panels[1], STATES, strict=True):
        trace = steady_sampled(lab, scenario, hb)
        axes.plot((trace.t_s - trace.t_s[0]) * 1e3, trace["torque_nm"], color=SAMPLED, linewidth=1.0)
        axes.axhline(15, color=REFERENCE, linestyle="--", linewidth=1.0)
        axes.set(title=f"HB = {hb:g} N·m, sampled at 25 µs", xlabel="Time [ms]")
    for axes in panels[:, 0]:
        axes.set_ylabel("Torque [N·m]")
    panels[0, 1].legend(loc="lower right", ncols=2)


@ALL.sheet(2, 1, 5.0, sharex=True)
def figure_08(lab: Lab, panels: np.ndarray) -> None:
    for axes, (_, scenario, title) in zip(panels[:, 0], STATES, strict=True):
        trace = steady(lab, scenario).between(0.05014, 0.05044)
        states = gates(trace)
        t_us = (trace.t_s - trace.t_s[0]) * 1e6
        for leg, (name, colour) in enumerate((("S1", EXACT), ("S2", PAPER), ("S3", THIRD))):
            base = 1.4 * (2 - leg)
            axes.fill_between(t_us, base, base + states[:, leg], step="pre", color=colour, alpha=0.25)
            axes.step(t_us, base + states[:, leg], color=colour, linewidth=1.2, label=name)
        axes.set_yticks([1.4 * k + 0.5 for k in range(3)], ["S3", "S2", "S1"])
        axes.grid(visible=False, axis="y")
        axes.set_title(f"{title}: upper switches, on where shaded")
    panels[1, 0].set_xlabel("Time [µs]")


def both(axes: Axes, exact: Trace, sampled: Trace, alpha: float, label: str = "reference") -> None:
    """The torque of a run, sampled and event-exact, and its reference."""
    band(axes, sampled, TORQUE, SAMPLED, "sampled at 25 µs", alpha=alpha)
    band(axes, exact, TORQUE, EXACT, "event-exact")
    reference(axes, exact, label=label)


def both_runs(lab: Lab, scenario: str) -> tuple[Trace, Trace]:
    """Event-exact and sampled."""
    runs = (lab.run(scenario, settings, trace=True) for settings in ({}, SAMPLED_SETTINGS))
    return tuple(run.trace for run in runs)


def constant_torque(lab: Lab) -> tuple[Trace, Trace]:
    return both_runs(lab, "3_1_constant_torque")


def mark_load_steps(axes: Axes) -> None:
    for t_s in steps.LOAD_STEPS_S:
        axes.axvline(t_s, color="grey", linewidth=0.8, linestyle=":")


def load_step(lab: Lab) -> Trace:
    """0.6 ms about the load step at 0.2 s, at a row a microsecond."""
    fine = {"duration_s": 0.2004, "metrics.window_from_s": 0.1, "drive.period_us": 1, "trace.interval_us": 1}
    return lab.run("3_1_constant_torque", fine, trace=True).trace.between(0.1997, 0.2003)


@ALL.sheet(2, 1, 5.4, height_ratios=(3, 2))
def figure_09(lab: Lab, panels: np.ndarray) -> None:
    exact, sampled = constant_torque(lab)
    ((full,), (near,)) = panels
    both(full, exact, sampled, 0.7)
    mark_load_steps(full)
    full.set(title="Torque, 3.1; dotted: the load steps", ylabel=NM, xlabel=TIME, xlim=(0, 1.4), ylim=(0, 22))
    legend(full)
    part = load_step(lab)
    t_us = (part.t_s - 0.2) * 1e6
    near.fill_between(t_us, part["torque_min_nm"], part["torque_max_nm"], color=EXACT, linewidth=1.0)
    near.axhline(15, color=REFERENCE, linestyle="--", linewidth=1.0)
    near.axvline(0, color="grey", linewidth=0.8, linestyle=":")
    near.set(title="Load step from 0 to 8 N·m, event-exact", ylabel=NM, ylim=(13.8, 15.2))
    near.set_xlabel("Time from the load step [µs]")


@ALL.sheet(1, 1, 3.2)
def figure_10(lab: Lab, panels: np.ndarray) -> None:
    exact, _ = constant_torque(lab)
    ((speed,),) = panels
    line(speed, exact, "omega_m_rad_s", EXACT, "speed")
    speed.set(title="Speed at various load conditions, 3.1", xlabel=TIME, ylabel="Speed [rad/s]")
    load = speed.twinx()
    load.step(exact.t_s, exact["tau_l_nm"], color=PAPER, linewidth=1.2, where="pre")
    load.set_ylabel("Load torque [N·m], ours", color=PAPER)
    load.set_ylim(-1, 22)
    load.grid(visible=False)
    speed.set_xlim(0, 1.4)


@ALL.sheet(1, 2, 3.6, width_ratios=(2, 3))
def figure_11(lab: Lab, panels: np.ndarray) -> None:
    exact, sampled = constant_torque(lab)
    ((start, full),) = panels
    v1 = lab.run("sector_start_0", trace=True).trace
    for axes in (start, full):
        axes.axhspan(1.1 * 0.985, 1.1 * 1.015, color=THIRD, alpha=0.18, linewidth=0, label="1.1 Wb ±1.5 %")
        band(axes, v1, "flux_{}_wb", PAPER, "event-exact, sectors from V1", alpha=0.55)
        band(axes, sampled, "flux_{}_wb", SAMPLED, "sampled at 25 µs", alpha=0.7)
        band(axes, exact, "flux_{}_wb", EXACT, "event-exact, centred sectors")
    start.set(xlim=(0, 0.15), ylim=(0, 1.3), title="Stator flux, start", xlabel=TIME, ylabel="Stator flux [Wb]")
    start.axvline(0.1, color=PAPER, linewidth=1.0)
    start.annotate("paper: 0.1 s", (0.1, 0.1), xytext=(-4, 0), textcoords="offset points", color=PAPER, ha="right")
    full.set(xlim=(0, 1.4), ylim=(1.05, 1.27), title="The run, magnified", xlabel=TIME, ylabel="Stator flux [Wb]")
    handles, labels = full.get_legend_handles_labels()
    full.figure.legend(handles, labels, loc="outside lower center", ncols=4)


@ALL.sheet(1, 2, 3.4, width_ratios=(2, 3))
def figure_12(lab: Lab, panels: np.ndarray) -> None:
    exact, _ = constant_torque(lab)
    v1 = lab.run("sector_start_0", trace=True).trace
    ((start, full),) = panels
    line(start, v1, "current_max_a", PAPER, "vector, sectors from V1", linewidth=1.0)
    line(start, exact, "current_max_a", EXACT, "vector, centred")
    start.set(xlim=(0, 0.05), title="Surge of the start", xlabel=TIME, ylabel="Magnitude of stator current [A]")
    start.legend(loc="upper right")
    for name, colour, label in (("i_a_a", EXACT, "a"), ("i_b_a", SAMPLED, "b"), ("i_c_a", THIRD, "c")):
        line(full, exact, name, colour, f"phase {label}", linewidth=0.9)
    full.set(title="Phase currents", xlabel=TIME, ylabel="Current [A]", xlim=(0, 0.6))
    legend(full)


@ALL.sheet(2, 1, 5.0, height_ratios=(3, 2), sharex=True)
def figure_13(lab: Lab, panels: np.ndarray) -> None:
    exact, sampled = both_runs(lab, "3_2_reversal")
    ((torque,), (speed,)) = panels
    both(torque, exact, sampled, 0.6, "reference, ours")
    torque.set(title="Reversals, 3.2", ylabel=NM, xlim=(0, 1.2))
    legend(torque)
    line(speed, exact, "omega_m_rad_s", EXACT, "")
    generates = exact["omega_m_rad_s"] * exact["torque_mean_nm"] < 0
    shade = {"transform": speed.get_xaxis_transform(), "color": THIRD, "alpha": 0.18, "linewidth": 0}
    speed.fill_between(exact.t_s, 0, 1, where=generates, **shade)
    speed.set(title="Speed; shaded: the machine regenerates", ylabel="Speed [rad/s]", xlabel=TIME)


FINE = {"drive.period_us": 2, "trace.interval_us": 2}
V1 = FINE | {"control.dtc.sector_start_deg": 0}


def zoom(lab: Lab, scenario: str, end_s: float, settings: Settings) -> Trace:
    span = {"duration_s": end_s, "metrics.window_from_s": 0.5 * end_s}
    return lab.run(scenario, span | settings, trace=True).trace


@ALL.sheet(1, 1, 3.8)
def figure_14(lab: Lab, panels: np.ndarray) -> None:
    ((axes,),) = panels
    exact = zoom(lab, "3_2_reversal", 0.007, FINE)
    v1 = zoom(lab, "3_2_reversal", 0.007, V1)
    sampled = zoom(lab, "3_2_reversal", 0.007, SAMPLED_SETTINGS | {"trace.interval_us": 25})
    line(axes, sampled, "torque_nm", SAMPLED, "sampled at 25 µs", 1e3, linewidth=0.9)
    band(axes, v1, TORQUE, THIRD, "event-exact, sectors from V1", 1e3)
    band(axes, exact, TORQUE, EXACT, "event-exact, centred", 1e3)
    reference(axes, exact, 1e3)
    axes.axhline(0.95 * 30, color="grey", linewidth=0.8, linestyle=":")
    axes.axvline(3.7, color=PAPER, linewidth=1.0)
    axes.annotate("paper: 3.7 ms", (3.7, 3), xytext=(4, 0), textcoords="offset points", color=PAPER)
    axes.annotate("95 %", (0, 28.5), xytext=(3, -11), textcoords="offset points", color="grey")
    axes.set(xlim=(0, 7), title="First step of 3.2", xlabel="Time [ms]", ylabel=NM)
    legend(axes, ncols=4)


@ALL.sheet(2, 1, 5.0, height_ratios=(3, 2), sharex=True)
def figure_15(lab: Lab, panels: np.ndarray) -> None:
    exact, sampled = both_runs(lab, "3_3_smooth")
    ((torque,), (error,)) = panels
    both(torque, exact, sampled, 0.6, "reference, ours")
    torque.set(title="Smooth variation, 3.3", ylabel=NM, xlim=(0, 2))
    legend(torque)
    low, high = exact.error
    error.fill_between(exact.t_s, low, high, color=EXACT, linewidth=0.5)
    error.set(title="Torque error, event-exact, and the speed", ylabel="Error [N·m]", xlabel=TIME, ylim=(-2, 2))
    for limit in (-0.918, 0.918):
        error.axhline(limit, color="grey", linewidth=0.8, linestyle=":")
    speed = error.twinx()
    line(speed, exact, "omega_m_rad_s", PAPER, "")
    speed.set_ylabel("Speed [rad/s]", color=PAPER)
    speed.set_ylim(-110, 110)
    speed.grid(visible=False)


@ALL.sheet(1, 1, 3.6)
def figure_16(lab: Lab, panels: np.ndarray) -> None:
    ((axes,),) = panels
    exact = zoom(lab, "3_3_smooth", 0.035, FINE)
    v1 = zoom(lab, "3_3_smooth", 0.035, V1)
    band(axes, v1, TORQUE, THIRD, "event-exact, sectors from V1", 1e3)
    band(axes, exact, TORQUE, EXACT, "event-exact, centred", 1e3)
    reference(axes, exact, 1e3, "reference, ours")
    axes.axhline(0.918, color="grey", linewidth=0.8, linestyle=":")
    axes.annotate("HB", (0.3, 0.918), xytext=(0, 3), textcoords="offset points", color="grey")
    axes.axvline(22, color=PAPER, linewidth=1.0)
    axes.annotate("paper: 22 ms", (22, 1.6), xytext=(-4, 0), textcoords="offset points", color=PAPER, ha="right")
    axes.set(xlim=(0, 35), ylim=(-0.1, 1.8), title="Start of the smooth variation, 3.3")
    axes.set(xlabel="Time [ms]", ylabel=NM)
    legend(axes)


@ALL.sheet(1, 2, 3.6, width_ratios=(3, 2))
def figure_17(lab: Lab, panels: np.ndarray) -> None:
    exact, sampled = both_runs(lab, "3_4_high_torque")
    ((full, near),) = panels
    for axes in (full, near):
        both(axes, exact, sampled, 0.6)
    full.set(xlim=(0, 0.9), ylim=(0, 150), title="Torque of 130 N·m against 125 N·m, 3.4", xlabel=TIME, ylabel=NM)
    full.legend(loc="lower right")
    near.set(xlim=(0.5, 0.52), ylim=(122, 136), title="Magnified", xlabel=TIME)
