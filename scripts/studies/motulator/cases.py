"""The operating points at which Sextant and motulator run, and what each is set to there."""

import itertools
import math
from dataclasses import asdict, dataclass

from sextant_py.sweep_file import Settings

from studies.bench.peer_runs import machine
from studies.torque_map.drive import CURRENT_LIMIT, DELAY, Drive

POINTS = ((0, 15), (0, 60), *itertools.product((50, 100), (-60, -15, 15, 60)))  # mechanical [rad/s], [N·m]
FEW = ((50, -60), (50, 60))
# By control period [us]. motulator simulates a second at 25 us in some minutes.
PLAN = {250: POINTS, 125: POINTS, 25: FEW}
QUICK_PLAN = {250: FEW}
SHOWN = (50, 60)  # of the picture and of the values on the page
BANDWIDTH_RAD_S = 2 * math.pi * 200  # of both current controllers; motulator's default
STEP_S, WINDOW_S, END_S = 0.9, 1.4, 1.8
CURVE_S = (STEP_S - 0.5e-3, STEP_S + 5e-3)  # of the picture


@dataclass(frozen=True)
class Plant:
    """What both drives have in common."""

    machine: dict  # T model, as bench/peer_runs.py has it
    u_dc_v: float
    flux_wb: float  # stator flux, magnitude
    current_limit_a: float

    @staticmethod
    def of(drive: Drive) -> "Plant":
        found = drive.configuration
        return Plant(
            machine(drive.machine), found["plant.u_dc_v"], found["control.flux_reference_wb"], found[CURRENT_LIMIT]
        )


@dataclass(frozen=True)
class Case:
    """One run of each: a torque step at imposed speed, the machine magnetised before."""

    period_us: float
    speed_rad_s: float  # mechanical
    torque_nm: float


def cases(plan: dict[float, tuple]) -> list[Case]:
    return [Case(period, *point) for period, points in plan.items() for point in points]


def rotor_flux(m: dict, flux_wb: float, torque_nm: float) -> float:
    """Rotor flux of the inverse-Γ model in the steady state with this stator flux and torque. [Wb]

    ψ_s² = (1 + L_σ/L_M)² ψ_R² + (L_σ i_q)² with i_q = T/(3/2 p ψ_R)."""
    l_sigma, l_main, _ = inverse_gamma(m)
    along = (1 + l_sigma / l_main) ** 2
    across = (l_sigma * torque_nm / (1.5 * m["n_p"])) ** 2
    return math.sqrt((flux_wb**2 + math.sqrt(flux_wb**4 - 4 * along * across)) / (2 * along))


def inverse_gamma(m: dict) -> tuple[float, float, float]:
    """L_σ [H], L_M [H] and R_R [Ω] of the T model."""
    k_r = m["l_m"] / (m["l_m"] + m["l_sigma_r"])
    return m["l_sigma_s"] + k_r * m["l_sigma_r"], k_r * m["l_m"], k_r**2 * m["r_r"]


def steady_state(plant: Plant, case: Case) -> dict[str, float]:
    """The sinusoidal steady state by the machine's equations, without the inverter's ripple."""
    m = plant.machine
    _, l_main, r_r = inverse_gamma(m)
    psi_r = rotor_flux(m, plant.flux_wb, case.torque_nm)
    i_d, i_q = psi_r / l_main, case.torque_nm / (1.5 * m["n_p"] * psi_r)
    slip = r_r * i_q / psi_r
    copper = 1.5 * (m["r_s"] * (i_d**2 + i_q**2) + r_r * i_q**2)
    return {
        "torque_nm": case.torque_nm,
        "current_a": math.hypot(i_d, i_q),
        "flux_wb": plant.flux_wb,
        "stator_rad_s": m["n_p"] * case.speed_rad_s + slip,
        "slip_rad_s": slip,
        "power_w": case.torque_nm * case.speed_rad_s + copper,
    }


def sextant_settings(case: Case) -> Settings:
    """What sextant-mil is told beside the drive of configs/ecu.toml."""
    return {
        "duration_s": END_S,
        "control.controller": "foc",
        "control.foc.bandwidth_rad_s": BANDWIDTH_RAD_S,
        "control.foc.pattern": "asymmetric",
        "drive.period_us": case.period_us,
        DELAY: 1,
        "load.kind": "imposed_speed",
        "load.speed_rad_s.value": case.speed_rad_s,
        "profile.torque_nm.shape": "steps",
        "profile.torque_nm.points": [[0, 0], [STEP_S, case.torque_nm]],
        "metrics.step_s": STEP_S,
        "metrics.window_from_s": WINDOW_S,
        "trace.interval_us": case.period_us,
        "trace.signals": ["standard", "energy"],
    }


def motulator_case(plant: Plant, case: Case) -> dict:
    """What bench/motulator_run.py is told."""
    return asdict(plant) | {
        "rotor_flux_wb": rotor_flux(plant.machine, plant.flux_wb, case.torque_nm),
        "period_s": case.period_us * 1e-6,
        "speed_rad_s": case.speed_rad_s,
        "torque_nm": case.torque_nm,
        "bandwidth_rad_s": BANDWIDTH_RAD_S,
        "step_s": STEP_S,
        "end_s": END_S,
        "keep_from_s": min(CURVE_S[0], STEP_S) - 1e-3,
    }
