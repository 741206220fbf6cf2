"""sextant-mil as its user starts it: exit status, summary and trace."""

import json
import os
import re
import subprocess
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
def test_shipped_scenario_passes(name, tmp_path):
    done = run(SCENARIOS / f"{name}.toml", "--integrator", "fixed", "--out", tmp_path)
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


def test_failed_expectation_fails_the_run(tmp_path):
    done = run(
        SCENARIOS / "reversal.toml",
        "--integrator",
        "fixed",
        "--out",
        tmp_path,
        "--no-trace",
        "--set",
        "duration_s=0.5",
        "--set",
        "expect.peak_current_a={max=1}",
    )
    assert done.returncode == 1, done.stdout + done.stderr
    expect = json.loads((tmp_path / "summary.json").read_text())["expect"]
    failed = [expectation for expectation in expect if not expectation["pass"]]
    assert [expectation["metric"] for expectation in failed] == ["peak_current_a"]
    assert failed[0]["limit"] == {"max": 1.0} and failed[0]["value"] > 1
    assert not (tmp_path / "trace.h5").exists()


def test_trip_fails_the_run_and_is_named(tmp_path):
    done = run(
        SCENARIOS / "reversal.toml",
        "--integrator",
        "fixed",
        "--out",
        tmp_path,
        "--no-trace",
        "--set",
        "duration_s=0.5",
        "--set",
        "protection.over_current_a=50",
    )
    assert done.returncode == 1
    assert "OVER_CURRENT" in done.stderr


def test_missing_scenario_is_one_sentence(tmp_path):
    done = run(tmp_path / "nothing.toml", "--out", tmp_path / "out")
    assert done.returncode == 2
    assert "nothing.toml" in done.stderr and len(done.stderr.strip().splitlines()) == 1
    assert not (tmp_path / "out").exists()
