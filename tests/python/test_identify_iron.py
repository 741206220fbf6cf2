"""scripts/identify: iron loss from shafts that coast at several fluxes."""

import math
import tomllib
from pathlib import Path

import numpy as np
import pytest
from programs import program
from sextant_py import identify, identify_iron, identify_saturation
from sextant_py.identify_inertia import Inertia
from sextant_py.identify_no_load import NoLoad, acceleration
from test_identify import drive_file

FLUX_WB, POLE_PAIRS, INERTIA = 1.1, 2, 0.089
NOTHING = np.zeros(1)


def inertia(sigma: float = 1e-4) -> Inertia:
    return Inertia(INERTIA, sigma, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, NOTHING, NOTHING, NOTHING, NOTHING)


def coasting(resistance_ohm: float, friction_nm: float, noise: float, seed: int, speed: float = 70.0) -> list[NoLoad]:
    """By the power that a resistance takes and that of a friction, from the energy of the shaft."""
    made = np.random.default_rng(seed)
    points = []
    for share in identify_saturation.SHARES:
        flux = share * FLUX_WB
        loss_w = 3 / 2 * (POLE_PAIRS * speed * flux) ** 2 / resistance_ohm + friction_nm * abs(speed)
        slows = loss_w / (INERTIA * abs(speed)) + noise * made.standard_normal()
        points.append(NoLoad(flux, flux / 85e-3, 1e-3, speed, -math.copysign(slows, speed)))
    return points


@pytest.mark.parametrize("speed", [70.0, -70.0])
def test_the_loss_is_what_the_shaft_loses_beside_its_friction(speed: float) -> None:
    found = identify_iron.fit(coasting(300, 0.7, 0, 1, speed), inertia(), POLE_PAIRS)
    assert found.resistance_ohm == pytest.approx(300, rel=1e-9)
    assert found.friction_nm == pytest.approx(0.7, rel=1e-9)
    assert found.loss_w == pytest.approx(3 / 2 * (140 * 1.1) ** 2 / 300)
    assert found.omega_e == pytest.approx(140)


def test_the_stated_deviation_is_that_of_the_results() -> None:
    """Errors by their deviation follow Student's t with 3 degrees of freedom, whose median of |t| is 0.765."""
    errors = []
    for seed in range(400):
        found = identify_iron.fit(coasting(100, 0.7, 0.2, seed), inertia(0), POLE_PAIRS)
        assert found
        errors.append((100 / found.resistance_ohm - 1) / found.sigma)
    assert np.median(np.abs(errors)) == pytest.approx(0.765, abs=0.12)


def test_iron_that_loses_nothing_that_is_certain_is_not_told() -> None:
    told = [identify_iron.fit(coasting(1e9, 0.7, 0.2, seed), inertia(), POLE_PAIRS) for seed in range(100)]
    assert sum(one is not None for one in told) <= 8


def test_the_slope_of_a_speed_is_that_of_its_line() -> None:
    time = np.linspace(1, 1.3, 301)
    assert acceleration(time, 70 - 5 * (time - 1)) == pytest.approx(-5)


def test_a_coasting_shaft_tells_the_iron_loss_of_a_drive(tmp_path: Path) -> None:
    """The loss that the plant has by its law, at the frequency of the course, beside friction."""
    file = drive_file(tmp_path, "[plant.iron_loss]\neddy_ohm = 600\nhysteresis_ohm = 600\n")
    words = [str(file), "--only", "impedance,no_load,inertia", "--out", str(tmp_path)]
    for key in (
        "drive.period_us=125",
        "drive.iron_loss_resistance_ohm=500",
        "plant.viscous_friction_nm_s=0.01",
        "machine.inertia_kg_m2=0.5",
    ):
        words += ["--set", key]
    assert identify.main([*words, "--mil", str(program("sextant-mil"))]) == 0
    text = (tmp_path / "iron.toml").read_text(encoding="utf-8")
    omega = 2 * math.pi * float(text.split(" Hz")[0].split()[-1])
    behind_leakage = 1 - 4.732e-3 / 85.57e-3
    conductance = behind_leakage**2 * (1 / 600 + 2 * math.pi * 50 / omega / 600)
    assert tomllib.loads(text)["drive"]["iron_loss_resistance_ohm"] == pytest.approx(1 / conductance, rel=0.06)
