"""The report's account of the vehicle: energies of braking, speeds and the loss of the flux."""

import math

import numpy as np
import pytest
from sextant_py.plots.trace import Trace
from studies.paper import road_load
from studies.paper import vehicle as paper_vehicle
from studies.paper.numbers import Numbers


def trace_of(torque_nm: list[float], power_w: list[float], omega: float = 10.0) -> Trace:
    count = len(torque_nm)
    values = {"torque_mean_nm": torque_nm, "power_w": power_w, "omega_m_rad_s": [omega] * count}
    return Trace(0.01 * np.arange(1, count + 1), {name: np.array(data) for name, data in values.items()})


def test_braking_counts_only_rows_that_brake() -> None:
    # 10 ms each; the first row has no length, driving and what is next to nothing do not count.
    trace = trace_of([0, 30, -20, -20, -10, -1], [-900, 400, -150, -130, 60, -500])
    shaft, fed_back, balance = paper_vehicle.braking_energies(trace)
    assert shaft == pytest.approx(0.01 * (200 + 200 + 100))
    assert fed_back == pytest.approx(0.01 * (150 + 130))
    assert balance == pytest.approx(0.01 * (150 + 130 - 60))


def test_shaft_power_takes_the_speed_half_way() -> None:
    trace = trace_of([2, 2, 2], [0, 0, 0])
    trace.values["omega_m_rad_s"] = np.array([1.0, 3.0, 5.0])
    assert paper_vehicle.shaft_power(trace) == pytest.approx([2, 4, 8])


def test_speeds_of_cycle_and_vehicle() -> None:
    trace = Trace(np.array([48.0, 48.5]), {"omega_m_rad_s": np.array([0.0, 10.0])})
    wanted, reached = paper_vehicle.speeds(trace)
    assert wanted == pytest.approx([2.8 * 1.609344, 4.2 * 1.609344])  # 2.8 mph at 48 s, 5.6 at 49 s
    assert reached == pytest.approx([0, 36 * paper_vehicle.wheel_radius_m()])


def test_magnetising_current_of_the_papers_machine() -> None:
    current, loss = paper_vehicle.magnetising(1.1)
    assert current == pytest.approx(1.1 * 2 * math.pi * 50 / (26.13 + 0.754))
    assert loss == pytest.approx(1.5 * 0.435 * current**2)
    assert paper_vehicle.magnetising(0.55)[1] == pytest.approx(loss / 4)


def test_fit_is_in_the_numbers_and_is_the_vehicles() -> None:
    numbers = Numbers()
    paper_vehicle.fit_numbers(numbers)
    residuals = [numbers[f"vehicle/fit/{k}/residual_nm"] for k in range(1, 11)]
    assert np.sqrt(np.mean(np.square(residuals))) == pytest.approx(numbers["vehicle/fit/rms_nm"])
    assert max(map(abs, residuals)) == pytest.approx(numbers["vehicle/fit/worst_nm"])
    assert numbers["vehicle/fit/radius_m"] == pytest.approx(paper_vehicle.wheel_radius_m(), abs=1e-4)
    assert numbers["vehicle/fit/rolling"] == road_load.fit().rolling_coefficient >= 0
