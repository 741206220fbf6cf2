"""What counts as a drive that does not deliver the torque asked for."""

import pytest
from sextant_py.tracking import Tracking


def played(samples: list[tuple[float, float, float]]) -> Tracking:
    tracking = Tracking()
    for time_s, asked, delivered in samples:
        tracking.add(time_s, asked, delivered)
    return tracking


def test_a_step_that_arrives_within_the_window_is_followed() -> None:
    steps = [(k / 100, 0.0 if k < 50 else 40.0, 0.0 if k < 58 else 39.0) for k in range(100)]
    assert played(steps).sentence() is None


def test_the_ripple_of_switching_is_no_deviation() -> None:
    assert played([(k / 100, 20.0, 20.0 if k < 10 else 28.0 if k % 2 else 12.0) for k in range(100)]).sentence() is None


def test_a_ramp_is_followed_with_a_delay() -> None:
    assert played([(k / 100, 80 * k / 100, 80 * (k - 5) / 100) for k in range(100)]).sentence() is None


@pytest.mark.parametrize(("delivered", "off"), [(25.1, True), (24.9, False), (14.9, True), (15.1, False)])
def test_the_tolerance(delivered: float, off: bool) -> None:
    tracking = played([(k / 100, 20.0, delivered) for k in range(100)])
    assert bool(tracking.deviation_nm) is off
    assert (tracking.sentence() is not None) is off


def test_the_time_and_the_worst_deviation_are_said() -> None:
    samples = [(k / 100, 20.0, 20.0) for k in range(200)] + [(2 + k / 100, 20.0, -19.0) for k in range(300)]
    tracking = played(samples)
    assert tracking.off_s == pytest.approx(3.0, abs=0.1)
    assert tracking.total_s == pytest.approx(4.99)
    assert "during 3.0 of 5.0 s, by -39 N·m at worst" in tracking.sentence()


def test_a_pause_forgets_what_was_asked() -> None:
    tracking = played([(0.0, 20.0, 20.0)])
    tracking.pause()
    tracking.add(0.05, 0.0, 20.0)
    assert tracking.deviation_nm == 20.0
