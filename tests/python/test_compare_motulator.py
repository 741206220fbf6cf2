"""The comparison with motulator: operating points, evaluation of both courses, and the committed page."""

import math
import subprocess

import numpy as np
import pytest
from sextant_py.paths import ROOT
from studies import json_file
from studies.bench.peer_runs import machine
from studies.motulator import cases as motulator_cases
from studies.motulator import compare_motulator
from studies.motulator import course as courses
from studies.motulator import page as motulator_page
from studies.motulator.cases import Case, Plant
from studies.motulator.measure import QUANTITIES, Record, Results

PAPER = {
    "r_s_ohm": 0.435,
    "r_r_ohm": 0.816,
    "x_ls_ohm": 0.754,
    "x_lr_ohm": 0.754,
    "x_m_ohm": 26.13,
    "reactance_frequency_hz": 50,
    "poles": 4,
    "inertia_kg_m2": 0.089,
}
PLANT = Plant(machine(PAPER), 530, 1.1, 200)
PERIOD_S = 250e-6


def test_help_has_examples() -> None:
    command = [ROOT / "scripts/compare_motulator", "--help"]
    found = subprocess.run(command, capture_output=True, text=True, check=True)
    assert "scripts/compare_motulator --quick" in found.stdout


@pytest.mark.parametrize("words", [["--jobs", "0"], ["--quick", "--page"], ["--frobnicate"]])
def test_wrong_arguments_are_refused(words: list[str]) -> None:
    with pytest.raises(SystemExit) as refused:
        compare_motulator.parse_arguments(words)
    assert refused.value.code == 2


@pytest.mark.parametrize(("speed", "torque"), [(0, 15), (50, -60), (100, 130)])
def test_the_steady_state_fulfils_the_equations_of_the_t_model(speed: float, torque: float) -> None:
    m, found = PLANT.machine, motulator_cases.steady_state(PLANT, Case(250, speed, torque))
    l_s, l_r, l_m = m["l_m"] + m["l_sigma_s"], m["l_m"] + m["l_sigma_r"], m["l_m"]
    slip, psi_s = found["slip_rad_s"], PLANT.flux_wb
    # 0 = R_r i_r + j ω_slip (L_r i_r + L_m i_s),  ψ_s = L_s i_s + L_m i_r
    share = -1j * slip * l_m / (m["r_r"] + 1j * slip * l_r)
    i_s = psi_s / (l_s + l_m * share)
    u_s = m["r_s"] * i_s + 1j * found["stator_rad_s"] * psi_s
    assert 1.5 * m["n_p"] * i_s.imag * psi_s == pytest.approx(torque)
    assert abs(i_s) == pytest.approx(found["current_a"])
    assert 1.5 * (u_s * i_s.conjugate()).real == pytest.approx(found["power_w"])


def test_both_are_told_the_same_point() -> None:
    case = Case(125, 50, -60)
    ours, theirs = motulator_cases.sextant_settings(case), motulator_cases.motulator_case(PLANT, case)
    assert ours["drive.period_us"] * 1e-6 == theirs["period_s"]
    assert ours["load.speed_rad_s.value"] == theirs["speed_rad_s"] == 50
    assert ours["profile.torque_nm.points"] == [[0, 0], [theirs["step_s"], theirs["torque_nm"]]]
    assert ours["control.foc.bandwidth_rad_s"] == theirs["bandwidth_rad_s"]
    assert ours["duration_s"] == theirs["end_s"]
    assert ours["drive.actuation_delay_periods"] == 1


@pytest.mark.parametrize("period_us", motulator_cases.PLAN)
def test_steps_and_windows_are_whole_periods(period_us: float) -> None:
    for instant in (motulator_cases.STEP_S, motulator_cases.WINDOW_S, motulator_cases.END_S):
        assert instant * 1e6 / period_us == pytest.approx(round(instant * 1e6 / period_us))
    assert motulator_cases.SHOWN in motulator_cases.PLAN[period_us]


def points(torque, seconds: float = 0.1) -> dict[str, np.ndarray]:
    """As motulator's solver leaves them: a point at each step's begin and end, here four steps a period."""
    t = np.arange(round(4 * seconds / PERIOD_S) + 1) * PERIOD_S / 4
    t = np.sort(np.concatenate([t, t[1:-1]]))
    turn = np.exp(100j * t)
    return {
        "t_s": t,
        "torque_nm": torque(t),
        "psi_s_wb": 1.1 * turn,
        "i_s_a": 20 * turn,
        "u_s_v": 50j * turn + 10 * turn,
    }


def test_a_course_has_one_entry_a_control_period() -> None:
    course = courses.of_points(points(lambda t: 4000 * t), PERIOD_S)
    assert len(course.end_s) == 400
    assert course.end_s[0] == pytest.approx(PERIOD_S)
    assert course.torque_mean_nm[:2] == pytest.approx([0.5, 1.5])
    assert (course.torque_min_nm[1], course.torque_max_nm[1]) == pytest.approx((1, 2))
    assert len(course.within(0.05, 0.1).end_s) == 200
    assert course.within(0.05, 0.1).end_s[0] == pytest.approx(0.05 + PERIOD_S)


def test_steady_figures_of_a_turning_flux() -> None:
    found = courses.steady(courses.of_points(points(lambda t: 15 + 0 * t), PERIOD_S), 96)
    assert found["torque_nm"] == pytest.approx(15)
    assert (found["current_a"], found["flux_wb"]) == pytest.approx((20, 1.1))
    assert (found["stator_rad_s"], found["slip_rad_s"]) == pytest.approx((100, 4))
    assert found["power_w"] == pytest.approx(1.5 * 10 * 20)


def test_the_ripple_of_a_triangle_is_its_own_whatever_the_steps() -> None:
    corners = np.array([0.0, 1.0, 2.0, 3.0, 4.0])
    triangle = np.array([14.0, 16.0, 14.0, 16.0, 14.0])
    assert courses.ripple_rms(corners, triangle) == pytest.approx(1 / math.sqrt(3))
    fine = np.array([0.0, 0.3, 1.0, 1.9, 2.0, 2.0, 3.0, 4.0])
    assert courses.ripple_rms(fine, np.interp(fine, corners, triangle)) == pytest.approx(1 / math.sqrt(3))


@pytest.mark.parametrize("torque", [60, -60])
def test_the_rise_of_a_first_order_step(torque: float) -> None:
    def step(t: np.ndarray) -> np.ndarray:
        return np.where(t > 0.05, torque * (1 - np.exp(-(t - 0.05) / 1e-3)), 0)

    course = courses.of_points(points(step), PERIOD_S)
    assert courses.rise(course, 0.05, torque) == pytest.approx(3.0, abs=0.05)
    assert courses.overshoot(course, 0.05, torque) == pytest.approx(0, abs=1e-6)
    assert courses.rise(course, 0.05, 2 * torque) is None


def test_an_overshoot_is_that_of_the_mean_over_a_switching_period() -> None:
    course = courses.of_points(points(lambda t: np.where(t > 0.05, 63.0, 0.0)), PERIOD_S)
    assert courses.overshoot(course, 0.05, 60) == pytest.approx(5)


def record(**slip: float) -> Record:
    def drive(slip_rad_s: float) -> dict:
        return dict.fromkeys(QUANTITIES, 10.0) | {"slip_rad_s": slip_rad_s}

    return Record(250, 50, -60, drive(-4), drive(slip["sextant"]), drive(slip["motulator"]))


def test_what_differs_by_more_than_the_limit_is_named() -> None:
    near, far = record(sextant=-4.01, motulator=-4), record(sextant=-4.03, motulator=-4)
    assert near.difference("slip_rad_s") == pytest.approx(-0.25)
    assert near.difference("torque_nm") == 0
    results = Results("1", "abc", "0.5.0", {}, [near, far])
    assert results.apart() == [(far, "slip_rad_s")]
    assert results.apart()[0][0].name == "250 µs, 50 rad/s, -60 N·m"


def test_the_committed_page_is_that_of_its_results(tmp_path) -> None:
    (tmp_path / "images").mkdir()
    results = json_file.read(compare_motulator.RESULTS, Results, "compare_motulator")
    motulator_page.write(results, tmp_path)
    committed = (ROOT / "docs/motulator.md").read_text(encoding="utf-8")
    assert (tmp_path / "motulator.md").read_text(encoding="utf-8") == committed
    assert {(r.period_us, r.point) for r in results.records} == {
        (case.period_us, (case.speed_rad_s, case.torque_nm)) for case in motulator_cases.cases(motulator_cases.PLAN)
    }
