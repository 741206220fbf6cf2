"""One run of motulator's current-vector control with a step of the torque. It runs in the virtual environment of the
peers: python -m sextant_py.bench.motulator_run CASE.json RESULT.npz."""

import importlib.metadata
import json
import math
import sys
from pathlib import Path

import numpy as np

from .peer_runs import motulator_drive, motulator_parameters

# Points of a period at least, between which the torque counts as linear.
POINTS_OF_A_PERIOD = 4


def simulate(case: dict):
    """The drive of motulator after the run."""
    from motulator.drive import model
    from motulator.drive.control import im

    par = motulator_parameters(case["machine"])
    plant = motulator_drive(par, case["u_dc_v"], case["speed_rad_s"])
    reference = im.CurrentReferenceCfg(
        par,
        max_i_s=case["current_limit_a"],
        nom_psi_R=case["rotor_flux_wb"],
        nom_u_s=case["u_dc_v"] / math.sqrt(3),
    )
    period_s = case["period_s"]
    controller = im.CurrentVectorControl(par, reference, T_s=period_s, sensorless=False)
    controller.current_ctrl = im.CurrentController(par, case["bandwidth_rad_s"])
    # The controller's clock is a sum of periods.
    controller.ref.tau_M = lambda t: case["torque_nm"] if t > case["step_s"] - 0.5 * period_s else 0.0
    model.Simulation(plant, controller).simulate(t_stop=case["end_s"], max_step=period_s / POINTS_OF_A_PERIOD)
    return plant


def main() -> None:
    case = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    plant = simulate(case)
    data = plant.machine.data
    kept = data.t >= case["keep_from_s"]
    np.savez(
        sys.argv[2],
        version=importlib.metadata.version("motulator"),
        t_s=data.t[kept],
        torque_nm=data.tau_M[kept],
        psi_s_wb=data.psi_ss[kept],
        i_s_a=data.i_ss[kept],
        u_s_v=data.u_ss[kept],
    )


if __name__ == "__main__":
    main()
