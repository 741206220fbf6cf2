"""The curves of docs/paper that are made of its numbers."""

import numpy as np
from matplotlib.axes import Axes
from sextant_py.plots.sheets import EXACT, PAPER, REFERENCE, SAMPLED, THIRD

from studies.picture import Sheets

from .numbers import Numbers

ALL = Sheets()


def curve(values: dict[str, float]) -> tuple[np.ndarray, np.ndarray]:
    """Keys as numbers and values, in rising order, without those that are none."""
    pairs = sorted((float(key), value) for key, value in values.items() if np.isfinite(value))
    return np.array([k for k, _ in pairs]), np.array([v for _, v in pairs])


def draw(axes: Axes, numbers: Numbers, under: str, form: str, colour: str, label: str, **options) -> None:
    """The numbers whose names begin so, over the rest of their names."""
    axes.plot(*curve(numbers.under(under)), form, color=colour, label=label, **({"markersize": 4} | options))


def note(axes: Axes, text: str, at: tuple[float, float], offset: tuple[float, float], **options) -> None:
    axes.annotate(text, at, xytext=offset, textcoords="offset points", **options)


@ALL.sheet(1, 2, 3.8)
def response(numbers: Numbers, panels: np.ndarray) -> None:
    ((time, surge),) = panels
    for reading, colour, label in (("centred", EXACT, "centred sectors"), ("v1", THIRD, "sectors from V1")):
        draw(time, numbers, f"response/{reading}/dead/", "o-", colour, f"{label}, dead machine")
        draw(surge, numbers, f"surge/{reading}/", "o-", colour, label)
    draw(time, numbers, "response/centred/magnetised/", "s-", SAMPLED, "magnetised, either reading")
    time.axhline(3.7, color=PAPER, linewidth=1.0)
    note(time, "paper: 3.7 ms", (128, 3.7), (0, -11), color=PAPER, ha="right")
    time.axhline(5, color=REFERENCE, linestyle="--", linewidth=1.0)
    note(time, "ABB: 5 ms", (2, 5), (0, 4))
    time.set(xlim=(0, 134), ylim=(0, 9.6), title="95 % of a step, event-exact")
    time.set(xlabel="Step [N·m]", ylabel="Response time [ms]")
    time.legend(loc="upper left")
    surge.set(xlim=(0, 134), ylim=(0, 195), title="Largest phase current of the start")
    surge.set(xlabel="Step [N·m]", ylabel="Current [A]")
    surge.legend(loc="lower right")


@ALL.sheet(1, 2, 4.0)
def ripple(numbers: Numbers, panels: np.ndarray) -> None:
    ((over_speed, limit),) = panels
    over_speed.set_yscale("log")
    thin = {"markersize": 3.5, "linewidth": 0.9, "alpha": 0.75}
    for torque, colour in ((15, EXACT), (50, THIRD), (130, PAPER)):
        draw(over_speed, numbers, f"ripple/{torque}/", "o-", colour, f"{torque} N·m, event-exact")
        label = f"{torque} N·m, sampled at 25 µs"
        draw(over_speed, numbers, f"ripple_sampled/{torque}/", "s--", colour, label, **thin)
    over_speed.axhline(0.918, color=REFERENCE, linestyle=":", linewidth=1.0)
    note(over_speed, "HB 0.918", (119, 0.918), (0, -12), ha="right")
    over_speed.set_yticks([0.5, 1, 2, 5, 10, 20], ["0.5", "1", "2", "5", "10", "20"])
    over_speed.minorticks_off()
    over_speed.set(ylim=(0.5, 60), xlim=(0, 122), title="Ripple, peak to peak")
    over_speed.set(xlabel="Speed [rad/s]", ylabel="Ripple [N·m]")
    over_speed.legend(loc="upper left", ncols=2, fontsize=7.5, columnspacing=1.0, handlelength=1.6)
    draw(limit, numbers, "limit_speed/", "o-", EXACT, "measured: ripple below 0.96 N·m")
    draw(limit, numbers, "limit_speed_calculated/", "--", PAPER, "calculated: weakest vector still holds")
    limit.set(xlim=(0, 134), ylim=(0, 100), title="Speed up to which the ripple is the band")
    limit.set(xlabel="Torque [N·m]", ylabel="Speed [rad/s]")
    limit.legend(loc="lower left")


@ALL.sheet(1, 2, 4.0, sharey=True)
def pulse_frequency(numbers: Numbers, panels: np.ndarray) -> None:
    ((bands, torques),) = panels
    for hb, colour in (("0.5", THIRD), ("0.918", EXACT), ("1", SAMPLED)):
        for kind, style, label in (("pulse", "-", "comparator"), ("leg", ":", "one leg")):
            speed, hz = curve(numbers.under(f"{kind}/15/{hb}/"))
            bands.plot(speed, hz / 1e3, style, color=colour, label=f"HB {hb}, {label}")
    speed, half = curve(numbers.under("pulse/15/0.5/"))
    _, full = curve(numbers.under("pulse/15/1/"))
    line = (full + 0.164 * (half - full)) / 1e3
    bands.plot(speed, line, "--", color=PAPER, linewidth=1.0, label="paper's line at 0.918")
    bands.axhline(39.73, color=PAPER, linewidth=0.8)
    note(bands, "paper: 39.73 kHz", (70, 39.73), (0, 4), color=PAPER, ha="center")
    for met in numbers.under("met/").values():
        bands.plot(met, 39.73, "o", color=PAPER, markersize=6, markerfacecolor="white")
    bands.set(xlim=(0, 130), ylim=(0, 150), title="15 N·m", xlabel="Speed [rad/s]", ylabel="Frequency [kHz]")
    bands.legend(loc="upper left", ncols=2, fontsize=8)
    for torque, colour in ((5, THIRD), (15, EXACT), (50, SAMPLED), (130, PAPER)):
        for kind, style in (("pulse", "-"), ("leg", ":")):
            speed, hz = curve(numbers.under(f"{kind}/{torque}/0.918/"))
            torques.plot(speed, hz / 1e3, style, color=colour, label=f"{torque} N·m" if kind == "pulse" else None)
    torques.set(xlim=(0, 130), title="HB 0.918; dotted: one leg", xlabel="Speed [rad/s]")
    torques.legend(loc="upper left", ncols=2)


@ALL.sheet(1, 1, 3.6)
def dead_zone(numbers: Numbers, panels: np.ndarray) -> None:
    ((axes,),) = panels
    slope, begins = curve(numbers.under("dead_zone/ramp/begins/"))
    _, meets = curve(numbers.under("dead_zone/ramp/meets/"))
    fine = np.geomspace(slope.min(), slope.max(), 200)
    axes.loglog(fine, 918 / fine, "--", color=REFERENCE, linewidth=1.0, label="HB by slope")
    axes.loglog(slope, begins, "o", color=SAMPLED, markersize=5, label="torque begins")
    axes.loglog(slope, meets, "s-", color=EXACT, markersize=4, label="torque meets its reference")
    at = numbers["dead_zone/slope_of_22_ms/centred"]
    axes.axhline(22, color=PAPER, linewidth=0.9)
    axes.plot(at, 22, "o", color=PAPER, markersize=8, markerfacecolor="none")
    note(axes, f"paper: 22 ms, {at:.1f} N·m/s", (at, 22), (10, 6), color=PAPER)
    axes.set_xticks([20, 40, 60, 100, 200, 400], ["20", "40", "60", "100", "200", "400"])
    axes.set_yticks([2, 5, 10, 20, 50], ["2", "5", "10", "20", "50"])
    axes.minorticks_off()
    axes.set_title("Answer to a reference that rises from zero, dead machine")
    axes.set(xlabel="Slope of the reference [N·m/s]", ylabel="Time [ms]")
    axes.legend(loc="upper right")
