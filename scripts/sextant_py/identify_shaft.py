"""The courses of `identify` that turn the shaft: field-oriented control follows a torque, without load."""

import math
from dataclasses import replace

from .errors import UserError
from .identify_inertia import Course, Inertia
from .identify_inertia import fit as fit_inertia
from .identify_machine import InverseGamma
from .identify_no_load import NoLoad, acceleration, current_along
from .identify_no_load import fit as fit_no_load
from .identify_run import CONTROL, Plant, Steps
from .sweep_file import Settings

NO_LOAD, INERTIA = "no_load", "inertia"
# Of the base speed. Without load the flux is measured by its voltage, beside which that of the inverter is to be small.
INERTIA_SPEED, NO_LOAD_SPEED = 0.25, 0.5
UNKNOWN_OHM = 1e9  # of the iron: the torque is that of stator flux and current, and a shaft without it shows the loss
DRIVE_LIMIT = 1.55  # by the current of the flux, that the drive's limit has at least
BEGIN_S = 0.1  # from the flux to the first torque
SETTLES = 3  # time constants of the rotor until flux and current belong together
FALLS = 18  # the same until the flux has fallen, which takes six of three
COUNTS_S = 0.3  # of a coasting shaft


def shaft_course(plant: Plant, machine: InverseGamma, inertia: float, share: float) -> tuple[Course, float]:
    """The course by which such an inertia reaches this share of the base speed, and that speed [rad/s].

    Its torque is 0.6 of what the limit of the current leaves beside the current of the flux:
      T = 3/2 p L_M i_d √(I² − i_d²)
    """
    configuration = plant.configuration
    pole_pairs = configuration["machine.poles"] / 2
    flux = configuration["control.flux_reference_wb"]
    i_d = flux / (machine.leakage + machine.l_magnetising)
    limit = configuration[f"{CONTROL}current_limit_a"]
    if limit < 1.1 * i_d:
        raise UserError(
            f"{CONTROL}current_limit_a of {limit:g} A leaves none for torque beside the {i_d:.3g} A of the flux: raise "
            f"it to {1.2 * i_d:.3g} A at least (--limit-a)."
        )
    torque = 0.6 * 1.5 * pole_pairs * machine.l_magnetising * i_d * math.sqrt(limit**2 - i_d**2)
    torque = min(torque, 0.9 * configuration["command.torque_limit_nm"])
    speed = share * configuration["plant.u_dc_v"] / math.sqrt(3) / flux / pole_pairs
    return Course(float(f"{torque:.4g}"), BEGIN_S, max(0.02, inertia * speed / torque)), speed


def turning(plant: Plant, name: str, told: Settings) -> Settings:
    """Of a drive that knows this and turns a shaft.

    Flux and torque of the course keep the current below the limit. That of the drive must leave half of the flux's
    current for torque: a limit that was set and leaves less is refused, the one by the estimate is raised.
    """
    limit = plant.configuration[f"{CONTROL}current_limit_a"]
    gamma = plant.estimate.terminals
    inductances = [gamma.leakage + gamma.l_magnetising, told.get("control.machine_estimate.l_m_h", math.inf)]
    flux_current = plant.configuration["control.flux_reference_wb"] / min(inductances)
    is_bounded = plant.sets(f"{CONTROL}current_limit_a")
    if limit < DRIVE_LIMIT * flux_current and is_bounded:
        raise UserError(
            f"{CONTROL}current_limit_a of {limit:g} A does not bound the course of {name}, whose flux takes "
            f"{flux_current:.3g} A: raise it to {DRIVE_LIMIT * flux_current:.3g} A at least (--limit-a), or leave "
            f"{name} out of --only."
        )
    magnetising: Settings = {"control.foc.magnetising_current_a": limit} if is_bounded else {}
    return (
        told
        | magnetising
        | {
            "control.controller": "foc",
            "drive.magnetise_first": True,
            "drive.iron_loss_resistance_ohm": UNKNOWN_OHM,
            "drive.current_limit_a": max(limit, DRIVE_LIMIT * flux_current),
        }
    )


def measure_inertia(plant: Plant, settings: Settings, course: Course) -> Inertia:
    """By a drive of `turning`, of `Plant.magnetising`."""
    columns = ("speed_rad_s", "torque_mean_nm")
    time, (speed, torque) = plant.follow(INERTIA, course.points[1:], course.end_s + 0.05, settings, columns)
    within = (time >= course.begin_s - 0.1 * course.part_s) & (time <= course.end_s + 0.02)
    return fit_inertia(time[within], speed[within], torque[within])


def _flux_share(share: float) -> Settings:
    """The drive without torque has this share of the flux reference, to which it falls with 3 τ_r; all limits are those
    of the whole flux."""
    if share == 1:
        return {"drive.flux_optimum": "constant"}
    return {"drive.flux_optimum": "max_torque_per_ampere", "drive.flux_least_share": share}


def measure_no_load(plant: Plant, settings: Settings, course: Course, share: float = 1.0) -> NoLoad:
    """At a share of the flux reference. The shaft coasts after the first part of the course, for as long as three time
    constants of the rotor by the estimate take, those of the flux where it falls, and 0.3 s more, which count."""
    coasts = course.begin_s + course.part_s
    settles = SETTLES if share == 1 else SETTLES + FALLS
    counts = coasts + settles * plant.estimate.terminals.tau_r
    torque: Steps = [course.points[1], (coasts, 0.0)]
    columns = ("flux_mean_wb", "speed_rad_s", "flux_angle_rad", "i_a_a", "i_b_a", "i_c_a")
    time, values = plant.follow(NO_LOAD, torque, counts + COUNTS_S, settings | _flux_share(share), columns)
    counted = (time >= counts) & (time <= counts + COUNTS_S + 1e-6)
    flux, speed, angle, *phases = (one[counted] for one in values)
    found = fit_no_load(flux, current_along(angle, phases), speed)
    return replace(found, acceleration=acceleration(time[counted], speed))
