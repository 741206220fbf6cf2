"""One run of motulator's current-vector control with a step of the torque. It runs in the virtual environment of the
peers: python -m studies.bench.motulator_run CASE.json RESULT.npz."""

import json
import sys
from pathlib import Path

import numpy as np

from . import motulator_drive
from .motulator_drive import Setup

# Points of a period at least, between which the torque counts as linear.
POINTS_OF_A_PERIOD = 4


def setup_of(case: dict) -> Setup:
    period_s = case["period_s"]
    return Setup(
        machine=case["machine"],
        u_dc_v=case["u_dc_v"],
        speed_rad_s=case["speed_rad_s"],
        rotor_flux_wb=case["rotor_flux_wb"],
        current_limit_a=case["current_limit_a"],
        period_s=period_s,
        end_s=case["end_s"],
        # The controller's clock is a sum of periods.
        torque_nm=lambda t: case["torque_nm"] if t > case["step_s"] - 0.5 * period_s else 0.0,
        bandwidth_rad_s=case["bandwidth_rad_s"],
        max_step_s=period_s / POINTS_OF_A_PERIOD,
    )


def main() -> None:
    case = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    points = motulator_drive.run(setup_of(case)).points
    kept = points["t_s"] >= case["keep_from_s"]
    np.savez(sys.argv[2], version=motulator_drive.version(), **{name: values[kept] for name, values in points.items()})


if __name__ == "__main__":
    main()
