"""Runs one of the peers on the paper's machine and prints as JSON what it took. It runs in the virtual environment of
the peers: python -m studies.bench.peer_runs TOOL SECONDS MACHINE.toml."""

import cmath
import importlib.metadata
import json
import math
import platform
import sys
import time
import tomllib
from pathlib import Path

from . import motulator_drive

PERIOD_S = 25e-6
U_DC_V = 530.0
OMEGA_M = 50.0  # imposed, mechanical [rad/s]
TORQUE_NM = 15.0


def machine(data: dict) -> dict[str, float]:
    """T model of a machine's file, inductances at its reactance frequency."""
    omega = 2 * math.pi * data["reactance_frequency_hz"]
    return {
        "n_p": data["poles"] // 2,
        "r_s": data["r_s_ohm"],
        "r_r": data["r_r_ohm"],
        "l_sigma_s": data["x_ls_ohm"] / omega,
        "l_sigma_r": data["x_lr_ohm"] / omega,
        "l_m": data["x_m_ohm"] / omega,
        "j": data["inertia_kg_m2"],
    }


def motulator(m: dict[str, float], seconds: float, switched: bool) -> tuple[float, float, float]:
    """Current-vector control, measured speed, the speed imposed; switched: with carrier comparison. Simulated and CPU
    time [s], torque at the end [N·m]."""
    run = motulator_drive.run(
        motulator_drive.Setup(
            machine=m,
            u_dc_v=U_DC_V,
            speed_rad_s=OMEGA_M,
            rotor_flux_wb=1.0,
            current_limit_a=60.0,
            period_s=PERIOD_S,
            end_s=seconds,
            torque_nm=lambda t: TORQUE_NM if t > 0.1 * seconds else 0.0,
            switched=switched,
        )
    )
    return run.simulated_s, run.cpu_s, float(run.points["torque_nm"][-1])


def switching_states(m: dict[str, float], steps: int) -> list[int]:
    """Leg states as numbers (leg a is the bit of 4), one a period, whose voltage follows the derivative of a flux of
    1 Wb that turns as fast as TORQUE_NM wants it."""
    shares = (1.0, cmath.exp(2j * math.pi / 3), cmath.exp(-2j * math.pi / 3))
    vectors = [
        2 / 3 * U_DC_V * sum(share for bit, share in zip((4, 2, 1), shares, strict=True) if n & bit) for n in range(8)
    ]
    omega = m["n_p"] * OMEGA_M + TORQUE_NM * m["r_r"] / (1.5 * m["n_p"])
    flux, states = 0j, []
    for k in range(steps):
        wanted = min(1.0, 50 * k * PERIOD_S) * cmath.exp(1j * omega * k * PERIOD_S)
        states.append(min(range(8), key=lambda n: abs(flux + PERIOD_S * vectors[n] - wanted)))
        flux += PERIOD_S * vectors[states[-1]]
    return states


def gem(m: dict[str, float], seconds: float, solver) -> tuple[float, float, float]:
    """Finite control set, the speed imposed; its action comes from a list, so that no controller is counted. Simulated
    and CPU time [s], torque at the end [N·m]."""
    import gym_electric_motor
    from gym_electric_motor.physical_systems import ConstantSpeedLoad

    environment = gym_electric_motor.make(
        "Finite-TC-SCIM-v0",
        tau=PERIOD_S,
        supply={"u_nominal": U_DC_V},
        motor={
            "motor_parameter": {
                "p": m["n_p"],
                "l_m": m["l_m"],
                "l_sigs": m["l_sigma_s"],
                "l_sigr": m["l_sigma_r"],
                "j_rotor": m["j"],
                "r_s": m["r_s"],
                "r_r": m["r_r"],
            }
        },
        load=ConstantSpeedLoad(omega_fixed=OMEGA_M),
        ode_solver=solver,
        constraints=(),
        visualization=(),
    )
    environment.reset(seed=1)
    system = environment.unwrapped.physical_system
    if abs(system.tau - PERIOD_S) > 1e-12 or abs(system.electrical_motor.motor_parameter["r_s"] - m["r_s"]) > 1e-12:
        raise SystemExit("gym-electric-motor did not take the period or the machine")
    steps = round(seconds / PERIOD_S)
    actions = switching_states(m, steps)
    begin = time.process_time()
    for action in actions:
        (state, _), *_ = environment.step(action)
    spent = time.process_time() - begin
    torque = state[system.state_names.index("torque")] * system.limits[system.state_names.index("torque")]
    return steps * PERIOD_S, spent, float(torque)


def run(tool: str, m: dict[str, float], seconds: float) -> tuple[str, tuple[float, float, float]]:
    """The tool's package, and what its run took."""
    if tool.startswith("motulator"):
        return "motulator", motulator(m, seconds, switched=tool == "motulator")
    from gym_electric_motor.physical_systems import EulerSolver, ScipyOdeSolver

    return "gym-electric-motor", gem(m, seconds, EulerSolver() if tool == "gem_euler" else ScipyOdeSolver())


def main() -> None:
    tool, seconds, file = sys.argv[1], float(sys.argv[2]), sys.argv[3]
    package, (simulated, spent, torque) = run(tool, machine(tomllib.loads(Path(file).read_text("utf-8"))), seconds)
    if not math.isfinite(torque):
        raise SystemExit(f"{tool}: the torque is {torque}")
    result = {
        "version": importlib.metadata.version(package),
        "python": platform.python_version(),
        "simulated_s": simulated,
        "cpu_s": spent,
        "torque": torque,
    }
    print(json.dumps(result))


if __name__ == "__main__":
    main()
