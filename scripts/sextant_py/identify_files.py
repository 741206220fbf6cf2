"""What `identify` writes: the files that a drive reads, and the table."""

import math
from dataclasses import dataclass, field
from pathlib import Path

from .identify_fit import Found, Level, Setup
from .identify_impedance import Impedance, sampled_impedance
from .identify_inertia import Inertia
from .identify_iron import IronLoss
from .identify_machine import InverseGamma
from .identify_no_load import NoLoad
from .identify_saturation import Saturation
from .sweep_file import Settings

CERTAIN = 3  # standard deviations by which a friction is above zero


@dataclass(frozen=True)
class Results:
    """What was known and what was found; None of what was not measured."""

    setup: Setup
    levels: list[Level] = field(default_factory=list)
    found: Found | None = None
    impedance: Impedance | None = None
    split: float = 1.0  # L_ls/L_lr of the drive's estimate
    fluxes: list[NoLoad] = field(default_factory=list)  # rising, the last one the whole
    saturation: Saturation | None = None
    saturated: Impedance | None = None  # by the tones on that curve
    inertia: Inertia | None = None
    iron: IronLoss | None = None

    @property
    def no_load(self) -> NoLoad | None:
        """At the whole flux."""
        return self.fluxes[-1] if self.fluxes else None

    @property
    def machine(self) -> InverseGamma | None:
        """By the tones; at the inductance of the coasting shaft where it was measured."""
        if not self.impedance:
            return None
        machine = (self.saturated or self.impedance).machine
        return self.no_load.of(machine) if self.no_load else machine


def told_dead_time_us(found: Found) -> float:
    """What the drive is told; none where the levels show none. The drive counts in nanoseconds. [us]"""
    shows = found.dead_time_s > 2 * found.dead_time_sigma_s
    return round(1e6 * found.dead_time_s, 3) if shows else 0.0


def told_voltage_error_v(found: Found, setup: Setup) -> float:
    """What the drive allows for: what the fit leaves open, and no less than the drive's own default, a tenth of the
    fundamental of what dead time and threshold take, for other temperatures and currents than those measured. [V]"""
    taken = found.link_v * 1e-6 * told_dead_time_us(found) / setup.period_s + setup.threshold_v
    return max(found.voltage_error_v, 0.1 * 4 / math.pi * taken)


def _inverter_lines(found: Found, setup: Setup) -> list[str]:
    lines = [
        f"# At {found.link_v:.1f} V and {1e6 * setup.period_s:g} us. Dead time and threshold voltage are one number at "
        "one link voltage: it holds near this one.",
        f"dead_time_us = {told_dead_time_us(found):g}  # standard deviation {1e6 * found.dead_time_sigma_s:.2g} us",
        f"voltage_error_v = {told_voltage_error_v(found, setup):.3g}  # {found.voltage_error_v:.2g} V by the fit",
    ]
    given = {"threshold_v": setup.threshold_v, "slope_ohm": setup.slope_ohm}
    return lines + [f"{key} = {value:g}  # as given" for key, value in given.items() if value]


def _resistance(results: Results) -> tuple[float, float] | None:
    """R_s and its standard deviation: of the levels, else of the sines. [ohm]"""
    if results.found:
        return results.found.r_s_ohm, results.found.r_s_sigma_ohm
    if tones := results.saturated or results.impedance:
        return tones.machine.r_s, tones.machine.r_s * tones.deviations.r_s
    return None


def _machine_lines(results: Results) -> list[str]:
    """The machine's keys with standard deviations; resistances at the temperature of the measurement."""
    tones, inertia = results.saturated or results.impedance, results.inertia
    shaft = (
        [f"inertia_kg_m2 = {inertia.inertia:.5g}  # standard deviation {inertia.sigma:.2g} kg·m²"] if inertia else []
    )
    resistance = _resistance(results)
    if not resistance:
        return shaft
    r_s, sigma = resistance
    lines = [f"r_s_ohm = {r_s:.5g}  # standard deviation {sigma:.2g} ohm, at the temperature of the measurement"]
    if not tones:
        return [*lines, *shaft]
    machine, deviations = results.machine.t_circuit(results.split), tones.deviations
    l_m_deviation = results.no_load.sigma if results.no_load else deviations.l_magnetising
    return [
        *lines,
        'circuit = "T"',
        f"r_r_ohm = {machine.r_r:.5g}  # {100 * deviations.r_rotor:.2g} %, at the temperature of the measurement",
        f"# L_ls/L_lr, {results.split:.3g}, is that of the estimate: no terminal shows it.",
        f"l_ls_h = {machine.l_ls:.5g}  # {100 * deviations.leakage:.2g} %",
        f"l_lr_h = {machine.l_lr:.5g}  # the same",
        f"l_m_h = {machine.l_m:.5g}  # {100 * l_m_deviation:.2g} %",
        *shaft,
    ]


def _saturation_lines(found: Saturation) -> list[str]:
    return [
        "",
        f"# L_s at each flux is within {100 * found.rest:.2g} % of this curve.",
        "[saturation]",
        f"knee_wb = {found.knee_wb:.5g}  # standard deviation {found.knee_sigma_wb:.2g} Wb, with this exponent",
        f"exponent = {found.exponent}",
        f"machine_flux_wb = {found.machine_flux_wb:.5g}  # at which l_m_h holds",
    ]


def _iron_lines(found: IronLoss) -> list[str]:
    return [
        f"iron_loss_resistance_ohm = {found.resistance_ohm:.4g}  # {100 * found.sigma:.2g} %, at "
        f"{found.omega_e / (2 * math.pi):.3g} Hz",
    ]


def _iron_report(found: IronLoss | None) -> list[str]:
    if not found:
        return ["iron loss   none that is certain"]
    return [
        f"iron loss   R_fe {found.resistance_ohm:.4g} ohm, {100 * found.sigma:.2g} %: {found.loss_w:.4g} W at the whole"
        f" flux and {found.omega_e / (2 * math.pi):.3g} Hz",
        f"            beside friction and load of {found.friction_nm:.3g} N·m, standard deviation "
        f"{found.friction_sigma_nm:.2g} N·m",
    ]


def told(results: Results) -> Settings:
    """What the files tell a drive, as keys of its configuration."""
    settings: Settings = {}
    if results.found:
        settings["drive.inverter.dead_time_us"] = told_dead_time_us(results.found)
        settings["drive.inverter.voltage_error_v"] = round(told_voltage_error_v(results.found, results.setup), 4)
        settings["drive.inverter.threshold_v"] = results.setup.threshold_v
    if resistance := _resistance(results):
        settings["control.machine_estimate.r_s_ohm"] = resistance[0]
    if results.impedance:
        machine = results.machine.t_circuit(results.split)
        values = {
            "circuit": "T",
            "r_r_ohm": machine.r_r,
            "l_ls_h": machine.l_ls,
            "l_lr_h": machine.l_lr,
            "l_m_h": machine.l_m,
        }
        settings |= {f"control.machine_estimate.{key}": value for key, value in values.items()}
    if curve := results.saturation:
        values = {"knee_wb": curve.knee_wb, "exponent": curve.exponent, "machine_flux_wb": curve.machine_flux_wb}
        settings |= {f"control.machine_estimate.saturation.{key}": value for key, value in values.items()}
    return settings


def write_files(directory: Path, file: Path, results: Results) -> list[Path]:
    """inverter.toml, machine.toml and iron.toml, of what was measured."""
    head = f"# Measured by sextant identify {file.name}. "
    written = []
    if results.found:
        inverter = directory / "inverter.toml"
        lines = [f'{head}Used by [drive] inverter = "inverter.toml".', *_inverter_lines(results.found, results.setup)]
        inverter.write_text("\n".join(lines) + "\n", encoding="utf-8")
        written.append(inverter)
    if results.iron:
        iron = directory / "iron.toml"
        lines = [f"{head}Copy it, or let it be the base of a drive's file.", "[drive]", *_iron_lines(results.iron)]
        iron.write_text("\n".join(lines) + "\n", encoding="utf-8")
        written.append(iron)
    machine = directory / "machine.toml"
    lines = [f'{head}Used by [control] machine_estimate = "machine.toml".', *_machine_lines(results)]
    if results.saturation:
        lines += _saturation_lines(results.saturation)
    machine.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return [*written, machine]


def _level_report(levels: list[Level], found: Found, setup: Setup) -> list[str]:
    lines = [" current    voltage        fit       rest"]
    for level, used in zip(levels, found.used, strict=True):
        fitted = float(found.voltage(level.current_a, setup))
        note = "" if used else "  not used: its sign is not certain"
        lines.append(
            f"{level.current_a:8.3f} A {level.voltage_v:8.3f} V {fitted:8.3f} V "
            f"{1e3 * (level.voltage_v - fitted):7.1f} mV{note}"
        )
    return [
        *lines,
        f"dead time   {1e6 * found.dead_time_s:.3f} us, standard deviation {1e6 * found.dead_time_sigma_s:.2g} us"
        f" (threshold voltage {setup.threshold_v:g} V)",
        f"R_s         {found.r_s_ohm:.4f} ohm, standard deviation {found.r_s_sigma_ohm:.2g} ohm",
        f"voltage error of the inverter  {found.voltage_error_v:.3g} V",
    ]


def _tone_report(results: Results) -> list[str]:
    found = results.impedance
    total = found.with_slope
    fitted = sampled_impedance(total, [tone.omega for tone in found.tones], found.timing)
    lines = ["frequency      impedance                fit                      rest"]
    for tone, fit in zip(found.tones, fitted, strict=True):
        rest = abs(tone.impedance - fit) / abs(fit)
        lines.append(
            f"{tone.omega / (2 * math.pi):8.3f} Hz {tone.impedance.real:9.4f} {tone.impedance.imag:+9.4f}j ohm "
            f"{fit.real:9.4f} {fit.imag:+9.4f}j ohm {100 * rest:6.2f} %"
        )
    machine, deviations = found.machine, found.deviations
    circuit = machine.t_circuit(results.split)
    return [
        *lines,
        f"R_s         {machine.r_s:.5g} ohm, {100 * deviations.r_s:.2g} %",
        f"σL_s        {1e3 * machine.leakage:.5g} mH, {100 * deviations.leakage:.2g} %",
        f"R_r         {circuit.r_r:.5g} ohm, {100 * deviations.r_rotor:.2g} %  (k_r² R_r {machine.r_rotor:.5g} ohm)",
        f"L_m         {1e3 * circuit.l_m:.5g} mH, {100 * deviations.l_magnetising:.2g} %"
        f"  (k_r L_m {1e3 * machine.l_magnetising:.5g} mH)",
        f"L_ls, L_lr  {1e3 * circuit.l_ls:.5g} mH, {1e3 * circuit.l_lr:.5g} mH by L_ls/L_lr = {results.split:.3g}",
    ]


def _no_load_report(found: NoLoad, results: Results) -> list[str]:
    circuit = results.machine.t_circuit(results.split)
    return [
        f"no load     {found.flux_wb:.4g} Wb at {found.current_a:.4g} A and {found.speed:.3g} rad/s",
        f"L_m         {1e3 * circuit.l_m:.5g} mH, {100 * found.sigma:.2g} %, at this flux"
        f"  (k_r L_m {1e3 * results.machine.l_magnetising:.5g} mH)",
        _saturation_report(results.saturation),
        f"R_r         {circuit.r_r:.5g} ohm, σL_s {1e3 * results.machine.leakage:.5g} mH, at this flux"
        + (f", the tones within {100 * results.saturated.rest:.2g} %" if results.saturated else ""),
    ]


def _saturation_report(found: Saturation | None) -> str:
    if not found:
        return "saturation  none that is certain, up to this flux"
    return (
        f"saturation  knee {found.knee_wb:.4g} Wb, standard deviation {found.knee_sigma_wb:.2g} Wb, exponent "
        f"{found.exponent}, within {100 * found.rest:.2g} %"
    )


def _friction(value: float, sigma: float, unit: str) -> str:
    """With its deviation; friction within CERTAIN of zero is none that shows."""
    if value < CERTAIN * sigma or not value:
        return f"below {value + CERTAIN * sigma:.2g} {unit}, not distinguishable from zero"
    return f"{value:.3g} {unit}, standard deviation {sigma:.2g} {unit}"


def _inertia_report(found: Inertia) -> list[str]:
    return [
        f"J           {found.inertia:.5g} kg·m², standard deviation {found.sigma:.2g} kg·m², at up to "
        f"{found.fastest:.3g} rad/s",
        f"friction    dry {_friction(found.coulomb_nm, found.coulomb_sigma_nm, 'N·m')}",
        f"            viscous {_friction(found.viscous, found.viscous_sigma, 'N·m·s')}",
        f"load        {found.load_nm:.3g} N·m, standard deviation {found.load_sigma_nm:.2g} N·m",
    ]


def report(results: Results) -> str:
    """Tables of the levels and tones, and the result."""
    lines = _level_report(results.levels, results.found, results.setup) if results.found else []
    lines += _tone_report(results) if results.impedance else []
    lines += _no_load_report(results.no_load, results) if results.no_load else []
    lines += _inertia_report(results.inertia) if results.inertia else []
    lines += _iron_report(results.iron) if results.inertia and results.fluxes else []
    return "\n".join(lines)
