"""What `identify` writes: the files that a drive reads, the table and the picture."""

import math
from pathlib import Path

from .figure_style import STYLE
from .identify_fit import Found, Level, Setup

BLUE, GREY, RED = "#1f5fa8", "#777777", "#b03a2e"


def told_dead_time_us(found: Found) -> float:
    """What the drive is told; none where the levels show none. The drive counts in nanoseconds. [us]"""
    shows = found.dead_time_s > 2 * found.dead_time_sigma_s
    return round(1e6 * found.dead_time_s, 3) if shows else 0.0


def told_voltage_error_v(found: Found, setup: Setup) -> float:
    """What the drive allows for: what the fit leaves open, and no less than the drive's own default, a tenth of the
    fundamental of what dead time and threshold take, for other temperatures and currents than those measured. [V]"""
    taken = found.link_v * 1e-6 * told_dead_time_us(found) / setup.period_s + setup.threshold_v
    return max(found.voltage_error_v, 0.1 * 4 / math.pi * taken)


def write_files(directory: Path, file: Path, found: Found, setup: Setup) -> tuple[Path, Path]:
    """inverter.toml and machine.toml."""
    head = f"# Measured at standstill by sextant identify {file.name}, at {found.link_v:.1f} V and "
    head += f"{1e6 * setup.period_s:g} us. "
    inverter = directory / "inverter.toml"
    lines = [
        f'{head}Used by [drive] inverter = "inverter.toml".',
        "# Dead time and threshold voltage are one number at one link voltage: it holds near this one.",
        f"dead_time_us = {told_dead_time_us(found):g}  # standard deviation {1e6 * found.dead_time_sigma_s:.2g} us",
        f"voltage_error_v = {told_voltage_error_v(found, setup):.3g}  # {found.voltage_error_v:.2g} V by the fit",
    ]
    given = {"threshold_v": setup.threshold_v, "slope_ohm": setup.slope_ohm}
    lines += [f"{key} = {value:g}  # as given" for key, value in given.items() if value]
    inverter.write_text("\n".join(lines) + "\n", encoding="utf-8")
    machine = directory / "machine.toml"
    machine.write_text(
        f'{head}Used by [control] machine_estimate = "machine.toml".\n'
        f"r_s_ohm = {found.r_s_ohm:.5g}  # standard deviation {found.r_s_sigma_ohm:.2g} ohm, at the temperature "
        "of the measurement\n",
        encoding="utf-8",
    )
    return inverter, machine


def report(levels: list[Level], found: Found, setup: Setup) -> str:
    """Table of the levels, and the result."""
    lines = [" current    voltage        fit       rest"]
    for level, used in zip(levels, found.used, strict=True):
        fitted = float(found.voltage(level.current_a, setup))
        note = "" if used else "  not used: its sign is not certain"
        lines.append(
            f"{level.current_a:8.3f} A {level.voltage_v:8.3f} V {fitted:8.3f} V "
            f"{1e3 * (level.voltage_v - fitted):7.1f} mV{note}"
        )
    lines += [
        f"dead time   {1e6 * found.dead_time_s:.3f} us, standard deviation {1e6 * found.dead_time_sigma_s:.2g} us"
        f" (threshold voltage {setup.threshold_v:g} V)",
        f"R_s         {found.r_s_ohm:.4f} ohm, standard deviation {found.r_s_sigma_ohm:.2g} ohm",
        f"voltage error of the inverter  {found.voltage_error_v:.3g} V",
    ]
    return "\n".join(lines)


def write_picture(directory: Path, levels: list[Level], found: Found, setup: Setup) -> Path:
    """Voltage over current with the fit, and what the fit leaves."""
    import matplotlib as mpl

    mpl.use("Agg")
    import numpy as np
    from matplotlib import pyplot

    current = np.array([level.current_a for level in levels])
    voltage = np.array([level.voltage_v for level in levels])
    used = np.array(found.used)
    most = 1.08 * np.abs(current).max()
    half = np.linspace(1e-6 * most, most, 2)
    with mpl.rc_context(STYLE):
        figure, (above, below) = pyplot.subplots(
            2, 1, figsize=(6.4, 5.4), sharex=True, gridspec_kw={"height_ratios": [3, 1]}
        )
        for side in (-half[::-1], half):
            above.plot(side, found.voltage(side, setup), color=BLUE, linewidth=1.2)
        above.plot(current[used], voltage[used], "o", color=BLUE, label="levels")
        rest = 1e3 * (voltage - found.voltage(current, setup))
        below.plot(current[used], rest[used], "o", color=BLUE)
        below.axhline(0, color=GREY, linewidth=0.8)
        if not used.all():
            above.plot(current[~used], voltage[~used], "x", color=RED, label="not used: the sign is not certain")
        above.set_title(
            f"dead time {1e6 * found.dead_time_s:.3f} ± {1e6 * found.dead_time_sigma_s:.2g} µs,  "
            f"R_s {found.r_s_ohm:.4f} ± {found.r_s_sigma_ohm:.2g} Ω"
        )
        above.set_ylabel("commanded voltage along phase a (V)")
        above.legend(loc="upper left")
        below.set_ylabel("level less fit (mV)")
        below.set_xlabel("current along phase a (A)")
        file = directory / "identify.png"
        figure.savefig(file)
        pyplot.close(figure)
    return file
