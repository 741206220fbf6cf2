"""What `nameplate` writes for the programs: the machine, the drive, and a run of it."""

import math
from pathlib import Path

from .nameplate_limits import Limits
from .nameplate_plate import NamePlate
from .nameplate_spread import PARAMETERS, Variant, span
from .sweep_file import toml_value

# Kinetic energy at synchronous speed by rated power, of a rotor alone: some 0.04 s at 1 kW, with the cube root of the
# power (catalogues of cage motors from 0.2 to 200 kW are within a factor of 2.5).
INERTIA_S, INERTIA_EXPONENT = 0.04, 1 / 3
NOMINAL_RISE_K, AMBIENT_C = 80, 40  # thermal class B, which most windings keep; IEC 60034-1
STEP_S, FROM_S, END_S = 1.5, 2.0, 2.5  # of the run's torque, of its window
TOLERANCE = 0.1  # of its torque
BELOW_BASE = 0.9  # of the base speed, where half of the rated speed is above it
# Of the simulated sensors, by the trip level; the noise is what the protections take it for by default.
SENSOR_RANGE, SENSOR_NOISE, SENSOR_BITS = 1.25, 0.001, 12


def inertia_of(plate: NamePlate) -> float:
    """Of the plate, else assumed. [kg·m²]"""
    if plate.inertia_kg_m2 is not None:
        return plate.inertia_kg_m2
    constant = INERTIA_S * (plate.power_w / 1e3) ** INERTIA_EXPONENT
    return 2 * constant * plate.power_w / plate.synchronous_rad_s**2


def number(value: float) -> str:
    return f"{value:.5g}"


def title(plate: NamePlate) -> str:
    return (
        f"{plate.power_w / 1e3:g} kW, {plate.voltage_v:g} V {plate.connection}, {plate.current_a:.4g} A, "
        f"{plate.frequency_hz:g} Hz, {plate.speed_rpm:.5g} r/min, cos phi {plate.power_factor:.3g}, {plate.poles} poles"
    )


def machine_text(of: list[Variant]) -> str:
    plate = of[0].plate
    lines = [
        f"# Three-phase induction machine by its name plate: {title(plate)}.",
        "# Equivalent star. Behind each value: the range by what the plate leaves open.",
    ]
    for key, quantity in PARAMETERS.items():
        low, value, high = span(of, quantity)
        lines.append(f"{key} = {number(value)}  # {low:.3g} to {high:.3g}")
    inertia = "" if plate.inertia_kg_m2 is not None else "  # assumed by the power: of the rotor alone"
    lines += [
        f"reactance_frequency_hz = {plate.frequency_hz:g}",
        f"poles = {plate.poles}",
        f"inertia_kg_m2 = {number(inertia_of(plate))}{inertia}",
    ]
    return "\n".join(lines) + "\n"


def drive_text(plate: NamePlate, limits: Limits, machine: str, method: str, period_us: float) -> str:
    rated = math.sqrt(2) * plate.current_a
    sensor_range = SENSOR_RANGE * limits.over_current_a
    step = 2 * sensor_range / 2**SENSOR_BITS
    return f"""# The drive of {machine} by its name plate: {title(plate)}.
# Rated torque {plate.torque_nm:.4g} N·m, rated current {rated:.4g} A peak. Base of ecu.toml and half_speed.toml.
machine = {toml_value(machine)}

[control]
controller = {toml_value(method)}
flux_reference_wb = {number(limits.flux_wb)}  # of the stator at the rated point
[control.{method}]
magnetising_current_a = {number(limits.magnetising_a)}
hand_over_current_a = {number(limits.hand_over_a)}

[drive]
period_us = {period_us:g}
current_limit_a = {number(limits.current_limit_a)}  # of the torque limit, with the worst of the parameters' ranges

[command]
torque_limit_nm = {number(limits.torque_nm)}  # {limits.torque_nm / plate.torque_nm:.3g} of the rated torque

[protection]
over_current_a = {number(limits.over_current_a)}
over_speed_rad_s = {number(limits.over_speed_rad_s)}
current_jump_a = {number(limits.current_jump_a)}  # by the range of the leakage
current_step_a = {number(step)}  # of the converter below
[protection.winding]
nominal_current_a = {number(plate.current_a)}  # RMS
nominal_rise_k = {NOMINAL_RISE_K}  # assumed: thermal class B
ambient_c = {AMBIENT_C}

[plant]
u_dc_v = {number(limits.u_dc_v)}
[plant.sensors.current]  # of the simulation
range_a = {number(sensor_range)}
bits = {SENSOR_BITS}
noise_a = {number(SENSOR_NOISE * limits.over_current_a)}
[plant.sensors.voltage]
range_v = {number(2 * limits.u_dc_v)}
bits = {SENSOR_BITS}
"""


ECU = """# sextant-ecu with the drive of drive.toml on its simulated machine. --print-config shows every key.
base = "drive.toml"
drive_id = 1

[realtime]
required = false
overrun_limit = 1000  # a desktop is late now and then

[can]
bus = "udp_multicast:239.74.163.2:43113"  # a CAN interface: "socketcan:can0"
"""


def run_text(plate: NamePlate, limits: Limits, period_us: float) -> str:
    """At half of the rated speed, or where a link is too low for that, at the most it suffices for."""
    torque = plate.torque_nm
    speed_rad_s = min(plate.speed_rad_s / 2, BELOW_BASE * limits.base_speed_rad_s)
    share = speed_rad_s / plate.speed_rad_s
    return f"""# Rated torque at {share:.2g} of the rated speed, within {TOLERANCE:.0%}: sextant-mil half_speed.toml.
base = "drive.toml"
name = "half_speed"
duration_s = {END_S}

[profile.torque_nm]
shape = "steps"
points = [[0, 0], [{STEP_S}, {number(torque)}]]

[load]
kind = "imposed_speed"
speed_rad_s = {{ shape = "constant", value = {number(speed_rad_s)} }}

[plant]
integrator = "exact"

[metrics]
window_from_s = {FROM_S}

[trace]
interval_us = {number(period_us * max(1, round(1000 / period_us)))}

[expect]
torque_bias_nm = {{ min = {number(-TOLERANCE * torque)}, max = {number(TOLERANCE * torque)} }}
"""


def write(directory: Path, name: str, of: list[Variant], limits: Limits, method: str, period_us: float) -> list[Path]:
    """NAME.toml, drive.toml, ecu.toml and half_speed.toml."""
    plate, machine = of[0].plate, f"{name}.toml"
    texts = {
        machine: machine_text(of),
        "drive.toml": drive_text(plate, limits, machine, method, period_us),
        "ecu.toml": ECU,
        "half_speed.toml": run_text(plate, limits, period_us),
    }
    for file, text in texts.items():
        (directory / file).write_text(text, encoding="utf-8")
    return [directory / file for file in texts]
