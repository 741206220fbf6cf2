"""sextant-mil as its user starts it: exit status, summary and trace."""

import json
import math
import os
import re
import resource
import subprocess
import time
from pathlib import Path

import h5py
import pytest

ROOT = Path(__file__).resolve().parents[2]
SCENARIOS = ROOT / "configs" / "scenarios"


def run(*arguments) -> subprocess.CompletedProcess:
    command = [os.environ["SEXTANT_MIL"], *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=60, cwd="/")


def idl_members(struct: str) -> set[str]:
    text = (ROOT / "configs" / "interfaces" / "telemetry.idl").read_text()
    text = re.sub(r"//[^\n]*|/\*.*?\*/", "", text, flags=re.DOTALL)
    body = re.search(rf"struct\s+{struct}\s*\{{(.*?)\}}", text, flags=re.DOTALL)[1]
    return set(re.findall(r"(\w+)\s*;", body))


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
        of_the_channel = {"drive_id", "_sequence", "dropped"}
        assert idl_members("DriveTelemetry") - of_the_channel <= drive
        assert all("unit" in trace[key].attrs for key in drive)
        rows = len(trace["t_ns"])
        assert rows > 1000 and all(len(trace[key]) == rows for key in drive)
        assert trace["plant/torque_nm"].attrs["unit"].decode() == "N·m"


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
    assert done.returncode == 1
    assert "OVER_CURRENT" in done.stderr


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
        deadline = time.monotonic() + 50
        while rows_of(tmp_path / "trace.h5", tmp_path / "copy.h5") <= 100:
            assert program.poll() is None, "the run ended before it could be killed"
            assert time.monotonic() < deadline, "no rows are written"
            time.sleep(0.2)
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
    assert done.returncode in (0, 1), done.stderr
    with h5py.File(tmp_path / "trace.h5") as trace:
        assert len(trace["t_ns"]) >= 800_000
    assert max(before, resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss) < 300 * 1024
