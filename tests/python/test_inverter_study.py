"""scripts/inverter_study: what it counts as right, and what its table shows."""

import pytest
from studies.commissioning import inverter_study as study

METRICS = {"torque_motoring_nm": 100.0, "torque_regenerating_nm": 80.0, "torque_bias_nm": 0.0}


@pytest.mark.parametrize(
    ("torque", "bias", "kind"),
    [
        (60, 4.9, study.RIGHT),
        (60, 5.1, study.WRONG),
        (120, -20.0, study.DERATED),  # 100 N·m of 120, as published
        (120, 0.0, study.WRONG),  # more than published
        (-120, 40.0, study.DERATED),  # regenerating
        (-60, None, study.WRONG),  # no torque at all
    ],
)
def test_a_point_is_judged_by_the_torque_that_is_due(torque: float, bias: float | None, kind: str) -> None:
    assert study.judged(METRICS | {"torque_bias_nm": bias}, [], 50, torque)["kind"] == kind


def test_a_fault_is_a_trip_whatever_the_torque() -> None:
    found = study.judged(METRICS, [{"fault": "FLUX_LOST", "t_s": 0.25}], 50, 60)
    assert found == {"kind": study.TRIPPED, "why": "FLUX_LOST at 0.250 s"}


def test_the_table_counts_points_and_shows_the_largest_error_of_those_that_are_right() -> None:
    rows = [
        {"method": "foc", "case": "c", "speed": speed} | study.judged(METRICS | {"torque_bias_nm": bias}, [], speed, 60)
        for speed, bias in ((50, 0.25), (100, -1.5), (10, 30.0), (200, -30.0))
    ]
    assert study.table(rows, {("foc", "c"): 23.6}).splitlines()[-1] == "| c | foc | 2 | 0 | 0 | 2 | 1 | 1.50 | 24 |"


def test_every_case_has_a_name_of_its_own_and_a_pulse_is_told_to_the_drive_alone() -> None:
    every = (study.CASES, study.DROPS_CASES, study.PULSES_CASES, study.IRON_CASES, study.SATURATION_CASES)
    names = [case.name for cases in every for case in cases]
    assert len(set(names)) == len(names)
    for untold, told in zip(study.PULSES_CASES[::2], study.PULSES_CASES[1::2], strict=True):
        extra = {key: value for key, value in told.settings.items() if key not in untold.settings}
        assert extra == {
            "drive.inverter.minimum_pulse_us": told.settings["plant.inverter.minimum_pulse_us"],
            "drive.inverter.short_pulses": told.settings["plant.inverter.short_pulses"],
        }
