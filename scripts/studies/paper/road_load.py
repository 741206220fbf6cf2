"""Road load of a vehicle from the steady states of configs/vehicles/passive_ev.csv (paper, Table 5).

At a steady speed v the motors hold what rolls and what the air takes,

    n tau / r = m g c_rr + 1/2 rho cdA v²,

which is linear in the rolling coefficient c_rr and the drag area cdA. Both are fitted by least squares of the motor
torque, neither below zero. The wheel radius r is fitted by least squares of v = r omega.

    python -m studies.paper.road_load          the fit with its residuals; run it in scripts/
"""

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import scipy.optimize
from sextant_py.errors import UserError
from sextant_py.paths import ROOT

STEADY_STATES = ROOT / "configs/vehicles/passive_ev.csv"
MASS_KG = 200.0  # paper, 3.5
MOTORS = 2  # paper, 3.5: two wheels of equal size, each with its motor
AIR_DENSITY_KG_M3 = 1.2
GRAVITY_M_S2 = 9.80665


@dataclass(frozen=True)
class RoadLoad:
    """What Table 5 says of the vehicle, and how well it says it."""

    wheel_radius_m: float
    rolling_coefficient: float
    drag_area_m2: float
    speed_m_s: np.ndarray
    torque_nm: np.ndarray  # of one motor, as the table has it
    residual_nm: np.ndarray  # of one motor, table minus fit

    @property
    def rms_nm(self) -> float:
        return float(np.sqrt(np.mean(self.residual_nm**2)))

    @property
    def worst_nm(self) -> float:
        return float(np.max(np.abs(self.residual_nm)))


def steady_states(path: Path = STEADY_STATES) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Torque [N·m], vehicle speed [m/s] and wheel speed [rad/s]."""
    try:
        lines = [line for line in path.read_text(encoding="utf-8").splitlines() if line and not line.startswith("#")]
        rows = list(csv.DictReader(lines))
        table = {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}
        torque, speed, wheel = (table[k] for k in ("torque_nm", "vehicle_speed_kmh", "wheel_speed_rpm"))
    except (OSError, IndexError, KeyError, TypeError, ValueError) as error:
        raise UserError(f"{path} is not a table of steady states: {error}.") from None
    return torque, speed / 3.6, wheel * (2 * np.pi / 60)


def fit(path: Path = STEADY_STATES) -> RoadLoad:
    """The road load of the steady states in a file."""
    torque, speed, wheel = steady_states(path)
    radius = float(speed @ wheel / (wheel @ wheel))
    share = radius / MOTORS
    rolling = np.full_like(speed, share * MASS_KG * GRAVITY_M_S2)
    drag = share * 0.5 * AIR_DENSITY_KG_M3 * speed**2
    (coefficient, area), _ = scipy.optimize.nnls(np.column_stack([rolling, drag]), torque)
    coefficient, area = float(coefficient), float(area)
    return RoadLoad(radius, coefficient, area, speed, torque, torque - coefficient * rolling - area * drag)


def main() -> None:
    load = fit()
    print(f"wheel radius         {load.wheel_radius_m:.4f} m")
    print(f"rolling coefficient  {load.rolling_coefficient:.4f}")
    print(f"drag area            {load.drag_area_m2:.3f} m² with {MOTORS} motors and {AIR_DENSITY_KG_M3} kg/m³")
    print(f"residual             {load.rms_nm:.2f} N·m RMS, {load.worst_nm:.2f} N·m at most")
    for speed, torque, residual in zip(load.speed_m_s, load.torque_nm, load.residual_nm, strict=True):
        print(f"  {speed * 3.6:5.1f} km/h  {torque:6.1f} N·m  {residual:+6.2f}")


if __name__ == "__main__":
    main()
