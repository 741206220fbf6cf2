"""sextant-mil as its user starts it: exit status, summary and trace."""

import json
import math
import os
import re
import resource
import signal
import subprocess
import time
from pathlib import Path

import h5py
import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
SCENARIOS = ROOT / "configs" / "scenarios"


def run(*arguments) -> subprocess.CompletedProcess:
    command = [os.environ["SEXTANT_MIL"], *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=60, cwd="/")


def members(topic: str) -> set[str]:
    contract = json.loads((ROOT / "configs" / "interfaces" / "telemetry.json").read_text(encoding="utf-8"))
    return {signal["name"] for signal in contract["topics"][topic]}


@pytest.mark.parametrize("name", ["constant_torque", "reversal"])
@pytest.mark.parametrize(
    "integrator",
    [[], ["--integrator", "fixed"], ["--integrator", "exact"], ["--integrator", "erk"]],
    ids=["cvode, by default", "fixed", "exact", "erk"],
)
def test_shipped_scenario_passes(integrator, name, tmp_path):
    done = run(SCENARIOS / f"{name}.toml", *integrator, "--out", tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["scenario"] == name
    assert summary["expect"] and all(expectation["pass"] for expectation in summary["expect"])
    assert summary["metrics"]["simulated_s"] > 1
    assert "torque_bias_nm" in done.stdout

    with h5py.File(tmp_path / "trace.h5") as trace:
        drive = {key for key in trace if isinstance(trace[key], h5py.Dataset)}
        # A trace has one drive, and no channel between that could lose samples.
        of_the_channel = {"drive_id", "sequence", "dropped"}
        assert members("DriveTelemetry") - of_the_channel <= drive
        assert all("unit" in trace[key].attrs for key in drive)
        rows = len(trace["t_ns"])
        assert rows > 1000 and all(len(trace[key]) == rows for key in drive)
        assert trace["plant/torque_nm"].attrs["unit"].decode() == "N·m"


def test_a_program_of_another_name_calls_itself_by_it(tmp_path):
    program = tmp_path / "own-mil"
    program.symlink_to(os.environ["SEXTANT_MIL"])

    def words(*arguments) -> str:
        done = subprocess.run([program, *arguments], capture_output=True, text=True, timeout=60, cwd=tmp_path)
        return done.stdout.replace(str(program), "") + done.stderr

    assert "\n  own-mil configs/scenarios/" in words("--help") and "sextant-mil" not in words("--help")
    assert words("nowhere.toml").startswith("own-mil: ")
    assert words("--nonsense").startswith("own-mil: ")
    scenario = tmp_path / "short.toml"
    text = (SCENARIOS / "constant_torque.toml").read_text().replace("../", f"{ROOT}/configs/")
    scenario.write_text(text)
    command = (scenario, "--integrator", "fixed", "--set", "protection.over_current_a=50")
    assert "own-mil: constant_torque: the drive tripped" in words(*command)
    assert "own-mil: out: replaces the result" in words(*command)


def test_cvode_is_the_default():
    done = run(SCENARIOS / "constant_torque.toml", "--print-config")
    assert 'integrator = "cvode"' in done.stdout


def test_results_do_not_overwrite_each_other(tmp_path):
    again = tmp_path / "again.toml"
    text = (SCENARIOS / "reversal.toml").read_text()
    again.write_text(text.replace("../machines", str(ROOT / "configs" / "machines")))
    done = run(SCENARIOS / "reversal.toml", again, "--out", tmp_path / "out")
    assert done.returncode == 2
    assert "is taken by" in done.stderr and str(again) in done.stderr
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("name", ["../elsewhere", "..", "/elsewhere"])
def test_results_stay_in_the_directory_that_was_named(name, tmp_path):
    done = run(SCENARIOS / "reversal.toml", "--out", tmp_path / "out", "--set", f'name="{name}"')
    assert done.returncode == 2
    assert "cannot be that of a directory" in done.stderr
    assert not (tmp_path / "out").exists()


def short_reversal(out: Path, setting: str) -> subprocess.CompletedProcess:
    quick = ("--integrator", "fixed", "--no-trace", "--set", "duration_s=0.5")
    return run(SCENARIOS / "reversal.toml", "--out", out, *quick, "--set", setting)


def test_failed_expectation_fails_the_run(tmp_path):
    done = short_reversal(tmp_path, "expect.peak_current_a={max=1}")
    assert done.returncode == 1, done.stdout + done.stderr
    expect = json.loads((tmp_path / "summary.json").read_text())["expect"]
    failed = [expectation for expectation in expect if not expectation["pass"]]
    assert [expectation["metric"] for expectation in failed] == ["peak_current_a"]
    assert failed[0]["limit"] == {"max": 1.0} and failed[0]["value"] > 1
    assert not (tmp_path / "trace.h5").exists()


def test_trip_fails_the_run_and_is_named(tmp_path):
    done = short_reversal(tmp_path, "protection.over_current_a=50")
    assert done.returncode == 3
    assert "OVER_CURRENT" in done.stderr


def summary_of(out: Path) -> dict:
    return json.loads((out / "summary.json").read_text())


@pytest.mark.parametrize("period_us", [25, 50, 100, 200])
@pytest.mark.parametrize("integrator", ["cvode", "fixed", "exact", "erk"])
def test_energies_of_a_sampled_run_balance(integrator, period_us, tmp_path):
    """The plant's own meter counts them, however long the control period is."""
    settings = (f"drive.period_us={period_us}", "duration_s=1", "plant.fixed.max_step_us=25")
    words = [word for setting in settings for word in ("--set", setting)]
    run(SCENARIOS / "constant_torque.toml", "--integrator", integrator, "--no-trace", *words, "--out", tmp_path)
    m = summary_of(tmp_path)["metrics"]
    net = m["energy_from_link_j"] - m["energy_to_link_j"]
    left = net - m["energy_shaft_j"] - m["energy_copper_j"] - m["energy_field_j"]
    assert abs(left) < 1e-4 * m["energy_from_link_j"]
    assert m["energy_unaccounted"] < 1e-4
    # The losses are those of the currents, which hardly depend on the period.
    assert m["energy_copper_j"] > 20


def test_temperatures_are_in_trace_and_summary(tmp_path):
    """The winding starts warm, and heats from there by what its copper loses."""
    nodes = {"winding": 60, "rotor": 80, "housing": 300}
    thermal = [f"plant.thermal.{node}_j_per_k={c}" for node, c in nodes.items()]
    thermal += [f"plant.thermal.{node}_to_ambient_w_per_k=0.01" for node in nodes] + ["plant.thermal.winding_c=75"]
    settings = ("duration_s=1", 'trace.signals=["thermal"]', *thermal)
    words = [word for setting in settings for word in ("--set", setting)]
    run(SCENARIOS / "constant_torque.toml", *words, "--out", tmp_path)
    m = summary_of(tmp_path)["metrics"]
    with h5py.File(tmp_path / "trace.h5") as file:
        courses = {node: file[f"plant/{node}_temperature_c"][()] for node in nodes}
        assert file["plant/winding_temperature_c"].attrs["unit"].decode() == "°C"
    assert courses["winding"][0] == pytest.approx(75, abs=0.01)
    assert courses["rotor"][0] == pytest.approx(20, abs=0.01)
    for node, course in courses.items():
        assert course[-1] == m[f"{node}_temperature_c"] == max(course)
        assert course[-1] >= course[0]
    assert courses["winding"][-1] > 75.5
    run(SCENARIOS / "constant_torque.toml", "--set", "duration_s=1", "--no-trace", "--out", tmp_path / "cold")
    assert summary_of(tmp_path / "cold")["metrics"]["winding_temperature_c"] is None


def test_both_modes_count_energies_alike(tmp_path):
    scenario = SCENARIOS / "paper" / "3_1_constant_torque.toml"
    for mode, settings in (("sampled", ("drive.period_us=5",)), ("event_exact", ())):
        words = [word for s in (f"mode={mode}", "duration_s=0.5", *settings) for word in ("--set", s)]
        run(scenario, "--integrator", "fixed", "--no-trace", *words, "--out", tmp_path / mode)
    sampled, exact = (summary_of(tmp_path / mode)["metrics"] for mode in ("sampled", "event_exact"))
    assert exact["energy_unaccounted"] < 1e-4
    for name in ("energy_from_link_j", "energy_to_link_j", "energy_copper_j"):
        assert sampled[name] == pytest.approx(exact[name], rel=0.15), name


def test_a_run_that_does_not_balance_says_so(tmp_path):
    """Tolerances far too loose for the machine: its figures do not count."""
    loose = ("relative_tolerance", "flux_tolerance_wb", "appended_tolerance")
    words = [word for name in loose for word in ("--set", f"plant.cvode.{name}=0.1")]
    few = ("--no-trace", "--set", "duration_s=0.5", "--set", "protection.over_current_a=1e4")
    done = run(SCENARIOS / "constant_torque.toml", *few, *words, "--out", tmp_path)
    assert done.returncode == 7
    assert summary_of(tmp_path)["verdict"] == "not_balanced", done.stdout
    assert "not balanced" in done.stdout and "unaccounted for" in done.stderr


def test_pulses_of_the_comparator_are_those_of_the_trace(tmp_path):
    settings = ("duration_s=0.5", "metrics.window_from_s=0.1", "trace.interval_us=25", 'trace.signals=["comparators"]')
    words = [word for s in settings for word in ("--set", s)]
    run(SCENARIOS / "constant_torque.toml", "--integrator", "fixed", *words, "--out", tmp_path)
    with h5py.File(tmp_path / "trace.h5") as trace:
        output, t = trace["control/torque_comparator"][...], trace["t_ns"][...]
    begins = (output[1:] != 0) & (output[1:] != output[:-1]) & (t[1:] > 100_000_000) & (t[1:] <= 500_000_000)
    counted = summary_of(tmp_path)["metrics"]["torque_pulse_frequency_hz"]
    assert counted == pytest.approx(begins.sum() / 0.4, rel=1e-6)
    assert counted > 6000


def test_thd_is_given_only_where_the_torque_stands_still(tmp_path):
    quick = ("--integrator", "fixed", "--no-trace")
    run(SCENARIOS / "constant_torque.toml", *quick, "--out", tmp_path / "steady")
    assert 1 < summary_of(tmp_path / "steady")["metrics"]["current_thd_percent"] < 20
    done = run(SCENARIOS / "reversal.toml", *quick, "--out", tmp_path / "moving")
    assert summary_of(tmp_path / "moving")["metrics"]["current_thd_percent"] is None
    assert re.search(r"current_thd_percent +- %", done.stdout)


def test_a_trip_without_expectations_is_no_pass(tmp_path):
    done = short_reversal(tmp_path, "protection.over_current_a=50")
    summary = summary_of(tmp_path)
    assert done.returncode == 3 and summary["verdict"] == "tripped"
    assert "tripped" in done.stdout.splitlines()[0]
    assert summary["faults"][0]["fault"] == "OVER_CURRENT" and 0 < summary["faults"][0]["t_s"] < 0.05


@pytest.mark.parametrize(
    ("expected", "status", "verdict"),
    [
        ('{fault="OVER_CURRENT"}', 0, "pass"),
        ('{fault="OVER_CURRENT",fault_to_s=0.05}', 0, "pass"),
        ('{fault="OVER_CURRENT",fault_from_s=0.4}', 3, "tripped"),
        ('{fault="DC_OVER_VOLTAGE"}', 3, "tripped"),
    ],
)
def test_a_trip_can_be_what_is_expected(expected, status, verdict, tmp_path):
    text = (SCENARIOS / "reversal.toml").read_text().replace("../machines", str(ROOT / "configs" / "machines"))
    scenario = tmp_path / "trip.toml"
    scenario.write_text(text[: text.index("[expect]")])
    settings = ("protection.over_current_a=50", "duration_s=0.5", f"expect={expected}")
    words = [word for s in settings for word in ("--set", s)]
    done = run(scenario, "--integrator", "fixed", "--no-trace", *words, "--out", tmp_path / "out")
    summary = summary_of(tmp_path / "out")
    assert (done.returncode, summary["verdict"]) == (status, verdict), done.stdout + done.stderr
    assert summary["expected_fault"]["pass"] is (status == 0)


def test_an_expected_trip_that_does_not_come_fails(tmp_path):
    done = short_reversal(tmp_path, "expect.fault=OVER_CURRENT")
    assert done.returncode == 1 and summary_of(tmp_path)["verdict"] == "fail"
    assert "OVER_CURRENT was expected and did not come" in done.stderr


# 150 kW, 565 V: its flux takes longer than a run of 60 ms.
SLOW = """
name = "slow"
duration_s = 0.06
[machine]
r_s_ohm = 0.01379
r_r_ohm = 0.007728
l_ls_h = 0.000152
l_lr_h = 0.000152
l_m_h = 0.00769
poles = 4
inertia_kg_m2 = 2.9
reactance_frequency_hz = 50
[profile.torque_nm]
value = 500
[control]
controller = "foc"
[drive]
period_us = 125
[plant]
u_dc_v = 565
integrator = "exact"
[trace]
interval_us = 125
"""


def test_torque_that_is_asked_and_never_made_is_a_verdict_of_its_own(tmp_path):
    scenario = tmp_path / "slow.toml"
    scenario.write_text(SLOW + "[expect]\npeak_current_a.max = 1e4\n")
    done = run(scenario, "--no-trace", "--out", tmp_path)
    assert (done.returncode, summary_of(tmp_path)["verdict"]) == (4, "no_torque")
    assert "torque was asked, 500 N·m in the mean" in done.stderr and "in MAGNETISING at last" in done.stderr
    done = run(scenario, "--no-trace", "--out", tmp_path, "--set", "duration_s=1")
    assert (done.returncode, summary_of(tmp_path)["verdict"]) == (0, "pass"), done.stderr


@pytest.mark.parametrize(("limit", "status", "verdict"), [(3, 5, "not_followed"), (100, 0, "nothing_expected")])
@pytest.mark.parametrize("mode", ["sampled", "event_exact"])
def test_a_cycle_that_is_not_followed_is_a_verdict_of_its_own(mode, limit, status, verdict, tmp_path):
    text = (SCENARIOS / "paper" / "3_5_nycc_vehicle.toml").read_text().replace("../../", f"{ROOT}/configs/")
    (tmp_path / "cycle.csv").write_text("time_s,speed_kmh\n0,0\n1,0\n4,20\n")
    scenario = tmp_path / "vehicle.toml"
    scenario.write_text(text[: text.index("[expect]")].replace(f"{ROOT}/configs/cycles/nycc.csv", "cycle.csv"))
    settings = (f"mode={mode}", "duration_s=5", f"driver.torque_limit_nm={limit}")
    words = [word for setting in settings for word in ("--set", setting)]
    done = run(scenario, "--no-trace", "--out", tmp_path / "out", *words)
    assert (done.returncode, summary_of(tmp_path / "out")["verdict"]) == (status, verdict), done.stdout + done.stderr
    assert ("off its cycle" in done.stderr) == (status != 0)


def test_a_run_of_which_nothing_is_expected_says_so(tmp_path):
    scenario = tmp_path / "slow.toml"
    scenario.write_text(SLOW.replace("value = 500", "value = 0"))
    done = run(scenario, "--no-trace", "--out", tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert summary_of(tmp_path)["verdict"] == "nothing_expected" and "slow: nothing expected" in done.stdout
    done = run(scenario, "--no-trace", "--out", tmp_path, "--require-expectations")
    assert done.returncode == 9 and "nothing is expected of the run" in done.stderr


def test_of_several_runs_the_first_verdict_of_the_list_is_that_of_the_program(tmp_path):
    for name, text in (("silent", SLOW.replace("value = 500", "value = 0")), ("slow", SLOW)):
        (tmp_path / f"{name}.toml").write_text(text.replace('"slow"', f'"{name}"'))
    quick = ("--no-trace", "--out", tmp_path / "out")
    assert run(tmp_path / "silent.toml", SCENARIOS / "reversal.toml", *quick).returncode == 0
    both = (tmp_path / "silent.toml", SCENARIOS / "reversal.toml", "--require-expectations")
    assert run(*both, *quick).returncode == 9
    done = run(tmp_path / "silent.toml", tmp_path / "slow.toml", SCENARIOS / "reversal.toml", *quick)
    assert done.returncode == 4
    missed = ("--set", "expect.peak_current_a={max=1}")
    assert run(SCENARIOS / "reversal.toml", tmp_path / "silent.toml", *quick, *missed).returncode == 1
    assert run(SCENARIOS / "reversal.toml", tmp_path / "slow.toml", *quick, *missed).returncode == 4


def named(names, directory):
    """Scenarios of these names that run through."""
    files = [directory / f"{name}.toml" for name in names]
    for file in files:
        file.write_text(SLOW.replace('"slow"', f'"{file.stem}"').replace("value = 500", "value = 0"))
    return files


def test_scenarios_at_a_time_have_the_results_of_one_after_the_other(tmp_path):
    files = []
    for name, torque in (("longest", 15), ("silent", 0), ("shortest", 20)):
        files.append(tmp_path / f"{name}.toml")
        files[-1].write_text(SLOW.replace('"slow"', f'"{name}"').replace("value = 500", f"value = {torque}"))
    found = {}
    for jobs in (1, 3):
        out = tmp_path / str(jobs)
        words = ("--no-trace", "--require-expectations", "--out", out, "--junit", out / "junit.xml", "--jobs", jobs)
        done = run(*files, *words)
        timeless = re.sub(r"(wall_s|realtime_factor) .*", "", done.stdout)
        cases = re.findall(r'<testcase name="([^"]+)"', (out / "junit.xml").read_text())
        metrics = {file.stem: summary_of(out / file.stem)["metrics"] for file in files}
        for of_one in metrics.values():
            del of_one["wall_s"], of_one["realtime_factor"]
        found[jobs] = (done.returncode, timeless, cases, metrics)
    assert found[3] == found[1]


def test_after_a_scenario_that_cannot_run_no_further_one_begins(tmp_path):
    files = named(("refused", "last"), tmp_path)
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "refused").write_text("a file where a directory belongs")
    done = run(*files, "--out", tmp_path / "out", "--no-trace")
    assert done.returncode == 2, done
    assert "refused" in done.stderr
    assert not (tmp_path / "out" / "last").exists()


def test_a_scenario_that_cannot_run_costs_none_beside_it_its_report(tmp_path):
    files = named(("beside", "refused"), tmp_path)
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "refused").write_text("a file where a directory belongs")
    done = run(*files, "--out", tmp_path / "out", "--no-trace", "--jobs", 2, "--junit", tmp_path / "junit.xml")
    assert done.returncode == 2, done
    assert "beside" in done.stdout
    assert summary_of(tmp_path / "out" / "beside")["verdict"] == "nothing_expected"
    assert (tmp_path / "junit.xml").read_text().count("<error") == 1


def test_help_and_page_have_the_same_statuses():
    told = run("--help").stdout
    in_help = {word: status for status, word in re.findall(r"^ +(\d+)  (\w+)  +\S", told, re.MULTILINE)}
    page = (ROOT / "docs" / "ci.md").read_text()
    in_page = dict(re.findall(r"^\| `(\w+)` \| (\d+)\b", page, re.MULTILINE))
    assert in_help == in_page and len(in_help) == 11
    assert re.search(r"nothing_expected .* 9 with --require-expectations", told)


def test_a_fault_at_power_up_can_be_expected(tmp_path):
    scenario = tmp_path / "fast.toml"
    fast = '[load]\nkind = "imposed_speed"\nspeed_rad_s.value = 628\n[protection]\nover_speed_rad_s = 400\n'
    scenario.write_text(SLOW + fast)
    assert "628 rad/s, above protection.over_speed_rad_s, 400 rad/s" in run(scenario, "--out", tmp_path).stderr
    scenario.write_text(SLOW + fast + '[expect]\nfault = "OVER_SPEED"\n')
    done = run(scenario, "--no-trace", "--out", tmp_path)
    assert (done.returncode, summary_of(tmp_path)["verdict"]) == (0, "pass"), done.stderr
    assert summary_of(tmp_path)["faults"][0]["t_s"] < 0


def test_limits_of_a_window_are_judged_in_it(tmp_path):
    holds, misses = "torque_bias_nm={min=-3,max=3}", "flux_mean_wb={min=1.09}"
    done = short_reversal(tmp_path, f"expect.window=[{{from_s=0.1,to_s=0.3,{holds}}},{{from_s=0,to_s=0.01,{misses}}}]")
    rows = [row for row in summary_of(tmp_path)["expect"] if "window" in row]
    assert [row["pass"] for row in rows] == [True, False]
    assert rows[0]["window"] == {"from_s": 0.1, "to_s": 0.3}
    assert done.returncode == 1 and "0 s to 0.01 s" in done.stdout


def test_the_summary_says_what_was_run(tmp_path):
    short_reversal(tmp_path, "control.dtc.torque_band_upper_nm=0.75")
    summary = summary_of(tmp_path)
    assert summary["configuration"]["control.dtc.torque_band_upper_nm"] == 0.75
    assert summary["configuration"]["machine.r_s_ohm"] > 0
    assert summary["configuration"]["duration_s"] == 0.5
    assert summary["configuration"]["profile.torque_nm.points"][0] == [0, 15]
    assert re.fullmatch(r"\d+\.\d+\.\d+", summary["version"])
    assert re.fullmatch(r"unknown|[\w.-]+", summary["commit"])


@pytest.mark.parametrize(("name", "status"), [("SIGINT", 130), ("SIGTERM", 143)])
@pytest.mark.parametrize("mode", ["sampled", "event_exact"])
def test_an_interrupted_run_leaves_trace_and_summary(mode, name, status, tmp_path):
    scenario = SCENARIOS / "paper" / "3_1_constant_torque.toml"
    settings = (f"mode={mode}", "duration_s=10000", "plant.integrator=fixed", "trace.interval_us=10000")
    words = [word for setting in settings for word in ("--set", setting)]
    command = [os.environ["SEXTANT_MIL"], str(scenario), *words, "--out", str(tmp_path)]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as program:
        deadline = time.monotonic() + 50
        while not (tmp_path / "trace.h5").exists():
            assert program.poll() is None and time.monotonic() < deadline
            time.sleep(0.05)
        time.sleep(0.5)
        program.send_signal(getattr(signal, name))
        said = program.communicate(timeout=50)[1]
    assert program.returncode == status and "interrupted at" in said
    summary = summary_of(tmp_path)
    assert summary["verdict"] == "interrupted" and summary["metrics"]["simulated_s"] > 0
    with h5py.File(tmp_path / "trace.h5") as trace:
        assert trace["t_ns"][-1] == pytest.approx(1e9 * summary["metrics"]["simulated_s"], abs=2e7)


@pytest.mark.parametrize("jobs", [1, 2])
def test_an_interruption_ends_what_runs_and_begins_nothing(jobs, tmp_path):
    files = named(("first", "second", "third"), tmp_path)
    out = tmp_path / "out"
    assert run(files[2], "--no-trace", "--out", out / "third").returncode == 0
    earlier = (out / "third" / "summary.json").read_text()
    words = ["--set", "duration_s=10000", "--set", "trace.interval_us=10000", "--jobs", str(jobs)]
    running = files[:jobs]
    traces = [out / file.stem / "trace.h5" for file in running]
    with subprocess.Popen(
        [os.environ["SEXTANT_MIL"], *files, *words, "--out", out, "--junit", out / "junit.xml"],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    ) as program:
        deadline = time.monotonic() + 50
        while not all(trace.exists() for trace in traces):
            assert program.poll() is None and time.monotonic() < deadline
            time.sleep(0.05)
        program.send_signal(signal.SIGINT)
        said = program.communicate(timeout=50)[0]
    assert program.returncode == 130
    assert [summary_of(trace.parent)["verdict"] for trace in traces] == ["interrupted"] * jobs
    assert all(file.stem in said for file in running)
    assert (out / "junit.xml").read_text().count("<error") == jobs
    assert (out / "third" / "summary.json").read_text() == earlier


def test_an_earlier_result_is_replaced_aloud(tmp_path):
    short_reversal(tmp_path, "name=first")
    (tmp_path / "plot.png").write_text("of mine")
    done = short_reversal(tmp_path, "name=second")
    assert re.search(
        rf'{tmp_path}: replaces the result of "first" of \d{{4}}-\d\d-\d\d \d\d:\d\d:\d\d UTC', done.stderr
    )
    assert summary_of(tmp_path)["scenario"] == "second"
    assert (tmp_path / "plot.png").read_text() == "of mine"


def test_a_trace_does_not_outlive_its_summary(tmp_path):
    run(SCENARIOS / "reversal.toml", "--set", "duration_s=0.5", "--integrator", "fixed", "--out", tmp_path)
    assert (tmp_path / "trace.h5").exists()
    short_reversal(tmp_path, "name=second")
    assert not (tmp_path / "trace.h5").exists()


@pytest.mark.parametrize("name", ["summary.json", "trace.h5"])
def test_a_file_that_is_no_result_is_not_replaced(name, tmp_path):
    (tmp_path / name).write_text('{"mine": 1}')
    done = short_reversal(tmp_path, "name=second")
    assert done.returncode == 2 and f"{name} is there and is no result of a run" in done.stderr
    assert (tmp_path / name).read_text() == '{"mine": 1}'


@pytest.mark.parametrize("arguments", [(), ("--nonsense",), ("a.toml", "--integrator", "euler")])
def test_a_wrong_command_line_is_one_sentence_and_status_2(arguments):
    done = run(*arguments)
    assert done.returncode == 2 and len(done.stderr.strip().splitlines()) == 1
    assert "--help" in done.stderr


def test_missing_scenario_is_one_sentence(tmp_path):
    done = run(tmp_path / "nothing.toml", "--out", tmp_path / "out")
    assert done.returncode == 2
    assert "nothing.toml" in done.stderr and len(done.stderr.strip().splitlines()) == 1
    assert not (tmp_path / "out").exists()


def rows_of(trace_file: Path, copy: Path) -> int:
    """How many rows a trace has that another process still writes."""
    try:
        copy.write_bytes(trace_file.read_bytes())
        with h5py.File(copy) as trace:
            return len(trace["t_ns"])
    except (OSError, KeyError):
        return 0


@pytest.mark.parametrize("mode", ["sampled", "event_exact"])
def test_a_killed_run_leaves_a_readable_trace(mode, tmp_path):
    scenario = SCENARIOS / "paper" / "3_1_constant_torque.toml"
    settings = (f"mode={mode}", "duration_s=10000", "plant.integrator=fixed", "trace.interval_us=10000")
    words = [word for setting in settings for word in ("--set", setting)]
    command = [os.environ["SEXTANT_MIL"], str(scenario), *words, "--out", str(tmp_path)]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as program:
        # Rows are written about once a second of wall time; the whole run takes many.
        # Killed behind a write, not within one: HDF5 has no order of what it writes then.
        deadline = time.monotonic() + 50
        before = rows = 0
        while not (rows > 100 and rows > before > 0):
            assert program.poll() is None, "the run ended before it could be killed"
            assert time.monotonic() < deadline, "no rows are written"
            time.sleep(0.05)
            before, rows = max(before, rows), rows_of(tmp_path / "trace.h5", tmp_path / "copy.h5")
        program.kill()
    trace_file = tmp_path / "trace.h5"
    with h5py.File(trace_file) as trace:
        rows = len(trace["t_ns"])
        assert rows > 100
        assert trace.attrs["mode"].decode() == mode
        assert b"envelope" in trace.attrs["decimation"]
        for name in ("torque_mean_nm", "plant/torque_min_nm", "plant/torque_max_nm", "plant/flux_mean_wb"):
            values = trace[name][...]
            assert len(values) == rows and all(map(math.isfinite, values)), name


def test_a_full_cycle_needs_little_memory(tmp_path):
    """As many rows as the whole NYCC has at 750 us, in its first 20 s: the trace is not held in memory."""
    scenario = SCENARIOS / "paper" / "3_5_nycc_linear.toml"
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
    done = run(
        scenario,
        "--set",
        "mode=sampled",
        "--set",
        "trace.interval_us=25",
        "--set",
        "duration_s=20",
        "--set",
        "metrics.window_from_s=1",
        "--out",
        tmp_path,
    )
    assert summary_of(tmp_path)["verdict"] in ("pass", "fail"), done.stderr
    with h5py.File(tmp_path / "trace.h5") as trace:
        assert len(trace["t_ns"]) >= 800_000
    assert max(before, resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss) < 300 * 1024


# A machine of 44 V and one of 540 V: R_s, R_r [ohm], L_ls, L_lr, L_m [H], poles, flux reference [Wb], link [V].
STANDSTILL_MACHINES = {
    "44 V": (6.317e-5, 7.753e-5, 1.306e-6, 1.027e-6, 3.885e-5, 8, 0.0755, 44.2),
    "540 V": (0.057, 0.0316, 1.124e-3, 1.124e-3, 25.58e-3, 4, 1.04, 540.0),
}


@pytest.mark.parametrize("machine", STANDSTILL_MACHINES)
@pytest.mark.parametrize(
    ("controller", "estimator"),
    [("foc", "hybrid"), ("dtc", "hybrid"), ("foc", "current_model"), ("foc", "observer")],
)
def test_a_start_while_the_shaft_passes_through_standstill_makes_its_torque(controller, estimator, machine, tmp_path):
    """Exact parameters, ideal sensors: from 50 ms of torque on it is within 2 % of the breakdown torque."""
    r_s, r_r, l_ls, l_lr, l_m, poles, flux, link = STANDSTILL_MACHINES[machine]
    tau_r = (l_lr + l_m) / r_r
    leakage = l_ls + l_lr * l_m / (l_lr + l_m)
    breakdown = 0.375 * poles * (1 / leakage - 1 / (l_ls + l_m)) * flux**2
    base_speed = link / math.sqrt(3) / (poles / 2 * flux)
    for share in (0.5, 0.58, 0.66, 0.74):
        passage = share * tau_r
        scenario = tmp_path / "start.toml"
        scenario.write_text(
            f'name = "start"\nduration_s = {1.3 * tau_r + 0.1}\n'
            f"[machine]\nr_s_ohm = {r_s}\nr_r_ohm = {r_r}\nl_ls_h = {l_ls}\nl_lr_h = {l_lr}\nl_m_h = {l_m}\n"
            f"poles = {poles}\ninertia_kg_m2 = 1\n"
            f'[control]\ncontroller = "{controller}"\nflux_estimator = "{estimator}"\n'
            f'flux_reference_wb = {flux}\n[plant]\nintegrator = "fixed"\nu_dc_v = {link}\n'
            f'[load]\nkind = "imposed_speed"\n[load.speed_rad_s]\nshape = "linear"\n'
            f"points = [[0, {base_speed}], [{2 * passage}, {-base_speed}]]\n"
            f'[profile.torque_nm]\nvalue = {0.15 * breakdown}\n[trace]\ninterval_us = 1000\nsignals = ["all"]\n'
        )
        done = run(scenario, "--out", tmp_path / "out")
        assert done.returncode != 2, done.stderr
        with h5py.File(tmp_path / "out" / "trace.h5") as trace:
            reference = trace["torque_reference_nm"][:]
            torque = trace["plant/torque_mean_nm"][:]
        first = next(k for k, x in enumerate(reference) if x > 0)
        assert first + 150 < len(torque), "the torque starts too late"
        for k in range(first + 50, len(torque) - 5, 5):
            mean = sum(torque[k : k + 5]) / 5
            assert abs(mean - reference[k]) < 0.02 * breakdown, f"{share} tau_r, {k} ms"


def test_a_trace_of_several_rows_a_period_shows_the_ripple_within_it(tmp_path):
    """A modulated method samples where the ripple of the control period is zero: one row a period has none of it."""
    rows = {}
    for parts in (1, 25):
        settings = (
            "control.controller=foc",
            "duration_s=0.35",
            "metrics.window_from_s=0.3",
            f"trace.interval_us={25 / parts}",
        )
        words = [word for setting in settings for word in ("--set", setting)]
        out = tmp_path / str(parts)
        run(SCENARIOS / "constant_torque.toml", *words, "--out", out)
        with h5py.File(out / "trace.h5") as file:
            names = [name for name in (*file, *(f"plant/{name}" for name in file["plant"])) if name != "plant"]
            rows[parts] = {name: file[name][()] for name in names if isinstance(file[name], h5py.Dataset)}
    coarse, fine = rows[1], rows[25]
    assert len(fine["t_ns"]) == 25 * (len(coarse["t_ns"]) - 1) + 1
    assert set(np.diff(fine["t_ns"])) == {1000}
    statistics = re.compile(r"plant/.*_(mean|min|max)_.*")
    for name, values in coarse.items():
        if not statistics.fullmatch(name):
            np.testing.assert_array_equal(fine[name][::25], values, err_msg=name)
    for reduce, name in ((np.min, "plant/torque_min_nm"), (np.max, "plant/torque_max_nm")):
        blocks = fine[name][1:].reshape(-1, 25)
        np.testing.assert_allclose(reduce(blocks, axis=1), coarse[name][1:], rtol=0, atol=1e-9)
    means = fine["plant/torque_mean_nm"][1:].reshape(-1, 25).mean(axis=1)
    np.testing.assert_allclose(means, coarse["plant/torque_mean_nm"][1:], rtol=0, atol=1e-9)
    settled = coarse["t_ns"] > 300_000_000
    ripple = (coarse["plant/torque_max_nm"] - coarse["plant/torque_min_nm"])[settled].mean()
    sampled = np.ptp(coarse["plant/torque_nm"][settled])
    within = np.ptp(fine["plant/torque_nm"][1:].reshape(-1, 25), axis=1)[settled[1:]].mean()
    print(f"{sampled:.2g} N·m at the control periods, {within:.2g} N·m within them, {ripple:.2g} N·m by extremes")
    assert sampled < 0.1 * ripple
    assert 0.8 * ripple < within <= ripple


def test_rows_within_a_period_have_the_switching_state_of_their_voltage(tmp_path):
    """Where all legs conduct the stator voltage is that of their states, within the voltage drops of the inverter."""
    out = tmp_path / "run"
    settings = (
        "control.controller=foc",
        "duration_s=0.1",
        "metrics.window_from_s=0.05",
        "trace.interval_us=1",
        'trace.signals=["standard", "switching", "voltage"]',
    )
    run(
        SCENARIOS / "constant_torque.toml", *(word for setting in settings for word in ("--set", setting)), "--out", out
    )
    with h5py.File(out / "trace.h5") as file:
        a, b, c = (file[f"plant/switch_{leg}"][()].astype(float) for leg in "abc")
        u_alpha, u_dc = file["plant/u_s_alpha_v"][()], file["plant/u_dc_v"][()]
    conducting = (np.minimum(np.minimum(a, b), c) >= 0) & (np.arange(len(a)) > 0)
    assert conducting.sum() > 10_000
    expected = u_dc * (2 * a - b - c) / 3
    assert np.abs(u_alpha - expected)[conducting].max() < 0.1 * u_dc.max()
