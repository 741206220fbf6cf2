"""The bench of control methods: options, choice of periods, and that the committed page is that of its results."""

import subprocess

import pytest
from sextant_py.paths import ROOT
from studies import json_file
from studies.bench import speed
from studies.controllers import cases as controller_cases
from studies.controllers import compare_controllers
from studies.controllers import cost as controller_cost
from studies.controllers import figures as controller_figures
from studies.controllers import page as controller_page
from studies.controllers.measure import Record, Results, common_period


def test_help_has_examples() -> None:
    command = [ROOT / "scripts/compare_controllers", "--help"]
    found = subprocess.run(command, capture_output=True, text=True, check=True)
    assert "scripts/compare_controllers --quick" in found.stdout


def tuned(period_us: float, frequency: float | None, reason: str = "") -> Record:
    return Record("tuning", "m", [period_us], reason, {"switching_frequency_hz": frequency})


def test_the_common_period_is_the_one_that_switches_nearest_to_the_frequency() -> None:
    records = [tuned(5, 200e3), tuned(50, 20e3), tuned(100, 10e3), tuned(12.5, 10e3, "OVERRUN at 0.1 s")]
    assert common_period(records) == 100
    assert common_period([tuned(20, 10.6e3), tuned(25, 8.8e3), tuned(40, None)]) == 20


def test_every_case_sets_the_delay_and_one_method_s_own_keys_alone() -> None:
    cases = controller_cases.grid("sampling", "foc", 25, (0, 50), (15,)) + controller_cases.starts("foc")
    assert len({(case.section, case.what) for case in cases}) == len(cases) == 4
    for case in cases:
        settings = dict(case.settings)
        assert settings["drive.actuation_delay_periods"] == 1
        assert not [key for key in settings if key.startswith("control.") and not key.startswith("control.foc.")]


def test_the_committed_page_is_that_of_its_results(tmp_path) -> None:
    (tmp_path / "images").mkdir()
    results = json_file.read(compare_controllers.RESULTS, Results, "compare_controllers")
    controller_page.write(results, tmp_path)
    committed = (ROOT / "docs/controllers.md").read_text(encoding="utf-8")
    assert (tmp_path / "controllers.md").read_text(encoding="utf-8") == committed
    assert not [record for record in results.records if record.reason]


def test_points_beyond_the_published_torque_do_not_count() -> None:
    metrics = {"torque_motoring_nm": 50.0, "torque_regenerating_nm": 80.0}
    assert controller_page.is_available(Record("sampling", "m", [100, 40], "", metrics))
    assert not controller_page.is_available(Record("sampling", "m", [100, 60], "", metrics))
    assert controller_page.is_available(Record("sampling", "m", [100, -60], "", metrics))


def test_the_radar_is_one_for_the_best_and_zero_for_ten_times_as_much() -> None:
    values = {"best": 0.2, "worse": 0.2 * 10**0.5, "bad": 3.0, "unknown": None}
    found = [controller_figures.score(values, method) for method in values]
    assert found == pytest.approx([1.0, 0.5, 0.0, 0.0])


def test_only_the_best_run_without_a_speed_sensor_and_every_method_the_cycle() -> None:
    for method in ("dtc", "predictive", *controller_cases.BEST):
        sensorless = controller_cases.sensorless(method)
        assert bool(sensorless) == (method in controller_cases.BEST)
        assert all(dict(c.settings)["control.flux_estimator"] == "sensorless_observer" for c in sensorless)
        assert controller_cases.cycles(method)[0].what == ("constant",)


def test_the_flux_error_is_half_of_its_range_by_its_middle() -> None:
    record = Record("sampling", "m", [0, 15], "", {"flux_min_wb": 0.99, "flux_max_wb": 1.01})
    assert controller_page.flux_error(record) == pytest.approx(0.01)


def test_every_method_has_its_place_wherever_methods_are_listed() -> None:
    methods = json_file.read(compare_controllers.RESULTS, Results, "compare_controllers").methods
    assert set(methods) == set(controller_cost.instructions()) == set(speed.METHODS)
    for page in ("docs/configuration.md", "docs/control.md", "docs/controllers.md"):
        text = (ROOT / page).read_text(encoding="utf-8")
        assert not [method for method in methods if method not in text], page
