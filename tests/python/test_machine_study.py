"""The study over the library of machines: its points, what its records mean, its page, and a few of its runs."""

import math
from dataclasses import replace
from pathlib import Path

import pytest
from programs import program
from sextant_py.control_methods import METHODS
from sextant_py.errors import UserError
from studies import json_file, plant_faults
from studies.machine_library import faults as machine_library_faults
from studies.machine_library import machine_library
from studies.machine_library import page as machine_library_page
from studies.machine_library import scenarios as machine_library_scenarios
from studies.machine_library.points import (
    PERIODS_US,
    Cell,
    Point,
    cells,
    command_of,
    points,
    quick_points,
    read_library,
)
from studies.machine_library.results import DERATED, REFUSED, RIGHT, TRIPPED, WRONG, Results, outcome
from studies.machine_library.run import Lab

LIBRARY = read_library()
MACHINE = next(machine for machine in LIBRARY if machine.id == "motulator_2k2")
POINT = Point(Cell(MACHINE.id, 100, "foc", "ideal"), 0.5, 1.0)
SCENARIOS = machine_library_scenarios.NAMES
W = 100 * math.pi
CONFIGURATION = {
    "machine.r_s_ohm": 3.7, "machine.r_r_ohm": 2.297, "machine.x_m_ohm": W * 0.2343, "machine.x_ls_ohm": W * 0.0107,
    "machine.x_lr_ohm": W * 0.0107, "machine.reactance_frequency_hz": 50, "machine.poles": 4,
    "capability.voltage_use": 1.0, "capability.torque_nm": 29.2, "plant.u_dc_v": 566,
    "control.flux_reference_wb": 1.04, "drive.current_limit_a": 60.0, "command.torque_limit_nm": 29.2,
}  # fmt: skip
RECORD = {
    "key": POINT.key, "refusal": "", "faults": [], "command_nm": 14.6, "torque_bias_nm": 0.0,
    "torque_motoring_nm": 20.0, "torque_regenerating_nm": 21.0, "torque_silent_ms": 0.0, "verdict": "nothing_expected",
}  # fmt: skip


def kind_of(point: Point = POINT, **changed: object) -> str:
    return outcome(RECORD | changed, point, MACHINE, CONFIGURATION).kind


def test_points_are_those_of_the_seed_and_of_both_signs() -> None:
    every = cells(LIBRARY, METHODS, PERIODS_US)
    found = points(every, seed=1)
    assert len(found) == len(every) * 3 == len(LIBRARY) * 7 * 5 * 2 * 3
    assert found == points(every, seed=1) != points(every, seed=2)
    assert points(every[7:9], seed=1) == found[21:27]  # whatever else is measured
    for n in range(0, len(found), 3):
        signs = {point.torque > 0 for point in found[n : n + 3]}
        speeds = {abs(point.speed) for point in found[n : n + 3]}
        assert signs == {True, False} and len(speeds) == 3
    assert {abs(point.speed) for point in found} >= {0.0, 1.0, 2.0}
    assert any(point.speed < 0 for point in found) and any(point.speed > 0 for point in found)


def test_quick_points_are_of_every_machine() -> None:
    every = points(cells(LIBRARY, METHODS, PERIODS_US), seed=1)
    few = quick_points(every, seed=1)
    assert 60 <= len(few) <= 100
    assert {point.cell.machine for point in few} == {machine.id for machine in LIBRARY}
    assert {point.cell.method for point in few} == set(METHODS)


def test_torque_stays_within_the_limit_of_the_drive() -> None:
    assert command_of(POINT, MACHINE, CONFIGURATION) == pytest.approx(14.6)
    assert command_of(replace(POINT, torque=-0.5), MACHINE, CONFIGURATION) == pytest.approx(-7.3)
    low = CONFIGURATION | {"command.torque_limit_nm": 10.0}
    assert command_of(POINT, MACHINE, low) == pytest.approx(9.8)
    assert command_of(replace(POINT, torque=-1.5), MACHINE, low) == pytest.approx(-9.8)


def test_outcome_of_a_point() -> None:
    assert kind_of() == RIGHT
    assert kind_of(torque_bias_nm=0.43) == RIGHT  # 2.9 % of 14.6 N·m
    assert kind_of(torque_bias_nm=-0.45) == WRONG  # 3.1 %
    assert kind_of(torque_bias_nm=-14.6) == WRONG
    assert kind_of(torque_motoring_nm=None, torque_regenerating_nm=None, torque_bias_nm=-14.6) == WRONG
    assert kind_of(faults=[["OPEN_PHASE", 0.5]], torque_bias_nm=-14.6) == TRIPPED
    assert kind_of(refusal="the encoder is too coarse") == REFUSED
    assert kind_of(torque_motoring_nm=10.0, torque_bias_nm=-4.6) == DERATED
    assert kind_of(torque_motoring_nm=10.0) == WRONG  # more than it publishes
    # Against the direction of speed the other torque counts.
    assert kind_of(replace(POINT, speed=-0.5), torque_motoring_nm=10.0) == RIGHT
    assert kind_of(replace(POINT, speed=-0.5), torque_regenerating_nm=10.0, torque_bias_nm=-4.6) == DERATED
    brake = replace(POINT, torque=-1.0)
    assert kind_of(brake, command_nm=-14.6, torque_regenerating_nm=10.0, torque_bias_nm=4.6) == DERATED


def test_derating_that_the_circuit_does_not_ask_for_is_told_apart() -> None:
    held_back = outcome(RECORD | {"torque_motoring_nm": 8.0, "torque_bias_nm": -6.6}, POINT, MACHINE, CONFIGURATION)
    assert held_back.kind == DERATED and held_back.is_needless
    fast = replace(POINT, speed=2.0, torque=1.5)
    # At twice base speed the flux is half, and the torque that the voltage allows about a quarter of its breakdown.
    weak = CONFIGURATION | {"plant.u_dc_v": 250}
    record = RECORD | {"command_nm": 21.9, "torque_motoring_nm": 5.0, "torque_bias_nm": -16.9}
    needed = outcome(record, fast, MACHINE, weak)
    assert needed.kind == DERATED and not needed.is_needless


def results_of(outcomes: list, faults: list[dict]) -> Results:
    rows = [{"id": m.id, "name": m.name, "power_w": m.power_w, "voltage": m.voltage, "poles": m.poles} for m in LIBRARY]
    return Results("0.1.0", "0123456789ab", 1, "scripts/machine_library", rows, outcomes, faults)


def test_page_counts_what_the_records_say(tmp_path: Path) -> None:
    good = outcome(RECORD, POINT, MACHINE, CONFIGURATION)
    bad = outcome(RECORD | {"faults": [["CURRENT_SENSOR", 0.1]]}, POINT, MACHINE, CONFIGURATION)
    refused = outcome(RECORD | {"refusal": "foo.toml: too slow for it"}, POINT, MACHINE, CONFIGURATION)
    fault = {"fault": "open phase", "method": "foc", "machine": MACHINE.id, "period_us": 100, "speed": 0.5}
    fault |= {"torque": 1.0, "kind": plant_faults.NAMED, "seen": "OPEN_PHASE", "late_ms": 3.25}
    results = results_of([good, bad, bad, refused], [fault])
    reversal, start, _ = (machine_library_scenarios.cases(n, [MACHINE.id], ["foc"], [50])[5] for n in SCENARIOS)
    late = RECORD | {"torque_silent_ms": 47.0}
    results.scenarios = [machine_library_scenarios.judge(*pair) for pair in ((RECORD, reversal), (late, start))]
    file = tmp_path / "machine_library.json"
    json_file.write(file, results)
    kept = json_file.read(file, Results, "machine_library")
    assert kept == results
    written = machine_library_page.write(kept, tmp_path)
    assert [path.name for path in written] == ["machine_library.png", "machine_library.md"]
    page = written[1].read_text(encoding="utf-8")
    assert "**2 of 4 healthy points are not right**, 2 of them trip. By cause: CURRENT_SENSOR 2." in page
    assert "- 1: foo.toml: too slow for it" in page
    for row in ("points | 1 | 0 | 0 | 1 | 2", "reversals | 1 | 0 | – | 0 | 0", "starts | 0 | 0 | – | 0 | 1"):
        assert f"| {row} |" in page
    assert (
        f"| starts | {MACHINE.id} | `foc` | 50 | {start.title} | wrong: 47 ms another torque than is published |"
        in page
    )
    shown = machine_library_page.text(results)
    assert "| `foc` | – | – | 2 of 4 | – | – |" in shown
    assert "| open phase | `foc` | 1 | 1 | 0 | 0 | 0 | 3.25 | OPEN_PHASE 1 |" in shown
    assert "{" not in page


def test_reversals_are_of_every_machine_method_and_speed_in_both_directions() -> None:
    every = machine_library_scenarios.cases("reversals", [m.id for m in LIBRARY], METHODS, (50,))
    assert len(every) == len(set(every)) == len(LIBRARY) * 7 * 16
    speeds = {case.point.speed for case in every}
    assert max(speeds) == 2 and {-speed for speed in speeds} == speeds and len(speeds) == 16
    settings = every[0].settings(MACHINE, CONFIGURATION)
    torques = [torque for _, torque in settings["profile.torque_nm.points"]]
    full = 0.98 * CONFIGURATION["command.torque_limit_nm"]
    assert torques == pytest.approx([0, full, -full, full])


def test_starts_pass_through_standstill_in_both_directions() -> None:
    every = machine_library_scenarios.cases("starts", [MACHINE.id], METHODS, (50, 125))
    assert len(every) == len(set(every)) >= 7 * 2 * 9 and len(every) * len(LIBRARY) >= 264
    directions = set()
    for case in every:
        settings = case.settings(MACHINE, CONFIGURATION)
        (from_s, first), (to_s, second), (end_s, last) = settings["load.speed_rad_s.points"]
        assert first == -second == -last != 0
        assert from_s < (from_s + to_s) / 2 == pytest.approx(case.instant_s)  # of standstill
        assert to_s < end_s == settings["duration_s"]
        ((at_s, torque),) = settings["profile.torque_nm.points"]
        assert at_s == 0
        directions.add((first > 0, torque > 0))
    assert len(directions) == 4


def test_the_link_sags_under_torque_with_and_against_the_rotation() -> None:
    every = machine_library_scenarios.cases("sags", [MACHINE.id], METHODS, (50,))
    assert len(every) == len(set(every)) == 7 * 10
    for speed in {case.point.speed for case in every}:
        assert {case.point.torque > 0 for case in every if case.point.speed == speed} == {True, False}
    settings = every[0].settings(MACHINE, CONFIGURATION)
    assert settings["plant.faults.sag_v"] == pytest.approx(0.7 * MACHINE.u_dc)
    assert settings["metrics.window_from_s"] < settings["plant.faults.at_s"] < settings["duration_s"] - 0.2


def test_what_a_scenario_shows() -> None:
    for name in SCENARIOS:
        case = machine_library_scenarios.cases(name, [MACHINE.id], ["foc"], [50])[0]

        def kind(case: machine_library_scenarios.Case = case, **changed: object) -> str:
            return machine_library_scenarios.judge(RECORD | changed, case)["kind"]

        assert kind() == RIGHT
        assert kind(torque_silent_ms=9.9) == RIGHT and kind(torque_silent_ms=10.1) == WRONG
        assert kind(torque_silent_ms=None) == WRONG and kind(verdict="no_torque") == WRONG
        assert kind(faults=[["FLUX_LOST", 0.5]]) == TRIPPED and kind(refusal="too slow") == REFUSED
        assert kind(torque_regenerating_nm=14.0) == DERATED and kind(torque_motoring_nm=14.0) == DERATED
        assert kind(torque_regenerating_nm=14.0, torque_silent_ms=11.0) == WRONG


def test_results_of_something_else_are_refused(tmp_path: Path) -> None:
    file = tmp_path / "other.json"
    file.write_text("{}", encoding="utf-8")
    with pytest.raises(UserError, match="holds no results of scripts/machine_library"):
        json_file.read(file, Results, "machine_library")


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--machines", "steam"], '--machines: there is no "steam"'),
        (["--methods", "foo"], '--methods: there is no "foo"'),
        (["--periods", "60"], '--periods: there is no "60"'),
        (["--parts", "wings"], '--parts: there is no "wings"'),
    ],
)
def test_unknown_names_are_refused(arguments: list[str], sentence: str) -> None:
    with pytest.raises(UserError, match=sentence):
        machine_library.main(arguments)


def test_runs_of_sextant_mil(tmp_path: Path) -> None:
    lab = Lab(program("sextant-mil"), [MACHINE], tmp_path)
    plan = [POINT, replace(POINT, torque=-0.5), replace(POINT, cell=replace(POINT.cell, method="none"))]
    lab.configure(plan, 2)
    records = lab.run([(point, {}) for point in plan], 2)
    found = [
        outcome(record, point, MACHINE, lab.configuration(point)) for record, point in zip(records, plan, strict=True)
    ]
    assert [one.kind for one in found] == [RIGHT, RIGHT, REFUSED]
    assert "control.controller" in found[2].why


def test_a_lost_encoder_is_told_by_its_name(tmp_path: Path) -> None:
    lab = Lab(program("sextant-mil"), [MACHINE], tmp_path)
    chosen = [
        case for case in machine_library_faults.cases([MACHINE.id], ["foc"], True) if case[0].name == "encoder at zero"
    ]
    (found,) = machine_library_faults.measure(lab, chosen, 1, lambda: None)
    assert (found["kind"], found["seen"]) == (plant_faults.NAMED, "SPEED_SENSOR")
    assert found["late_ms"] < 10


def test_exchanged_cables_are_found_when_the_shaft_leaves_standstill(tmp_path: Path) -> None:
    lab = Lab(program("sextant-mil"), [MACHINE], tmp_path)
    cables = next(fault for fault in plant_faults.FAULTS if fault.kind == "cables_swapped")
    (found,) = machine_library_faults.measure(lab, [(cables, replace(POINT, speed=0.0))], 1, lambda: None)
    assert found["kind"] in (plant_faults.NAMED, plant_faults.OTHERWISE)
    assert 0 < found["late_ms"] < 600  # since the speed rises


def test_scenarios_of_sextant_mil(tmp_path: Path) -> None:
    lab = Lab(program("sextant-mil"), [MACHINE], tmp_path)
    chosen = [machine_library_scenarios.cases(name, [MACHINE.id], ["foc"], [100])[1] for name in SCENARIOS]
    missing = machine_library_scenarios.cases("starts", [MACHINE.id], ["none"], [100])[0]
    found = machine_library_scenarios.measure(lab, [*chosen, missing], 2, lambda: None)
    assert [row["kind"] for row in found] == [RIGHT, RIGHT, RIGHT, REFUSED], found
    assert [row["scenario"] for row in found] == [*SCENARIOS, "starts"]


@pytest.mark.parametrize(
    "words",
    [
        [],
        ["--quick"],
        ["--seed", "3"],
        ["--parts", "reversals,starts"],
        ["--machines", "krause_3hp", "--methods", "foc", "--periods", "25,50"],
    ],
)
def test_the_results_name_the_command_that_makes_them(words: list[str]) -> None:
    options = machine_library.parse_arguments([*words, "--jobs", "1"])
    assert machine_library.command_of(options).split() == ["scripts/machine_library", *words]
    assert options.is_of_page == (words == [] or words[0] == "--seed")
