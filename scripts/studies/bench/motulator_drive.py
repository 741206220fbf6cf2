"""motulator's current-vector control of an induction machine, measured speed, the speed imposed, in whichever version
is installed: 0.18 where Python is 3.12 or newer, else 0.5. It runs in the virtual environment of the peers."""

import importlib.metadata
import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Setup:
    machine: dict[str, float]  # T model, as peer_runs.machine has it
    u_dc_v: float
    speed_rad_s: float  # mechanical
    rotor_flux_wb: float  # of the inverse-Γ model, without field weakening
    current_limit_a: float
    period_s: float
    end_s: float
    torque_nm: Callable[[float], float]  # over time [s]
    bandwidth_rad_s: float = 2 * math.pi * 200  # of the current control; motulator's default
    max_step_s: float = math.inf  # of the solver
    switched: bool = True  # False: the inverter's voltage is the mean of each period


@dataclass(frozen=True)
class Run:
    simulated_s: float
    cpu_s: float
    points: dict[str, Any]  # of the solver: time, torque, stator flux, current and voltage


def version() -> str:
    return importlib.metadata.version("motulator")


def inverse_gamma(m: dict[str, float]) -> dict[str, float]:
    """Parameters of the inverse-Γ model, as motulator names them, from the T model."""
    l_s, l_r = m["l_m"] + m["l_sigma_s"], m["l_m"] + m["l_sigma_r"]
    k_r = m["l_m"] / l_r
    return {
        "n_p": m["n_p"],
        "R_s": m["r_s"],
        "R_R": k_r**2 * m["r_r"],
        "L_sgm": l_s - k_r * m["l_m"],
        "L_M": k_r * m["l_m"],
    }


def run(setup: Setup) -> Run:
    return run_0_5(setup) if version().startswith("0.5.") else run_0_18(setup)


def run_0_18(setup: Setup) -> Run:
    from motulator.common.model import SolverCfg
    from motulator.drive import model
    from motulator.drive.control import im

    par = im.InductionMachineInvGammaPars(**inverse_gamma(setup.machine))
    machine, mechanics = model.InductionMachine(par), model.ExternalRotorSpeed()
    mechanics.set_external_rotor_speed(setup.speed_rad_s)
    drive = model.Drive(machine, mechanics, model.VoltageSourceConverter(u_dc=setup.u_dc_v), pwm=setup.switched)
    controller = im.CurrentVectorController(
        par,
        im.CurrentVectorControllerCfg(
            # The stator flux without load, at which the rotor flux is that of the set-up.
            psi_s_nom=setup.rotor_flux_wb * (par.L_M + par.L_sgm) / par.L_M,
            i_s_max=setup.current_limit_a,
            alpha_c=setup.bandwidth_rad_s,
            sensorless=False,
            T_s=setup.period_s,
        ),
    )
    system = im.VectorControlSystem(controller)
    system.set_torque_ref(setup.torque_nm)
    solver = SolverCfg(max_step=setup.max_step_s)
    simulation = model.Simulation(drive, system, show_progress=False, cfg=solver)
    begin = time.process_time()
    found = simulation.simulate(t_stop=setup.end_s).mdl
    spent = time.process_time() - begin
    points = {
        "t_s": found.t,
        "torque_nm": found.machine.tau_M,
        "psi_s_wb": found.machine.psi_s_ab,
        "i_s_a": found.machine.i_s_ab,
        "u_s_v": found.machine.u_s_ab,
    }
    return Run(float(drive.t0), spent, points)


def run_0_5(setup: Setup) -> Run:
    from motulator.drive import model
    from motulator.drive.control import im
    from motulator.drive.utils import InductionMachineInvGammaPars, InductionMachinePars

    par = InductionMachineInvGammaPars(**inverse_gamma(setup.machine))
    drive = model.Drive(
        model.VoltageSourceConverter(u_dc=setup.u_dc_v),
        model.InductionMachine(InductionMachinePars.from_inv_gamma_model_pars(par)),
        model.ExternalRotorSpeed(w_M=lambda t: setup.speed_rad_s + 0 * t),
    )
    if setup.switched:
        drive.pwm = model.CarrierComparison()
    reference = im.CurrentReferenceCfg(
        par,
        max_i_s=setup.current_limit_a,
        nom_psi_R=setup.rotor_flux_wb,
        nom_u_s=setup.u_dc_v / math.sqrt(3),
    )
    controller = im.CurrentVectorControl(par, reference, T_s=setup.period_s, sensorless=False)
    controller.current_ctrl = im.CurrentController(par, setup.bandwidth_rad_s)
    controller.ref.tau_M = setup.torque_nm
    simulation = model.Simulation(drive, controller)
    begin = time.process_time()
    simulation.simulate(t_stop=setup.end_s, max_step=setup.max_step_s)
    spent = time.process_time() - begin
    data = drive.machine.data
    points = {
        "t_s": data.t,
        "torque_nm": data.tau_M,
        "psi_s_wb": data.psi_ss,
        "i_s_a": data.i_ss,
        "u_s_v": data.u_ss,
    }
    return Run(float(drive.t0), spent, points)
