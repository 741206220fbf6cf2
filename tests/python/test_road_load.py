"""The road load that is fitted to Table 5 of the paper."""

import tomllib

import numpy as np
import pytest
from sextant_py.errors import UserError
from sextant_py.paths import ROOT
from studies.paper import road_load


def test_the_vehicle_holds_what_the_fit_gives() -> None:
    text = (ROOT / "configs/vehicles/micro_ev.toml").read_text(encoding="utf-8")
    vehicle = tomllib.loads(text)
    load = road_load.fit()
    assert vehicle["wheel_radius_m"] == round(load.wheel_radius_m, 4)
    assert vehicle["rolling_coefficient"] == round(load.rolling_coefficient, 4)
    assert vehicle["drag_area_m2"] == round(load.drag_area_m2, 3)
    assert vehicle["mass_kg"] == road_load.MASS_KG
    assert vehicle["motors"] == road_load.MOTORS
    assert vehicle["air_density_kg_m3"] == road_load.AIR_DENSITY_KG_M3
    assert f"{load.rms_nm:.2f} N·m RMS and {load.worst_nm:.2f} N·m at most" in text


def test_the_residual_is_the_table_minus_the_road() -> None:
    load = road_load.fit()
    force = load.rolling_coefficient * 200 * 9.80665 + 0.5 * 1.2 * load.drag_area_m2 * load.speed_m_s**2
    np.testing.assert_allclose(load.torque_nm - force * load.wheel_radius_m / 2, load.residual_nm, atol=1e-12)
    assert load.worst_nm < 1.0
    assert load.residual_nm.size == 10


def test_a_known_vehicle_is_found_again(tmp_path) -> None:
    speed = np.array([10.0, 20.0, 40.0, 60.0])
    radius, rolling, area = 0.3, 0.012, 0.7
    v = speed / 3.6
    torque = radius / 2 * (200 * 9.80665 * rolling + 0.6 * area * v**2)
    wheel = v / radius * 30 / np.pi
    rows = [f"{t},{s},{w}" for t, s, w in zip(torque, speed, wheel, strict=True)]
    file = tmp_path / "states.csv"
    file.write_text("# known\ntorque_nm,vehicle_speed_kmh,wheel_speed_rpm\n" + "\n".join(rows), encoding="utf-8")
    load = road_load.fit(file)
    assert (load.wheel_radius_m, load.rolling_coefficient, load.drag_area_m2) == pytest.approx((radius, rolling, area))


def test_a_bad_table_is_refused_by_name(tmp_path) -> None:
    file = tmp_path / "states.csv"
    file.write_text("torque_nm,vehicle_speed_kmh,wheel_speed_rpm\n1,fast,3\n", encoding="utf-8")
    with pytest.raises(UserError, match=r"states\.csv is not a table of steady states"):
        road_load.fit(file)
