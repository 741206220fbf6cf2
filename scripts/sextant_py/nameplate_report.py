"""The figures of a name plate's machine, as rows for text and page."""

import math
from typing import NamedTuple

from .nameplate_circuit import (
    STATOR_SHARE,
    STATOR_SHARE_RANGE,
    USUAL_BREAKDOWN_RANGE,
    Fit,
    breakdown_ratio,
    starting_ratio,
)
from .nameplate_files import inertia_of, title
from .nameplate_limits import Limits, breakdown_at_flux
from .nameplate_plate import NamePlate
from .nameplate_spread import PARAMETERS, Variant, span
from .report.model import Table


class Row(NamedTuple):
    name: str
    value: str
    note: str = ""


HEADS = ("name", "value", "remark")
NAMES = {"r_s_ohm": "R_s", "r_r_ohm": "R_r", "l_ls_h": "L_ls", "l_lr_h": "L_lr", "l_m_h": "L_m"}


def points(variant: Variant) -> list[Row]:
    """Operating points at rated voltage and frequency. Currents are RMS of a line, with the other losses' part."""
    plate, circuit = variant.plate, variant.fit.circuit

    def current(slip: float) -> tuple[float, str]:
        line = variant.current(slip)
        return abs(line), f"{abs(line):.4g} A, cos φ {line.real / abs(line):.3f}"

    rated, idle, starting = current(plate.slip), current(0.0), current(1.0)
    slip, torque = circuit.breakdown(plate.phase_voltage, plate.omega_s)
    standing = variant.torque(1.0)
    by_rated = (
        f"{standing / plate.torque_nm:.2f} of the rated torque, {starting_ratio(plate, circuit):.2f} of the current"
    )
    return [
        Row(
            "rated",
            f"{variant.torque(plate.slip):.4g} N·m, {rated[1]}",
            f"{plate.speed_rpm:.5g} r/min, slip {plate.slip:.2%}, efficiency {plate.efficiency:.1%}",
        ),
        Row("no load", idle[1], f"{idle[0] / rated[0]:.0%} of the rated current"),
        Row(
            "breakdown",
            f"{torque:.4g} N·m, {current(slip)[1]}",
            f"{rpm((1 - slip) * plate.synchronous_rad_s)}; {torque / plate.torque_nm:.2f} of the rated torque",
        ),
        Row("starting", f"{standing:.4g} N·m, {starting[1]}", f"{by_rated}; teeth and bars of a machine make more"),
    ]


def rpm(speed_rad_s: float) -> str:
    return f"{speed_rad_s * 30 / math.pi:.5g} r/min"


def parameters(of: list[Variant]) -> list[Row]:
    rows = []
    for key, quantity in PARAMETERS.items():
        low, value, high = span(of, quantity)
        scale, unit = (1e3, "mH") if key.endswith("_h") else (1.0, "Ω")
        change = f"{low / value - 1:+.0%} … {high / value - 1:+.0%}"
        note = f"{scale * low:.3g} to {scale * high:.3g} {unit} ({change})"
        rows.append(Row(NAMES[key], f"{scale * value:.4g} {unit}", note))
    low, value, high = span(of, lambda v: v.fit.circuit.sigma)
    rows.append(Row("σ", f"{value:.3g}", f"{low:.2g} to {high:.2g}"))
    low, value, high = (1e3 * part for part in span(of, lambda v: v.fit.circuit.tau_r))
    rows.append(Row("rotor time constant", f"{value:.3g} ms", f"{low:.3g} to {high:.3g} ms"))
    return rows


def losses_row(plate: NamePlate, other_losses_w: float) -> Row:
    total = plate.stator_side_losses_w
    value = f"{total - other_losses_w:.4g} W in the stator winding, {other_losses_w:.4g} W beside the circuit"
    if plate.r_s_ohm is not None or plate.other_losses_w is not None:
        return Row("losses beside the rotor's", value, "by the plate and what was given")
    low, high = STATOR_SHARE_RANGE
    note = f"assumed: {STATOR_SHARE:g} in the winding, {low:g} to {high:g}; --r-s-ohm, or scripts/identify, replaces it"
    return Row("losses beside the rotor's", value, note)


def target_row(plate: NamePlate, fit: Fit) -> Row:
    if fit.target.is_given:
        return Row(fit.target.key.replace("_", " "), f"{fit.target.value:g}", "given: σ follows from it")
    low, high = USUAL_BREAKDOWN_RANGE
    note = f"assumed, {low:g} to {high:g}: σ follows from it; --breakdown-ratio of the data sheet replaces it"
    return Row("breakdown ratio", f"{breakdown_ratio(plate, fit.circuit):.3g}", note)


def assumptions(of: list[Variant]) -> list[Row]:
    """What the plate does not say."""
    plate, fit = of[0].plate, of[0].fit
    leakage = "assumed: another split with the same L_s, σ and rotor time constant acts alike at the lines"
    rows = [target_row(plate, fit), losses_row(plate, fit.other_losses_w), Row("L_ls by L_lr", "1", leakage)]
    if plate.inertia_kg_m2 is None:
        note = "assumed by the power, within a factor of 2.5, for the rotor alone; only the simulation uses it"
        rows.append(Row("inertia", f"{inertia_of(plate):.3g} kg·m²", note))
    return rows


def limits_rows(plate: NamePlate, variant: Variant, limits: Limits) -> list[Row]:
    rated = math.sqrt(2) * plate.current_a
    reserve = breakdown_at_flux(variant.fit.circuit, limits.flux_wb) / plate.torque_nm
    by_rated = (
        f"{limits.torque_nm / plate.torque_nm:.2f} of the rated torque; the machine has {reserve:.2f} at this flux"
    )
    handed_over = f"hand_over_current_a {limits.hand_over_a:.4g} A"

    def peak(current: float) -> str:
        return f"{current / rated:.2f} of the rated {rated:.4g} A (peak)"

    return [
        Row("plant.u_dc_v", f"{limits.u_dc_v:.4g} V"),
        Row("control.flux_reference_wb", f"{limits.flux_wb:.4g} Wb", "amplitude of the stator's at the rated point"),
        Row("command.torque_limit_nm", f"{limits.torque_nm:.4g} N·m", by_rated),
        Row("drive.current_limit_a", f"{limits.current_limit_a:.4g} A", peak(limits.current_limit_a)),
        Row("protection.over_current_a", f"{limits.over_current_a:.4g} A", peak(limits.over_current_a)),
        Row("magnetising_current_a", f"{limits.magnetising_a:.4g} A", handed_over),
        Row("protection.over_speed_rad_s", f"{limits.over_speed_rad_s:.4g} rad/s", rpm(limits.over_speed_rad_s)),
        Row("protection.winding.nominal_current_a", f"{plate.current_a:.4g} A", "RMS"),
        Row(
            "base speed",
            f"{limits.base_speed_rad_s:.4g} rad/s",
            f"{rpm(limits.base_speed_rad_s)}: beyond it the flux is weakened",
        ),
    ]


def tables(of: list[Variant], limits: Limits) -> list[Table]:
    rows = {
        "Operating points at rated voltage and frequency": points(of[0]),
        "Equivalent circuit": parameters(of),
        "Assumed": assumptions(of),
        "Limits of the drive": limits_rows(of[0].plate, of[0], limits),
    }
    return [Table(title, HEADS, tuple(found), (0, 1, 2)) for title, found in rows.items()]


def report(of: list[Variant], limits: Limits) -> str:
    """As text."""
    lines = [title(of[0].plate)]
    for table in tables(of, limits):
        names, values = (max(len(row[part]) for row in table.rows) for part in (0, 1))
        lines += ["", table.title]
        lines += [f"  {name:<{names}}  {value:<{values}}  {note}".rstrip() for name, value, note in table.rows]
    return "\n".join(lines) + "\n"
