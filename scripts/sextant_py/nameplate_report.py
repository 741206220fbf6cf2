"""The figures of a name plate's machine, as rows for text and page."""

import math
from dataclasses import dataclass

from .nameplate_circuit import STATOR_SHARE, STATOR_SHARE_RANGE, USUAL_BREAKDOWN_RANGE, breakdown_ratio, starting_ratio
from .nameplate_files import inertia_of, title
from .nameplate_limits import Limits, breakdown_at_flux
from .nameplate_plate import NamePlate
from .nameplate_spread import PARAMETERS, Variant, span


@dataclass(frozen=True)
class Row:
    name: str
    value: str
    note: str = ""


NAMES = {"r_s_ohm": "R_s", "r_r_ohm": "R_r", "l_ls_h": "L_ls", "l_lr_h": "L_lr", "l_m_h": "L_m"}


def points(variant: Variant) -> list[Row]:
    """Operating points at rated voltage and frequency. Currents are RMS of a line, with the other losses' part."""
    plate, circuit = variant.plate, variant.fit.circuit
    voltage, omega_s = plate.phase_voltage, plate.omega_s
    losses = variant.fit.other_losses_w / (3 * voltage)

    def line(slip: float) -> complex:
        return circuit.current(voltage, omega_s, slip) + losses

    def power_factor(current: complex) -> float:
        return current.real / abs(current)

    rated, idle = line(plate.slip), line(0.0)
    slip, torque = circuit.breakdown(voltage, omega_s)
    rpm = plate.synchronous_rad_s * 30 / math.pi
    starting = circuit.torque(voltage, omega_s, 1.0)
    return [
        Row(
            "rated",
            f"{circuit.torque(voltage, omega_s, plate.slip):.4g} N·m, {abs(rated):.4g} A, cos φ {power_factor(rated):.3f}",
            f"{plate.speed_rpm:.5g} r/min, slip {plate.slip:.2%}, efficiency {plate.efficiency:.1%}",
        ),
        Row("no load", f"{abs(idle):.4g} A, cos φ {power_factor(idle):.3f}", f"{abs(idle) / abs(rated):.0%} of the rated current"),
        Row("breakdown", f"{torque:.4g} N·m, {abs(line(slip)):.4g} A", f"{(1 - slip) * rpm:.5g} r/min; {breakdown_ratio(plate, circuit):.2f} of the rated torque"),
        Row(
            "starting",
            f"{starting:.4g} N·m, {abs(line(1.0)):.4g} A",
            f"{starting / plate.torque_nm:.2f} of the rated torque, {starting_ratio(plate, circuit):.2f} of the rated current; "
            "a machine's bars and teeth make more of both",
        ),
    ]  # fmt: skip


def parameters(of: list[Variant]) -> list[Row]:
    rows = []
    for key, quantity in PARAMETERS.items():
        low, value, high = span(of, quantity)
        scale, unit = (1e3, "mH") if key.endswith("_h") else (1.0, "Ω")
        change = f"{low / value - 1:+.0%} … {high / value - 1:+.0%}"
        rows.append(
            Row(NAMES[key], f"{scale * value:.4g} {unit}", f"{scale * low:.3g} to {scale * high:.3g} {unit} ({change})")
        )
    low, value, high = span(of, lambda v: v.fit.circuit.sigma)
    rows.append(Row("σ", f"{value:.3g}", f"{low:.2g} to {high:.2g}"))
    low, value, high = span(of, lambda v: v.fit.circuit.tau_r)
    rows.append(Row("rotor time constant", f"{1e3 * value:.3g} ms", f"{1e3 * low:.3g} to {1e3 * high:.3g} ms"))
    return rows


def assumptions(of: list[Variant]) -> list[Row]:
    """What the plate does not say."""
    plate, fit = of[0].plate, of[0].fit
    total = plate.stator_side_losses_w
    other, target = fit.other_losses_w, fit.target
    winding = total - other
    rows = [
        Row(
            "leakage of stator and rotor", "equal", "another split with the same L_s, σ and τ_r acts alike at the lines"
        )
    ]
    losses = f"{winding:.4g} W of {total:.4g} W beside the rotor's in the stator winding"
    if plate.r_s_ohm is None and plate.other_losses_w is None:
        low, high = STATOR_SHARE_RANGE
        note = f"assumed: {STATOR_SHARE:g} of them, {low:g} to {high:g}; --r-s-ohm or scripts/identify measures R_s"
        rows.append(Row("losses", losses, note))
    else:
        rows.append(Row("losses", losses, "by the plate and what was given"))
    if target.is_given:
        key = target.key.replace("_", " ")
        rows.append(Row(key, f"{target.value:g}", "given: σ follows from it"))
    else:
        low, high = USUAL_BREAKDOWN_RANGE
        note = f"assumed, {low:g} to {high:g}: σ follows from it; --breakdown-ratio of the data sheet replaces it"
        rows.append(Row("breakdown ratio", f"{breakdown_ratio(plate, fit.circuit):.3g}", note))
    if plate.inertia_kg_m2 is None:
        rows.append(
            Row(
                "inertia",
                f"{inertia_of(plate):.3g} kg·m²",
                "assumed by the power, within a factor of 2.5; the simulation alone uses it",
            )
        )
    rows.append(Row("iron, friction, stray", f"{other:.4g} W", "at the lines, beside the circuit, which has none"))
    return rows


def limits_rows(plate: NamePlate, variant: Variant, limits: Limits) -> list[Row]:
    rated = math.sqrt(2) * plate.current_a
    reserve = breakdown_at_flux(variant.fit.circuit, limits.flux_wb) / plate.torque_nm
    return [
        Row("plant.u_dc_v", f"{limits.u_dc_v:.4g} V"),
        Row("control.flux_reference_wb", f"{limits.flux_wb:.4g} Wb", "amplitude of the stator's at the rated point"),
        Row("command.torque_limit_nm", f"{limits.torque_nm:.4g} N·m", f"{limits.torque_nm / plate.torque_nm:.2f} of the rated torque; the machine has {reserve:.2f} at this flux"),
        Row("drive.current_limit_a", f"{limits.current_limit_a:.4g} A", f"peak, {limits.current_limit_a / rated:.2f} of the rated {rated:.4g} A"),
        Row("protection.over_current_a", f"{limits.over_current_a:.4g} A", f"peak, {limits.over_current_a / rated:.2f} of the rated one"),
        Row("magnetising_current_a", f"{limits.magnetising_a:.4g} A", f"hand_over_current_a {limits.hand_over_a:.4g} A"),
        Row("protection.over_speed_rad_s", f"{limits.over_speed_rad_s:.4g} rad/s", f"{limits.over_speed_rad_s * 30 / math.pi:.5g} r/min"),
        Row("protection.winding.nominal_current_a", f"{plate.current_a:.4g} A", "RMS"),
        Row("base speed", f"{limits.base_speed_rad_s:.4g} rad/s", f"{limits.base_speed_rad_s * 30 / math.pi:.5g} r/min: beyond it the flux is weakened"),
    ]  # fmt: skip


def tables(of: list[Variant], limits: Limits) -> list[tuple[str, list[Row]]]:
    plate = of[0].plate
    return [
        ("Operating points at rated voltage and frequency", points(of[0])),
        ("Equivalent circuit", parameters(of)),
        ("Assumed", assumptions(of)),
        ("Limits of the drive", limits_rows(plate, of[0], limits)),
    ]


def report(of: list[Variant], limits: Limits) -> str:
    """As text."""
    lines = [title(of[0].plate)]
    for heading, rows in tables(of, limits):
        lines += ["", heading]
        names, values = (max(len(getattr(row, part)) for row in rows) for part in ("name", "value"))
        lines += [f"  {row.name:<{names}}  {row.value:<{values}}  {row.note}".rstrip() for row in rows]
    return "\n".join(lines) + "\n"
