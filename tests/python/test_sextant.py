"""`import sextant`: runs and sweeps against the program's own summary."""

import json
import math
import subprocess
from pathlib import Path

import h5py
import matplotlib
import numpy as np
import pytest
import sextant
from programs import program
from sextant_py.paths import ROOT

SCENARIO = ROOT / "configs" / "scenarios" / "constant_torque.toml"
QUICK = {"duration_s": 0.25, "plant.integrator": "fixed"}
MEASURED = {"wall_s", "realtime_factor"}  # by the clock: not the same in two runs


@pytest.fixture(autouse=True)
def programs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SEXTANT_BIN", str(program("sextant-mil").parent))


def test_a_run_is_that_of_the_program(tmp_path: Path) -> None:
    words = [program("sextant-mil"), SCENARIO, "--out", tmp_path / "out"]
    words += [word for key, value in QUICK.items() for word in ("--set", f"{key}={json.dumps(value)}")]
    subprocess.run(words, check=True, capture_output=True)
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    run = sextant.run(SCENARIO, overrides=QUICK)
    assert run.verdict == summary["verdict"] == "pass"
    assert {k: v for k, v in run.metrics.items() if k not in MEASURED} == {
        k: v for k, v in summary["metrics"].items() if k not in MEASURED
    }
    with h5py.File(tmp_path / "out" / "trace.h5") as trace:
        np.testing.assert_array_equal(run.trace["plant/torque_nm"], trace["plant/torque_nm"][()])
        assert run.trace.attrs["units"]["plant/torque_nm"] == trace["plant/torque_nm"].attrs["unit"].decode()
    assert run.trace.index[-1] == pytest.approx(0.25, abs=2e-3)


def test_a_run_keeps_its_results_where_it_is_told_to(tmp_path: Path) -> None:
    run = sextant.run(SCENARIO, overrides=QUICK, out=tmp_path / "here", trace=False)
    assert (tmp_path / "here" / "summary.json").is_file()
    assert run.summary["configuration"]["duration_s"] == 0.25
    with pytest.raises(sextant.UserError, match="ran without a trace; run it with trace=True"):
        _ = run.trace


def test_a_run_that_fails_its_limits_is_a_result() -> None:
    run = sextant.run(SCENARIO, overrides={**QUICK, "expect.torque_ripple_pp_nm.max": 1}, trace=False)
    assert run.verdict == "fail"
    assert run.metrics["torque_ripple_pp_nm"] > 1
    tripped = sextant.run(SCENARIO, overrides={**QUICK, "protection.over_current_a": 50}, trace=False)
    assert (tripped.verdict, "tripped with OVER_CURRENT" in tripped.said) == ("tripped", True)


def test_what_the_program_refuses_is_told() -> None:
    with pytest.raises(sextant.UserError, match="duraton_s: unknown key; the nearest known one is duration_s"):
        sextant.run(SCENARIO, overrides={"duraton_s": 1})
    with pytest.raises(sextant.UserError, match=r"none\.toml: cannot be read: No such file"):
        sextant.run("none.toml")


def test_without_the_program_a_sentence_says_so(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("SEXTANT_BIN", str(tmp_path))
    with pytest.raises(sextant.UserError, match="where no sextant-mil is"):
        sextant.run(SCENARIO)


def test_a_sweep_is_the_runs_of_its_points() -> None:
    ranges = {"machine.r_s_ohm": (0.39, 0.48), "machine.r_r_ohm": (0.4, 1.6, "log")}
    frame = sextant.sweep(SCENARIO, ranges, samples=4, overrides=QUICK, workers=2, seed=7)
    assert frame["status"].tolist() == ["ok"] * 4
    assert frame["machine.r_s_ohm"].between(0.39, 0.48).all()
    assert frame["machine.r_r_ohm"].between(0.4, 1.6).all()
    point = frame.loc[2]
    run = sextant.run(SCENARIO, overrides=QUICK | {key: point[key] for key in ranges}, trace=False)
    assert run.metrics["torque_ripple_pp_nm"] == point["torque_ripple_pp_nm"]
    assert frame.attrs["units"]["torque_ripple_pp_nm"] == "N·m"


def test_a_grid_has_every_combination(tmp_path: Path) -> None:
    ranges = {"control.flux_reference_wb": (0.9, 1.1, 2), "drive.period_us": [25, 50]}
    frame = sextant.sweep(SCENARIO, ranges, method="grid", overrides=QUICK, out=tmp_path)
    pairs = list(zip(frame["control.flux_reference_wb"], frame["drive.period_us"], strict=True))
    assert pairs == [(0.9, 25), (0.9, 50), (1.1, 25), (1.1, 50)]
    again = sextant.sweep(SCENARIO, ranges, method="grid", overrides=QUICK, out=tmp_path)
    assert again["wall_s"].tolist() == frame["wall_s"].tolist()  # finished points are not run again


def test_coupled_keys_are_one_axis() -> None:
    coupled = [{"control.flux_reference_wb": [0.9, 1.1], "control.dtc.torque_band_upper_nm": (0.5, 0.9, 2)}]
    frame = sextant.sweep(SCENARIO, {"drive.period_us": [25, 50]}, method="grid", overrides=QUICK, coupled=coupled)
    keys = ["drive.period_us", "control.flux_reference_wb", "control.dtc.torque_band_upper_nm"]
    rows = [tuple(row) for row in frame[keys].to_numpy()]
    assert rows == [(25, 0.9, 0.5), (25, 1.1, 0.9), (50, 0.9, 0.5), (50, 1.1, 0.9)]
    assert frame["torque_ripple_pp_nm"].nunique() == 4  # each was run


def test_coupled_keys_may_stand_alone() -> None:
    coupled = [{"machine.r_s_ohm": (0.39, 0.48), "machine.r_r_ohm": (0.4, 1.6, "log")}]
    frame = sextant.sweep(SCENARIO, overrides=QUICK, coupled=coupled, samples=2)
    share = (frame["machine.r_s_ohm"] - 0.39) / 0.09
    np.testing.assert_allclose(frame["machine.r_r_ohm"], 0.4 * 4**share)


def test_a_list_of_points_is_the_file_of_scripts_sweep(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "points.csv").write_text("drive.period_us,control.flux_reference_wb\n25,0.9\n50,1.1\n")
    monkeypatch.chdir(tmp_path)
    frame = sextant.sweep(SCENARIO, points="points.csv", overrides=QUICK)
    assert frame["drive.period_us"].tolist() == [25, 50]
    assert frame["control.flux_reference_wb"].tolist() == [0.9, 1.1]
    assert frame["torque_ripple_pp_nm"].nunique() == 2  # each was run


RANGE = {"machine.r_s_ohm": (0.39, 0.48)}


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"ranges": {}}, "ranges, coupled or points: expected at least one key"),
        ({"coupled": [{"machine.r_s_ohm": [1, 2]}]}, "coupled.machine.r_s_ohm: expected two or more keys that move"),
        (
            {"coupled": [{"machine.r_s_ohm": [1, 2], "machine.r_r_ohm": [1]}]},
            "coupled.machine.r_r_ohm: expected as many values as machine.r_s_ohm has",
        ),
        (
            {"ranges": RANGE, "coupled": [{"machine.r_s_ohm": (1, 2), "machine.r_r_ohm": (1, 2)}]},
            "coupled.machine.r_s_ohm: this key varies elsewhere",
        ),
        ({"coupled": {"machine.r_s_ohm": (1, 2)}}, "coupled: expected a list of dictionaries"),
        ({"coupled": [{"machine.r_s_ohm": (1, 2, 3, 4), "a": (1, 2)}]}, r"coupled: machine.r_s_ohm: expected \(low"),
        ({"points": "none.csv"}, "none.csv cannot be read: No such file"),
        ({"points": "none.csv", "ranges": RANGE}, "points: a list of points has every key that varies: leave ranges"),
        (
            {"points": "none.csv", "coupled": [{"a": [1], "b": [2]}]},
            "a list of points has every key that varies: leave ",
        ),
        ({"ranges": {"machine.r_s_ohm": (1, 2)}, "method": "halton"}, 'got "halton"'),
        ({"ranges": {"machine.r_s_ohm": (1, 2)}, "samples": 60}, "a power of two, such as 32 or 64, got 60"),
        ({"ranges": {"machine.r_s_ohm": (2, 1)}}, "sextant.sweep: random.ranges.machine.r_s_ohm: expected from < to"),
        ({"ranges": {"machine.r_s": (1, 2)}}, "sextant.sweep: machine.r_s: unknown key"),
        ({"ranges": {"machine.r_s_ohm": (1, 2)}, "method": "grid"}, r"expected \(low, high, count\)"),
        ({"ranges": {"machine.r_s_ohm": (1, 2)}, "workers": 0}, "workers: expected a number from 1"),
        ({"ranges": {"machine.r_s_ohm": (1, math.nan)}}, 'expected a finite number for "to", got nan'),
    ],
)
def test_a_bad_sweep_is_refused(options: dict, words: str) -> None:
    with pytest.raises(sextant.UserError, match=words):
        sextant.sweep(SCENARIO, **options)


def test_the_notebook_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its cells in order, as Jupyter runs them: in its directory, with the names of those before."""
    matplotlib.use("Agg")
    file = ROOT / "docs" / "examples" / "tutorial.ipynb"
    monkeypatch.chdir(file.parent)
    notebook = json.loads(file.read_text(encoding="utf-8"))
    assert notebook["nbformat"] == 4
    names: dict[str, object] = {}
    cells = ["".join(cell["source"]) for cell in notebook["cells"] if cell["cell_type"] == "code"]
    for number, cell in enumerate(cells):
        exec(compile(cell, f"{file.name}, cell {number}", "exec"), names)
    assert names["run"].verdict == "pass"
    assert set(names["table"]["status"]) <= {"ok", "expect_failed"}  # every point ran
    assert names["table"]["torque_bias_nm"].std() > 0.01  # the machine's parameters matter
    assert all(cell.get("outputs", []) == [] for cell in notebook["cells"])
