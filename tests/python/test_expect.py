"""Recordings evaluated by a scenario's [expect]: whatever is decided is what sextant-mil says of the same run."""

import dataclasses
import json
import math
import random
import subprocess
from functools import partial
from pathlib import Path

import junitparser
import made_recording
import numpy as np
import pytest
from programs import program
from sextant_py import expect, mil_program
from sextant_py.errors import status_or_refusal
from sextant_py.expect_bounds import COLUMNS, WINDOWED, Bounds, absence, bounds
from sextant_py.expect_rows import rows_of
from sextant_py.expect_scenario import Window
from sextant_py.paths import ROOT
from sextant_py.recording.formats import SUFFIXES
from sextant_py.recording.model import MAIN
from sextant_py.recording.topics import STATE, group_of
from sextant_py.signal_file import SignalFile

SCENARIOS = ROOT / "configs" / "scenarios"
EPSILON = 1e-9  # rounding of sums
WHOLE = ("peak_current_a", "response_time_ms")  # of the whole run


@pytest.fixture(autouse=True)
def built(monkeypatch: pytest.MonkeyPatch) -> None:
    """The program of the build that is tested."""
    monkeypatch.setattr(mil_program, "find", lambda wanted: program("sextant-mil"))


def mil(scenario: Path, out: Path, settings: list[str], *words: object) -> dict:
    """The summary of a run."""
    pairs = [word for setting in settings for word in ("--set", setting)]
    done = subprocess.run(
        [program("sextant-mil"), scenario, "--out", out, *pairs, *words], capture_output=True, text=True
    )
    assert (out / "summary.json").is_file(), done.stderr
    return json.loads((out / "summary.json").read_text())


def drawn(seed: int) -> tuple[Path, list[str], Window, float | None]:
    """A scenario with a random window, interval of the trace, step, control method and fault."""
    draw = random.Random(seed)
    name = draw.choice(["constant_torque.toml", "reversal.toml", "paper/3_1_constant_torque.toml"])
    is_exact = name.startswith("paper")
    duration_s = draw.choice([0.1, 0.2]) if is_exact else draw.uniform(0.5, 0.7)
    from_s = draw.choice([0.0, draw.uniform(0.0, 0.5 * duration_s)])
    to_s = draw.choice([None, draw.uniform(0.6 * duration_s, duration_s)])
    settings = [f"duration_s={duration_s}", f"metrics.window_from_s={from_s}"]
    settings += [f"metrics.window_to_s={to_s}"] if to_s else []
    step_s = 0.4 if name == "reversal.toml" else 0.0
    settings.append(f"metrics.step_s={step_s}")
    settings.append(f"trace.interval_us={draw.choice([25, 100, 1000, 3000])}")
    if not is_exact:
        settings.append(f'control.controller="{draw.choice(["dtc", "foc", "deadbeat"])}"')
        if draw.random() < 0.2:
            settings.append("protection.over_current_a=60")
    print(f"seed {seed}: {name} {settings}")
    return SCENARIOS / name, settings, Window(from_s, to_s), step_s


@pytest.mark.parametrize("seed", range(16))
def test_bounds_hold_the_value_of_sextant_mil(seed: int, tmp_path: Path) -> None:
    scenario, settings, window, step_s = drawn(seed)
    summary = mil(scenario, tmp_path, settings)
    rows = rows_of(SignalFile(tmp_path / "trace.h5"), 0.0)
    duration_s = summary["configuration"]["duration_s"]
    for metric in (*WINDOWED, *WHOLE):
        value = summary["metrics"][metric]
        found = bounds(metric, rows, window, step_s, 0.0, duration_s)
        if math.isnan(found.low):
            assert value is None, metric
            continue
        assert metric in WHOLE or math.isfinite(found.high), metric  # a bound that is none would hold anything
        if value is not None:
            slack = EPSILON * max(1.0, abs(value))
            assert found.low - slack <= value <= found.high + slack, (metric, found, value)


@pytest.mark.parametrize("seed", range(6))
def test_what_is_decided_is_the_verdict_of_sextant_mil(seed: int, tmp_path: Path) -> None:
    """Limits at random about the values, of the run and of windows of their own; also the names of the test cases."""
    print(f"seed {seed}")
    draw = random.Random(seed)
    base = SCENARIOS / draw.choice(["constant_torque.toml", "reversal.toml"])
    values = mil(base, tmp_path / "values", ["duration_s=0.6"], "--no-trace")["metrics"]

    def limits() -> list[str]:
        lines = []
        for metric in draw.sample([*WINDOWED, *WHOLE], 5):
            width = abs(values[metric] or 1.0) * 10 ** draw.uniform(-2, 0)
            middle = (values[metric] or 0.0) + draw.uniform(-1.5, 1.5) * width
            ends = [f"min = {middle - width:.6g}", f"max = {middle + width:.6g}"]
            lines.append(f"{metric} = {{ {', '.join(draw.choice([ends, ends[:1], ends[1:]]))} }}")
        return lines

    text = base.read_text().split("[expect]")[0].replace('"../machines', f'"{ROOT}/configs/machines')
    text = text.replace("duration_s = ", "duration_s = 0.6 #")
    fault = ['fault = "OVER_CURRENT"', f"fault_to_s = {draw.choice([0.001, 0.3])}"] if seed % 3 == 0 else []
    text += "\n".join(
        ["[expect]", *fault, *limits(), "[[expect.window]]", "from_s = 0.25", "to_s = 0.5", *limits(), ""]
    )
    scenario = tmp_path / "scenario.toml"
    scenario.write_text(text)
    settings = ["protection.over_current_a=60"] if seed % 2 else []
    summary = mil(scenario, tmp_path / "run", settings, "--junit", tmp_path / "mil.xml")
    pairs = [word for setting in settings for word in ("--set", setting)]
    status = expect.main([str(scenario), str(tmp_path / "run"), "--junit", str(tmp_path / "own.xml"), *pairs])
    theirs, own = (suite_of(tmp_path / name) for name in ("mil.xml", "own.xml"))
    assert list(own) == list(theirs)
    opened = {name for name, said in own.items() if "leaves it open" in said}
    assert len(opened) < len(own) - 2
    for name in own.keys() - opened - {"verdict"}:
        assert bool(own[name]) == bool(theirs[name]), name
    if not opened:
        verdict = summary["verdict"]
        assert status == {"pass": 0, "fail": 1, "tripped": 3}[verdict]


def suite_of(file: Path) -> dict[str, str]:
    """Test cases, with what is wrong with them."""
    (suite,) = junitparser.JUnitXml.fromfile(str(file))
    return {case.name: "".join(outcome.message for outcome in case.result) for case in suite}


def step_source(begin_ns: int = 0, phase: float = 0.0, faults: int = 0) -> made_recording.MadeSource:
    """A live drive: 0 N·m, then 20 N·m from 0.5 s on within 5 ms, ±1 N·m about it; 1.1 Wb."""
    rows = np.zeros(1500, group_of(MAIN).dtype)
    rows["t_ns"] = begin_ns + np.rint((np.arange(len(rows)) + phase) * 1e6)
    t_s = (np.arange(len(rows)) + phase) * 1e-3 - 0.5
    rows["torque_requested_nm"] = rows["torque_reference_nm"] = np.where(t_s >= 0, 20.0, 0.0)
    rows["torque_mean_nm"] = np.clip(t_s / 0.005, 0, 1) * 20.0
    rows["torque_min_nm"], rows["torque_max_nm"] = rows["torque_mean_nm"] - 1, rows["torque_mean_nm"] + 1
    for part in ("mean", "min", "max"):
        rows[f"flux_{part}_wb"] = 1.1
    rows["current_max_a"], rows["i_a_a"], rows["state"], rows["periods"] = 15.0, 14.0, 4, 40
    states = np.zeros(2, group_of(STATE).dtype)
    states["t_ns"], states["first_fault"] = [begin_ns, begin_ns + 10**9], [-1, 9 if faults else -1]
    states["faults_latched"] = [0, faults]
    return made_recording.MadeSource({MAIN: rows, STATE: states}, [group_of(MAIN), group_of(STATE)])


LIMITS = """
torque_bias_nm = { min = -0.5, max = 0.5 }
torque_ripple_pp_nm = { max = 2.1 }
response_time_ms = { max = 8 }
flux_mean_wb = { min = 1.05, max = 1.15 }
peak_current_a = { min = 13, max = 16 }
"""


def scenario_file(path: Path, limits: str = LIMITS, expect_line: str = "") -> Path:
    text = (SCENARIOS / "constant_torque.toml").read_text().split("[profile.torque_nm]")[0]
    text = text.replace('"../machines', f'"{ROOT}/configs/machines')
    text += '[profile.torque_nm]\nshape = "steps"\npoints = [[0, 0], [0.5, 20]]\n'
    text += f"[metrics]\nwindow_from_s = 0.6\nwindow_to_s = 1.2\nstep_s = 0.5\n[expect]\n{expect_line}{limits}"
    path.write_text(text)
    return path


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("phase", [0.0, 0.4])
def test_a_live_recording_is_aligned_with_the_scenario(
    suffix: str, phase: float, tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    """A recording begins anywhere, on any clock. Without the trigger the windows lie elsewhere."""
    path = tmp_path / f"live{suffix}"
    made_recording.write(step_source(7_123_456_789, phase), path)
    scenario = scenario_file(tmp_path / "step.toml")
    trigger = ["--align", "rise torque_reference_nm 10"]
    assert expect.main([str(scenario), str(path), *trigger]) == 0
    assert "constant_torque: pass" in capsys.readouterr().out
    # The same step is at 0.2 s of a scenario: --at says so, and its window is covered there.
    assert expect.main([str(scenario), str(path), *trigger, "--at", "0.2", "--set", "metrics.step_s=0"]) == 1
    cases = {
        "torque_bias_nm.max=-0.1": 1,
        "flux_mean_wb.max=1.09": 1,
        "response_time_ms.max=3": 1,
        "peak_current_a.min=15.5": 1,
    }
    for setting, status in cases.items():
        assert expect.main([str(scenario), str(path), *trigger, "--set", f"expect.{setting}"]) == status, setting


def test_what_the_recording_leaves_open_does_not_pass(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    made_recording.write(step_source(), tmp_path / "live.h5")
    trigger = ["--align", "rise torque_reference_nm 10", "--junit", str(tmp_path / "j.xml")]
    for limit in (
        "switching_frequency_hz = { max = 1e5 }",
        "peak_current_a = { max = 14.5 }",
        "current_thd_percent.max = 99",
    ):
        scenario = scenario_file(tmp_path / "step.toml", limit)
        assert expect.main([str(scenario), str(tmp_path / "live.h5"), *trigger]) == 1
        assert "OPEN" in capsys.readouterr().out
        assert any("which leaves it open" in said for said in suite_of(tmp_path / "j.xml").values())
    # A hole in the recording leaves the window open, one before it does not.
    for begin, status in ((900, 1), (300, 0)):
        source = step_source()
        source._blocks[MAIN] = np.delete(source._blocks[MAIN], range(begin, begin + 5))
        made_recording.write(source, tmp_path / "hole.h5")
        scenario = scenario_file(tmp_path / "step.toml", "torque_bias_nm = { min = -0.5, max = 0.5 }")
        assert expect.main([str(scenario), str(tmp_path / "hole.h5"), *trigger]) == status
    # So does a recording that ends within the window.
    source._blocks[MAIN] = step_source()._blocks[MAIN][:1000]
    made_recording.write(source, tmp_path / "short.h5")
    assert expect.main([str(scenario), str(tmp_path / "short.h5"), *trigger]) == 1


def without(source: made_recording.MadeSource, *names: str) -> made_recording.MadeSource:
    """The same recording, whose telemetry lacks signals."""
    kept = [name for name in source._blocks[MAIN].dtype.names if name not in names]
    columns = tuple(column for column in source.groups[MAIN].columns if column.name in kept)
    group = dataclasses.replace(source.groups[MAIN], columns=columns)
    blocks = {**source._blocks, MAIN: source._blocks[MAIN][kept].astype(group.dtype)}
    return made_recording.MadeSource(blocks, [group, source.groups[STATE]])


def test_what_the_recording_lacks_is_named(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    recordings = {name: step_source() for name in ("whole", "lacking")}
    recordings["lacking"] = without(recordings["lacking"], "flux_min_wb", "torque_mean_nm", "torque_max_nm")
    for name, source in recordings.items():
        made_recording.write(source, tmp_path / f"{name}.h5")
    words = ["--align", "rise torque_reference_nm 10", "--junit", str(tmp_path / "j.xml")]
    here = "sextant-mil alone has it"
    for limit, said in {
        "flux_min_wb = { min = 1 }": "which has no flux_min_wb",
        "flux_max_wb = { max = 1.2 }": "",
        "torque_bias_nm = { max = 1 }": "which has no torque_mean_nm and no torque_max_nm",
        "switching_frequency_hz = { max = 1e5 }": here,
        "energy_shaft_j = { min = 0 }": here,
        "winding_temperature_c = { max = 155 }": here,
    }.items():
        scenario = scenario_file(tmp_path / "step.toml", limit)
        for name in recordings:
            is_told = said == here or (said != "" and name == "lacking")
            assert expect.main([str(scenario), str(tmp_path / f"{name}.h5"), *words]) == (1 if is_told else 0), limit
            text = " ".join(suite_of(tmp_path / "j.xml").values())
            assert (said in text and "not in this recording" in text) if is_told else "recording" not in text, text
            assert ("not in this recording" in capsys.readouterr().out) == is_told


@pytest.mark.filterwarnings("error")
def test_the_bounds_of_a_metric_are_made_of_the_signals_that_it_names(tmp_path: Path) -> None:
    """Without one of them there is a bound less, without another signal the bounds are the same."""
    assert set(COLUMNS) == {*WINDOWED, *WHOLE}
    window = Window(0.6003, 1.2004)  # cuts rows, of which then the extremes count

    def found(source: made_recording.MadeSource, metric: str) -> tuple[Bounds, str]:
        made_recording.write(source, tmp_path / "rows.h5")
        rows = rows_of(SignalFile(tmp_path / "rows.h5"), 0.0)
        return bounds(metric, rows, window, 0.5, 0.0, 1.5), absence(metric, rows)

    required = "torque_min_nm"  # without which it is no telemetry
    for metric, columns in COLUMNS.items():
        whole, nothing = found(step_source(), metric)
        assert nothing == ""
        assert math.isfinite(whole.high)
        for name in {name for names in COLUMNS.values() for name in names} - {required}:
            lacking, said = found(without(step_source(), name), metric)
            assert said == (f"not in this recording, which has no {name}" if name in columns else ""), metric
            assert (lacking == whole) == (name not in columns), (metric, name)


def test_faults_of_a_live_recording(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    from sextant_py.drive_view import fault_names

    (name,) = fault_names(1 << 9)
    made_recording.write(step_source(faults=1 << 9), tmp_path / "live.h5")
    trigger = ["--align", "rise torque_reference_nm 10"]
    limit = "flux_mean_wb.max = 1.2"
    for line, status in (
        ("", 3),
        (f'fault = "{name}"\n', 0),
        (f'fault = "{name}"\nfault_to_s = 1.01\n', 0),
        (f'fault = "{name}"\nfault_to_s = 0.9\n', 3),
        ('fault = "WATCHDOG"\n', 3),
    ):
        scenario = scenario_file(tmp_path / "step.toml", limit, line)
        assert expect.main([str(scenario), str(tmp_path / "live.h5"), *trigger]) == status, line
        assert f"fault {name} at 1.000000 s" in capsys.readouterr().out
    made_recording.write(step_source(), tmp_path / "none.h5")
    scenario = scenario_file(tmp_path / "step.toml", limit, f'fault = "{name}"\n')
    assert expect.main([str(scenario), str(tmp_path / "none.h5"), *trigger]) == 1


def test_a_run_in_virtual_time(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    """Its telemetry has the state alone, so a fault has no name: it trips, and an expected one is open. It has every
    control period, the first ones too, so that the peak current is known."""
    (tmp_path / "profile.csv").write_text("time_s,torque_nm\n0,0\n0.5,0\n0.5001,20\n1.2,20\n1.2001,0\n1.4,0\n")
    scenario = scenario_file(
        tmp_path / "step.toml",
        "torque_bias_nm = { min = -2, max = 2 }\nresponse_time_ms.max = 10\npeak_current_a.max = 250",
    )
    trigger = ["--align", "rise torque_reference_nm 10"]
    for settings, statuses in (([], (0, 1)), (["--set", "protection.over_speed_rad_s=15"], (3, 1))):
        command = [program("sextant-ecu"), ROOT / "configs" / "ecu.toml", "--virtual-time", "--profile"]
        command += [tmp_path / "profile.csv", "--telemetry-out", tmp_path / "run.h5", *settings]
        done = subprocess.run(command, capture_output=True, text=True)
        assert done.returncode == (3 if settings else 0), done.stderr
        assert expect.main([str(scenario), str(tmp_path / "run.h5"), *trigger]) == statuses[0], capsys.readouterr().out
        fault = ["--set", 'expect.fault="OVER_SPEED"']
        assert expect.main([str(scenario), str(tmp_path / "run.h5"), *trigger, *fault]) == statuses[1]


def test_nothing_expected_and_bad_input(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    made_recording.write(step_source(), tmp_path / "live.h5")
    live, nothing = str(tmp_path / "live.h5"), str(scenario_file(tmp_path / "nothing.toml", ""))
    assert expect.main([nothing, live]) == 0
    assert expect.main([nothing, live, "--require-expectations"]) == 9
    (tmp_path / "text.h5").write_text("x")
    (tmp_path / "dir").mkdir()
    capsys.readouterr()
    for words, said in (
        ([nothing, str(tmp_path / "none.h5")], "none.h5 does not exist."),
        ([nothing, str(tmp_path / "text.h5")], "text.h5"),
        ([nothing, str(tmp_path / "dir")], "holds no trace.h5"),
        ([str(tmp_path / "none.toml"), live], "none.toml"),
        ([nothing, live, "--set", "expect.tork.max=1"], "unknown key"),
        ([nothing, live, "--align", "rise tork 1"], 'no signal "tork"'),
        ([nothing, live, "--at", "1"], "--at is the instant of --align"),
        ([nothing, live, "--junit", str(tmp_path / "live.h5" / "x.xml")], "cannot be written"),
    ):
        assert status_or_refusal("expect", partial(expect.main, words)) == 2, words
        refused = capsys.readouterr().err
        assert said in refused, refused
        assert refused.startswith("expect: "), refused
        assert refused.count("\n") == 1, refused


def test_limits_are_included() -> None:
    """As in sextant-mil: a value at its limit holds, one without a value does not."""
    assert Bounds(1.0, 2.0).holds(1.0, 2.0) is True
    assert Bounds(2.0, 2.0).holds(None, 2.0) is True
    assert Bounds(2.0, 2.0).holds(2.0, None) is True
    assert Bounds(1.0, 2.0).holds(1.5, None) is None
    assert Bounds(1.0, 2.0).holds(2.5, None) is False
    assert Bounds(1.0, 2.0).holds(None, 0.5) is False
    assert Bounds(math.nan, math.nan).holds(None, 9.0) is False
    assert Bounds().holds(None, 9.0) is None
