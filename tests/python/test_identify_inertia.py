"""scripts/identify: inertia from courses of speed that are integrated here."""

import itertools
import random
import re
import secrets

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from sextant_py.errors import UserError
from sextant_py.identify_files import Results, report
from sextant_py.identify_fit import Setup
from sextant_py.identify_inertia import Course, fit


def speeds(course: Course, time: np.ndarray, inertia: float, viscous: float, coulomb: float, load: float) -> np.ndarray:
    """A shaft from standstill; its friction has a sign that turns within 1e-3 of the fastest speed."""
    fastest = course.torque_nm * course.part_s / inertia
    ends = [0.0, *(at for at, _ in course.points[1:]), float(time[-1])]
    speed, found = 0.0, np.zeros(time.size)
    for begin, end in itertools.pairwise(ends):
        torque = torque_at(course, np.array([0.5 * (begin + end)]))[0]

        def slope(_: float, w: np.ndarray, torque: float = torque) -> np.ndarray:
            return (torque - viscous * w - coulomb * np.tanh(1e3 * w / fastest) - load) / inertia

        done = solve_ivp(
            slope, (begin, end), [speed], method="LSODA", dense_output=True, rtol=1e-8, atol=1e-8,
            max_step=course.part_s / 20,
        )  # fmt: skip
        within = (time >= begin) & (time <= end)
        found[within] = done.sol(time[within])[0]
        speed = done.y[0][-1]
    return found


def torque_at(course: Course, time: np.ndarray) -> np.ndarray:
    points = np.array(course.points)
    return points[np.searchsorted(points[:, 0], time, side="right") - 1, 1]


def mean_torque(course: Course, time: np.ndarray) -> np.ndarray:
    """Over the interval before each sample."""
    step = time[1] - time[0]
    inner = time[:, None] - step + step * (np.arange(100) + 0.5) / 100
    return np.mean(torque_at(course, np.maximum(inner, 0)), axis=1)


def test_friction_load_and_noise_leave_the_inertia_within_its_deviation() -> None:
    seed = secrets.randbits(32)
    print(f"seed {seed}")
    drawn, made = random.Random(seed), np.random.default_rng(seed)
    for _ in range(10):
        torque, part = 10 ** drawn.uniform(-1, 3), 10 ** drawn.uniform(-1.3, 0.5)
        speed = drawn.uniform(20, 100)
        inertia = torque * part / speed
        viscous, coulomb = drawn.uniform(0, 0.1) * torque / speed, drawn.uniform(0, 0.2) * torque
        load = drawn.uniform(-0.1, 0.1) * torque
        course = Course(torque, 0.2 * part, part)
        time = np.linspace(0, course.end_s + 0.1 * part, 600)
        measured = speeds(course, time, inertia, viscous, coulomb, load)
        measured += 2e-3 * speed * made.standard_normal(time.size)
        found = fit(time, measured, mean_torque(course, time))
        assert found.inertia == pytest.approx(inertia, rel=0.01)
        assert abs(found.inertia - inertia) < 6 * found.sigma + 1e-3 * inertia
        assert found.coulomb_nm == pytest.approx(coulomb, abs=0.02 * torque)
        assert found.load_nm == pytest.approx(load, abs=0.02 * torque)


def test_a_shaft_that_a_load_keeps_turning_one_way_tells_its_inertia() -> None:
    """Friction and load look alike then."""
    course = Course(10, 0.1, 0.2)
    time = np.linspace(0, 1, 600)
    speed = -100 + speeds(course, time, 0.1, 0, 0, 2)
    assert np.all(speed < 0)
    found = fit(time, speed, mean_torque(course, time))
    assert found.inertia == pytest.approx(0.1, rel=0.01)
    assert found.load_nm - found.coulomb_nm == pytest.approx(2, abs=0.1)


def test_a_speed_against_the_torque_is_refused() -> None:
    course = Course(10, 0.1, 0.2)
    time = np.linspace(0, 1, 400)
    with pytest.raises(UserError, match="does not follow the torque"):
        fit(time, -speeds(course, time, 0.1, 0, 0, 0), mean_torque(course, time))
    with pytest.raises(UserError, match="64 are needed"):
        fit(time[:30], time[:30], time[:30])


@pytest.mark.parametrize("constant", [0.0, 5.0, np.nan])
def test_a_speed_that_does_not_change_is_refused(constant: float) -> None:
    """As an encoder shows it of a shaft that is held."""
    course = Course(10, 0.1, 0.2)
    time = np.linspace(0, 1, 400)
    with pytest.raises(UserError, match="free to turn") as refused:
        fit(time, np.full(time.size, constant), mean_torque(course, time))
    assert "\n" not in str(refused.value)


def test_friction_is_never_negative_and_its_deviation_says_whether_it_shows() -> None:
    """Without friction, and noise in both directions: least squares alone make it negative half of the time. What is
    stated is that of Student's t with 12 degrees of freedom, beyond 3 of which lies 1 in 90."""
    made = np.random.default_rng(5)
    course = Course(10, 0.1, 0.2)
    time = np.linspace(0, 1, 600)
    clean, torque = speeds(course, time, 0.1, 0, 0, 0), mean_torque(course, time)
    found = [fit(time, clean + 0.05 * made.standard_normal(time.size), torque) for _ in range(100)]
    assert all(one.coulomb_nm >= 0 and one.viscous >= 0 for one in found)
    assert sum(one.coulomb_nm == 0 for one in found) > 20
    assert sum(one.coulomb_nm > 3 * one.coulomb_sigma_nm for one in found) < 5
    assert all(one.inertia == pytest.approx(0.1, rel=0.01) for one in found)
    said = report(Results(Setup(25e-6, 4.7e-3), inertia=found[0]))
    assert "not distinguishable from zero" in said
    with_friction = fit(time, speeds(course, time, 0.1, 0, 1.0, 0), torque)
    assert with_friction.coulomb_nm == pytest.approx(1, abs=0.2)
    said = report(Results(Setup(25e-6, 4.7e-3), inertia=with_friction))
    assert re.search(r"dry [0-9.]+ N·m, standard deviation", said)
