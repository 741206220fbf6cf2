"""scripts/identify: the magnetising inductance of a shaft that coasts."""

import math

import numpy as np
import pytest
from sextant_py.errors import UserError
from sextant_py.identify_machine import InverseGamma
from sextant_py.identify_no_load import fit


def test_flux_by_current_is_the_inductance_within_its_deviation() -> None:
    seed = 4
    made = np.random.default_rng(seed)
    machine = InverseGamma(0.435, 4.7e-3, 0.77, 80e-3)
    errors = []
    for _ in range(300):
        current = 13 * (1 + 0.01 * made.standard_normal(1000))
        found = fit(np.full(1000, 13 * 85e-3), current, np.full(1000, 30.0))
        of_flux = found.of(machine)
        assert of_flux.leakage + of_flux.l_magnetising == pytest.approx(found.l_s, rel=1e-12)
        assert (of_flux.r_s, of_flux.leakage, of_flux.r_rotor) == pytest.approx((0.435, 4.7e-3, 0.77), rel=3e-3)
        errors.append((found.l_s / 85e-3 - 1) / found.sigma)
    # Errors by their stated deviation follow Student's t with 9 degrees of freedom.
    assert np.std(errors) == pytest.approx(math.sqrt(9 / 7), abs=0.2)
    assert abs(np.mean(errors)) < 0.3


def test_a_drive_without_flux_is_refused() -> None:
    with pytest.raises(UserError, match="not magnetised"):
        fit(np.ones(100), np.zeros(100), np.zeros(100))
