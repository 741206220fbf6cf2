"""[expect] and JUnit of sextant-mil also where the drive hears a bus: in virtual time, and of a plant in lockstep."""

import json
import secrets
import signal
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import junitparser
import pytest
from hil_processes import Side
from programs import ProgramProcess, overrides, program
from sextant_py.paths import ROOT

SCENARIO = """
name = "steps"
description = "Torque of 15 N·m against a load, then 10 N·m"
duration_s = 0.4
machine = "{machine}"
[profile.torque_nm]
shape = "steps"
points = [[0, 0], [0.1, 15], [0.3, 10]]
[load.torque_nm]
value = 5
[control]
controller = "foc"
[drive]
period_us = 100
actuation_delay_periods = 1
[plant]
integrator = "fixed"
u_dc_v = 530
[protection]
over_current_a = 250
[metrics]
window_from_s = 0.15
window_to_s = 0.29
step_s = 0.1
[expect]
response_time_ms = {{ max = 20 }}
torque_bias_nm = {{ min = -1, max = 1 }}
flux_mean_wb = {{ min = 0.5, max = 1.5 }}
[[expect.window]]
from_s = 0.35
torque_bias_nm = {{ min = -1, max = 1 }}
"""
# After a trip there is no torque to evaluate.
WIDE = (
    "expect.response_time_ms.max=1000",
    *("expect.torque_bias_nm.min=-100", "expect.torque_bias_nm.max=100", "expect.flux_mean_wb.min=0"),
    "expect.window=[{from_s=0.35, torque_bias_nm={min=-100, max=100}}]",
)
OPEN_PHASE = ("plant.faults.kind=open_phase", "plant.faults.at_s=0.2")


@pytest.fixture
def scenario(tmp_path: Path) -> Path:
    path = tmp_path / "steps.toml"
    path.write_text(SCENARIO.format(machine=ROOT / "configs" / "machines" / "paper_3hp.toml"), encoding="utf-8")
    return path


def run(name: str, *words: object, settings: tuple[str, ...] = ()) -> subprocess.CompletedProcess:
    command = [program(name), *map(str, words), *overrides(settings)]
    return subprocess.run(command, capture_output=True, text=True, timeout=300, stdin=subprocess.DEVNULL)


def virtually(scenario: Path, *words: object, settings: tuple[str, ...] = ()) -> subprocess.CompletedProcess:
    return run("sextant-ecu", "--virtual-time", "--scenario", scenario, *words, settings=settings)


def suite_of(file: Path) -> junitparser.TestSuite:
    (suite,) = junitparser.JUnitXml.fromfile(str(file))
    return suite


def outcomes(suite: junitparser.TestSuite) -> dict[str, str]:
    """What each test case that did not pass is, by its name."""
    return {case.name: type(result).__name__ for case in suite for result in case.result}


def metrics(folder: Path) -> dict[str, float]:
    return json.loads((folder / "summary.json").read_text(encoding="utf-8"))["metrics"]


def test_a_scenario_passes_over_the_bus_and_its_verdict_is_that_of_sextant_mil(scenario: Path, tmp_path: Path) -> None:
    """The bus costs one control period and the resolution of its torque; the metrics differ by that alone."""
    file, out = tmp_path / "junit.xml", tmp_path / "virtual"
    done = virtually(scenario, "--junit", file, "--out", out)
    assert done.returncode == 0, done.stderr
    offline = run("sextant-mil", scenario, "--junit", tmp_path / "mil.xml", "--out", tmp_path / "mil")
    assert offline.returncode == 0, offline.stderr
    suite, of_mil = suite_of(file), suite_of(tmp_path / "mil.xml")
    assert outcomes(suite) == outcomes(of_mil) == {}
    assert [case.name for case in suite] == [case.name for case in of_mil]
    assert (out / "trace.h5").is_file()
    found, expected = metrics(out), metrics(tmp_path / "mil")
    period_ms, resolution_nm = 0.1, 0.1
    assert found["simulated_s"] == pytest.approx(expected["simulated_s"], abs=1e-9)
    assert found["response_time_ms"] == pytest.approx(expected["response_time_ms"], abs=2 * period_ms)
    assert found["torque_bias_nm"] == pytest.approx(expected["torque_bias_nm"], abs=resolution_nm)
    assert found["flux_mean_wb"] == pytest.approx(expected["flux_mean_wb"], rel=2e-3)
    assert found["peak_current_a"] == pytest.approx(expected["peak_current_a"], rel=0.02)
    # 0.14 s at 15 N·m against 5: 10 N·m on the shaft; its speed is what it was but for a period's torque.
    assert found["energy_shaft_j"] == pytest.approx(expected["energy_shaft_j"], rel=0.01)
    assert found["energy_unaccounted"] < 1e-4


def test_a_limit_that_does_not_hold_fails_in_the_report_and_by_the_status(scenario: Path, tmp_path: Path) -> None:
    file = tmp_path / "junit.xml"
    done = virtually(scenario, "--junit", file, settings=("expect.peak_current_a.max=1",))
    assert done.returncode == 1
    assert outcomes(suite_of(file)) == {"verdict": "Failure", "peak_current_a ≤ 1": "Failure"}


def test_an_expected_fault_passes_and_one_that_is_not_expected_trips(scenario: Path, tmp_path: Path) -> None:
    file = tmp_path / "junit.xml"
    expected = ("expect.fault=OPEN_PHASE", "expect.fault_from_s=0.2", "expect.fault_to_s=0.3")
    done = virtually(scenario, "--junit", file, settings=(*OPEN_PHASE, *expected, *WIDE))
    assert done.returncode == 0, done.stdout + done.stderr
    assert "fault OPEN_PHASE, 0.2 s to 0.3 s" in [case.name for case in suite_of(file)]
    done = virtually(scenario, "--junit", file, settings=(*OPEN_PHASE, *WIDE))
    assert done.returncode == 3
    assert outcomes(suite_of(file))["verdict"] == "Error"


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        (("expect.no_such_metric.max=1",), "no_such_metric"),
        (("mode=event_exact", "control.controller=dtc"), "event"),
        (("metrics.step_s=0.2",), "metrics.step_s must be"),
        (("profile.torque_nm.points=[[0, 0], [0.1, 300]]", "command.torque_limit_nm=400"), "the contract's range"),
    ],
)
def test_a_wrong_configuration_is_an_error_of_the_report(
    scenario: Path, tmp_path: Path, settings: tuple[str, ...], said: str
) -> None:
    file = tmp_path / "junit.xml"
    file.write_text("<testsuites><testsuite/></testsuites>", encoding="utf-8")
    done = virtually(scenario, "--junit", file, settings=settings)
    assert done.returncode == 2
    assert said in done.stderr
    suite = suite_of(file)
    assert (suite.name, outcomes(suite)) == ("steps", {"verdict": "Error"})


@pytest.mark.parametrize(
    ("name", "words", "said"),
    [
        ("sextant-ecu", ("--virtual-time", "--can", "socketcan:vcan0"), "--scenario excludes --can"),
        ("sextant-ecu", ("--virtual-time", "--duration", "1"), "--scenario excludes --duration"),
        ("sextant-ecu", (), "--scenario requires --virtual-time"),
        ("sextant-plant", ("--duration", "1"), "--duration excludes --scenario"),
    ],
)
def test_a_refused_command_line_leaves_no_earlier_report(
    scenario: Path, tmp_path: Path, name: str, words: tuple[str, ...], said: str
) -> None:
    file = tmp_path / "junit.xml"
    file.write_text("<testsuites><testsuite/></testsuites>", encoding="utf-8")
    done = run(name, "--scenario", scenario, "--junit", file, *words)
    assert done.returncode == 2
    assert said in done.stderr
    suite = suite_of(file)
    assert (suite.name, outcomes(suite)) == ("steps", {"verdict": "Error"})


def test_a_configuration_file_gives_the_drive_and_the_scenario_the_rest(scenario: Path, tmp_path: Path) -> None:
    """15 N·m on 0.5 kg·m² of configs/ecu.toml, not on the inertia of the bare machine."""
    done = run(
        *("sextant-ecu", ROOT / "configs" / "ecu_foc.toml", "--virtual-time", "--scenario", scenario),
        *("--out", tmp_path, "--no-trace"),
    )
    assert done.returncode == 0, done.stdout + done.stderr
    summary = json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))
    assert summary["configuration"]["machine.inertia_kg_m2"] == 0.5
    # From 0.15 s to 0.29 s at 10 N·m above the load: 0.29 s² − 0.05² … of ω = 20 rad/s² (t − 0.1 s) − 5/0.5 · 0.1.
    speed = [-1 + 20 * (t - 0.1) for t in (0.15, 0.29)]
    work = 15 * 0.14 * sum(speed) / 2
    assert summary["metrics"]["energy_shaft_j"] == pytest.approx(work, rel=0.03, abs=0.05)


def test_a_plant_in_lockstep_evaluates_what_its_drive_plays(scenario: Path, tmp_path: Path) -> None:
    link = f"sextant_test_{secrets.token_hex(4)}"
    shared = (f"hil.link={link}", "hil.pacing=lockstep", "hil.lockstep_timeout_ms=60000")
    file, out = tmp_path / "junit.xml", tmp_path / "out"
    with Side("sextant-plant", ROOT / "configs" / "plant.toml", tmp_path, shared, "--scenario", scenario,
              "--junit", file, "--out", out) as plant:  # fmt: skip
        plant.wait_for("in lockstep")
        done = run(
            *("sextant-ecu", ROOT / "configs" / "ecu_hil.toml", "--virtual-time", "--scenario", scenario),
            settings=shared,
        )
        assert done.returncode == 0, done.stderr
        assert plant.status(60) == 0, plant.text()
    assert outcomes(suite_of(file)) == {}
    found = metrics(out)
    assert found["torque_bias_nm"] == pytest.approx(0, abs=0.5)
    assert found["torque_silent_ms"] == 0
    assert found["energy_unaccounted"] < 1e-4


def test_a_plant_says_that_its_drive_plays_no_scenario(scenario: Path, tmp_path: Path) -> None:
    link = f"sextant_test_{secrets.token_hex(4)}"
    shared = (f"hil.link={link}", "hil.pacing=lockstep", "hil.lockstep_timeout_ms=60000")
    file = tmp_path / "junit.xml"
    with Side("sextant-plant", ROOT / "configs" / "plant.toml", tmp_path, shared, "--scenario", scenario,
              "--junit", file) as plant:  # fmt: skip
        plant.wait_for("in lockstep")
        done = run("sextant-ecu", ROOT / "configs" / "ecu_hil.toml", "--virtual-time", "--duration", "0.1",
                   settings=shared)  # fmt: skip
        assert done.returncode == 0, done.stderr
        assert plant.status(60) == 2
        assert "has played no scenario: start sextant-ecu --virtual-time --scenario" in plant.text()
    assert outcomes(suite_of(file)) == {"verdict": "Error"}


@contextmanager
def observing_plant(scenario: Path, folder: Path, *words: object) -> Iterator[tuple[Side, tuple[str, ...]]]:
    """A plant in lockstep that evaluates the scenario into junit.xml, and what its drive is set to."""
    shared = (f"hil.link=sextant_test_{secrets.token_hex(4)}", "hil.pacing=lockstep", "hil.lockstep_timeout_ms=60000")
    options = ("--scenario", scenario, "--junit", folder / "junit.xml", *map(str, words))
    with Side("sextant-plant", ROOT / "configs" / "plant.toml", folder, shared, *options) as plant:
        plant.wait_for("in lockstep")
        yield plant, shared


def drive_command(scenario: Path, settings: tuple[str, ...]) -> tuple[object, ...]:
    return (ROOT / "configs" / "ecu_hil.toml", "--virtual-time", "--scenario", scenario, *overrides(settings))


def test_a_plant_refuses_a_drive_that_plays_another_scenario(scenario: Path, tmp_path: Path) -> None:
    other = tmp_path / "other.toml"
    other.write_text(scenario.read_text(encoding="utf-8").replace("[0.1, 15]", "[0.1, 14]"), encoding="utf-8")
    with observing_plant(scenario, tmp_path) as (plant, shared):
        done = run("sextant-ecu", *drive_command(other, shared))
        assert plant.status(60) == 2
        assert "plays another scenario, by its torque or length" in plant.text()
    assert done.returncode == 1, "its plant has left it"
    assert outcomes(suite_of(tmp_path / "junit.xml")) == {"verdict": "Error"}


def test_a_plant_whose_drive_is_killed_has_failed(scenario: Path, tmp_path: Path) -> None:
    long = tmp_path / "long.toml"
    long.write_text(scenario.read_text(encoding="utf-8").replace("duration_s = 0.4", "duration_s = 1000"), "utf-8")
    with observing_plant(long, tmp_path) as (plant, shared), ProgramProcess(
        [program("sextant-ecu"), *drive_command(long, shared)], tmp_path / "ecu.txt"
    ) as drive:  # fmt: skip
        plant.wait_for("has joined")
        drive.send_signal(signal.SIGKILL)
        assert plant.status(60) == 1
        assert "ended or timed out" in plant.text()
    assert outcomes(suite_of(tmp_path / "junit.xml")) == {"verdict": "Error"}


def test_a_plant_that_is_ended_before_its_drive_joins_is_interrupted(scenario: Path, tmp_path: Path) -> None:
    with observing_plant(scenario, tmp_path) as (plant, _):
        assert plant.leave() == 143
        assert "has played no scenario" not in plant.text()
    (case,) = [case for case in suite_of(tmp_path / "junit.xml") if case.name == "verdict"]
    assert [result.message for result in case.result] == ["interrupted at 0.000000 s"]


def test_a_plant_does_not_wait_for_ever_for_its_drive(scenario: Path, tmp_path: Path) -> None:
    with observing_plant(scenario, tmp_path, "--join-within", 0.2) as (plant, _):
        assert plant.status(60) == 1
        assert "no drive has joined within 0.2 s: start sextant-ecu" in plant.text()
    assert outcomes(suite_of(tmp_path / "junit.xml")) == {"verdict": "Error"}


def test_reports_of_a_plant_elsewhere_are_its_own(scenario: Path, tmp_path: Path) -> None:
    file = tmp_path / "junit.xml"
    file.write_text("<testsuites><testsuite/></testsuites>", encoding="utf-8")
    done = run("sextant-ecu", *drive_command(scenario, ("hil.pacing=lockstep",)), "--junit", file)
    assert done.returncode == 2
    assert "sextant-plant --scenario" in done.stderr
    assert outcomes(suite_of(file)) == {"verdict": "Error"}


def test_a_recording_and_a_scenario_are_an_error_of_the_report(scenario: Path, tmp_path: Path) -> None:
    file = tmp_path / "junit.xml"
    file.write_text("<testsuites><testsuite/></testsuites>", encoding="utf-8")
    done = run("sextant-ecu", "--virtual-time", tmp_path / "run.log", "--scenario", scenario, "--junit", file)
    assert done.returncode == 2
    assert "not from both" in done.stderr
    assert outcomes(suite_of(file)) == {"verdict": "Error"}


@pytest.mark.parametrize("words", [("--can", "socketcan:vcan0"), ("--log-interface", "can0")])
def test_options_without_a_meaning_for_a_scenario_are_refused(scenario: Path, words: tuple[str, str]) -> None:
    done = virtually(scenario, *words)
    assert done.returncode == 2
    assert words[0] in done.stderr and "--scenario" in done.stderr
