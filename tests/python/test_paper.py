"""The report on the paper: its reckoning on made-up traces, its numbers, and that the committed page is theirs."""

import json
import math
import stat
import subprocess
import sys
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from sextant_py import mil_program
from sextant_py.errors import UserError
from sextant_py.paths import ROOT
from sextant_py.plots import sheets
from sextant_py.plots.trace import Trace
from studies.paper import (
    check_paper,
    paper_report,
)
from studies.paper import cycle as paper_cycle
from studies.paper import defaults as paper_defaults
from studies.paper import figures as paper_figures
from studies.paper import rise as paper_rise
from studies.paper import steady as paper_steady
from studies.paper import steps as paper_steps
from studies.paper.lab import SCENARIOS, Lab
from studies.paper.numbers import Number, Numbers, differences
from studies.paper.page import defaults_table, render

COMMITTED = ROOT / "docs" / "paper"
FILES = sorted((ROOT / SCENARIOS).glob("*.toml"))


def trace_of(
    reference: np.ndarray, low: np.ndarray, high: np.ndarray, step_s: float = 1e-3, **more: np.ndarray
) -> Trace:
    t_s = step_s * np.arange(1, len(reference) + 1)
    values = {"torque_reference_nm": reference, "torque_min_nm": low, "torque_max_nm": high}
    return Trace(t_s, values | {"current_max_a": np.zeros(len(t_s))} | more)


def one(value: float, tolerance: float | None = 0.1) -> Numbers:
    return Numbers({"x": Number(value, "N·m", tolerance, "made up", "none")})


@pytest.mark.parametrize(("now", "found"), [(1.0, 0), (1.09, 0), (0.91, 0), (1.11, 1), (0.89, 1), (math.nan, 1)])
def test_a_number_out_of_tolerance_is_found(now: float, found: int) -> None:
    assert len(differences(one(1.0), one(now))) == found


def test_numbers_that_are_not_compared() -> None:
    assert differences(one(1.0, None), one(7.0, None)) == []
    assert differences(one(math.nan), one(math.nan)) == []
    assert len(differences(one(math.nan), one(1.0))) == 1
    assert len(differences(Numbers(), one(1.0))) == 1


def test_tolerance_below_zero_is_a_share() -> None:
    numbers = Numbers()
    numbers.add("x", -200.0, "Hz", -0.01, "made up", "none")
    assert numbers.entries["x"].tolerance == pytest.approx(2.0)
    with pytest.raises(ValueError, match="there twice"):
        numbers.add("x", 1.0, "Hz", 1.0, "again", "none")


def test_numbers_survive_their_file(tmp_path: Path) -> None:
    numbers = one(1 / 3)
    numbers.add("none", math.nan, "ms", 0.1, "never", "none")
    numbers.save(tmp_path / "n.json")
    again = Numbers.load(tmp_path / "n.json")
    assert again["x"] == pytest.approx(1 / 3, rel=1e-5)
    assert math.isnan(again["none"])
    assert differences(again, numbers) == []


@pytest.mark.parametrize("content", ["no JSON", "[1, 2]", '{"x": 1}', '{"x": {"value": 1, "unit": "A"}}'])
def test_bad_number_files(tmp_path: Path, content: str) -> None:
    (tmp_path / "n.json").write_text(content)
    with pytest.raises(UserError, match="holds no results of scripts/paper_report"):
        Numbers.load(tmp_path / "n.json")
    with pytest.raises(UserError, match=r"none\.json is missing; scripts/paper_report writes it"):
        Numbers.load(tmp_path / "none.json")


def test_error_of_a_row_counts_from_a_moving_reference() -> None:
    reference = np.array([0.0, 1.0, 2.0, 2.0])
    low, high = trace_of(reference, reference - 0.5, reference + 0.25).error
    assert low == pytest.approx([-0.5, -0.5, -0.5, -0.5])
    assert high == pytest.approx([0.25, 1.25, 1.25, 0.25])


def test_excursions_are_counted_and_sized() -> None:
    reference = np.zeros(1000)
    low, high = np.full(1000, -0.9), np.full(1000, 0.9)
    low[[200, 201, 260]] = (-1.2, -1.4, -1.1)  # one: less than 0.1 s apart
    high[600] = 1.3
    low[10] = -15.0  # the start does not count
    high[800] = 0.92  # inside what is tolerated
    current = np.full(1000, 10.0)
    current[650] = 33.0
    found = paper_cycle.excursions(trace_of(reference, low, high, current_max_a=current), 0.918, 0.918)
    assert [(round(e.begin_s, 3), round(e.end_s, 3)) for e in found] == [(0.201, 0.261), (0.601, 0.601)]
    assert [e.beyond_nm for e in found] == pytest.approx([1.4 - 0.918, 1.3 - 0.918])
    assert [e.current_a for e in found] == [33.0, 33.0]
    assert paper_cycle.excursions(trace_of(reference, 0 * low, 0 * high), 0.1, 0.1) == []


def test_surges_are_counted_apart() -> None:
    current = np.full(1000, 10.0)
    current[[20, 300, 350, 700]] = 40.0
    flat = np.zeros(1000)
    assert paper_cycle.surges(trace_of(flat, flat, flat, current_max_a=current)) == 2
    assert paper_cycle.surges(trace_of(flat, flat, flat)) == 0


def test_dead_time_is_that_without_torque() -> None:
    count = 20_000
    torque = np.ones(count)
    begin = round((paper_cycle.FIRST_S[0] + 2) / 3e-3)
    torque[begin : begin + 100] = 0.01
    trace = trace_of(torque, torque, torque, 3e-3)
    assert paper_cycle.dead_time_s(trace) == pytest.approx(0.3)


def test_answers_of_a_ramp() -> None:
    reference = np.linspace(0.01, 1, 100)
    torque = np.where(np.arange(100) < 50, 0.0, np.linspace(-1.4, 1.6, 100))
    begins, meets = paper_rise.answers(trace_of(reference, torque, torque))
    assert begins == pytest.approx(51.0, abs=1.01)
    assert torque[round(meets) - 1] >= reference[round(meets) - 2] - 1e-3
    assert torque[round(meets) - 2] < reference[round(meets) - 3]


def test_crossing_is_bisected() -> None:
    assert paper_steps.crossing(0, 10, lambda x: x < math.pi, 40) == pytest.approx(math.pi)


def test_straight_line_of_a_hyperbola_is_too_high() -> None:
    # f = c/HB: the line between 1/2 and 1 lies (1 + 0.164) 0.918 above it at 0.918.
    assert paper_steady.interpolated(2.0, 1.0) * 0.918 - 1 == pytest.approx(0.0686, abs=1e-4)


def test_weakest_vector_without_torque_is_half_the_voltage() -> None:
    # ψ_r × u sin 150° against the e.m.f. p ω ψ_r ψ_s alone.
    assert paper_steady.weakest_vector_speed(1e-6) == pytest.approx(0.5 * (2 / 3) * 530 / (2 * 1.1), rel=1e-3)
    speeds = [paper_steady.weakest_vector_speed(t) for t in (1, 20, 60, 130)]
    assert speeds == sorted(speeds, reverse=True)


def test_thinning_keeps_peaks() -> None:
    count = 10 * sheets.MAX_POINTS + 7
    low, high = np.zeros(count), np.zeros(count)
    low[12_345], high[20_001] = -7.0, 9.0
    t_s, least, most = sheets.thinned(trace_of(low, low, high), "torque_min_nm", "torque_max_nm")
    assert len(t_s) == len(least) == len(most) <= sheets.MAX_POINTS
    assert (least.min(), most.max()) == (-7.0, 9.0)


def test_gates_from_the_voltage_that_moved_the_flux() -> None:
    vectors = {1: (1, 0, 0), 2: (1, 1, 0), 3: (0, 1, 0), 4: (0, 1, 1), 5: (0, 0, 1), 6: (1, 0, 1)}
    applied = [1, 0, 2, 0, 3, 4, 0, 5, 6, 0]
    u = [0 if k == 0 else 2 / 3 * 530 * np.exp(1j * np.pi / 3 * (k - 1)) for k in applied]
    psi = np.concatenate(([1.1], 1.1 + 1e-6 * np.cumsum(u)))
    zero = np.zeros(len(psi))
    trace = Trace(
        1e-6 * np.arange(len(psi)),
        {"psi_s_alpha_wb": psi.real, "psi_s_beta_wb": psi.imag, "i_a_a": zero, "i_b_a": zero, "i_c_a": zero},
    )
    states = [tuple(state) for state in paper_figures.gates(trace)[1:]]
    zeros = {1: (0, 0, 0), 3: (1, 1, 1), 6: (1, 1, 1), 9: (1, 1, 1)}
    assert states == [zeros[n] if k == 0 else vectors[k] for n, k in enumerate(applied)]


FAKE = """#!{python}
import json, pathlib, sys
out = pathlib.Path(sys.argv[sys.argv.index("--out") + 1])
if "--set" in sys.argv and "fail=1" in sys.argv:
    sys.exit("sextant-mil: no such key")
out.mkdir(parents=True)
(out / "summary.json").write_text(json.dumps({{"verdict": "pass", "metrics": {{"a": len(sys.argv), "b": None}}}}))
pathlib.Path({log!r}).open("a").write(" ".join(sys.argv[1:]) + "\\n")
"""


@pytest.fixture
def lab(tmp_path: Path):
    program = tmp_path / "sextant-mil"
    program.write_text(FAKE.format(python=sys.executable, log=str(tmp_path / "log")))
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    with Lab(program, 3) as lab:
        yield lab


def test_what_has_run_once_is_not_run_again(lab: Lab, tmp_path: Path) -> None:
    points = [("hb_1", {"duration_s": 0.1 * k}) for k in (1, 2, 1, 1, 2)]
    runs = lab.run_all(points)
    assert runs[0] is runs[2] is runs[3]
    assert runs[1] is runs[4]
    assert runs[0].command == "sextant-mil configs/scenarios/paper/hb_1.toml --set duration_s=0.1"
    assert math.isnan(runs[0]["b"])
    lab.run("hb_1", {"duration_s": 0.1}, trace=True)  # without a trace before
    traced = lab.run("hb_1", {"duration_s": 0.3}, trace=True)
    assert lab.run("hb_1", {"duration_s": 0.3}) is traced
    assert len((tmp_path / "log").read_text().splitlines()) == 4


def test_a_run_that_fails_says_which(lab: Lab) -> None:
    with pytest.raises(UserError, match=r"hb_1.toml --set fail=1 failed: .*no such key"):
        lab.run("hb_1", {"fail": 1})


@pytest.mark.parametrize("name", ["paper_report", "check_paper"])
def test_help_from_any_directory(name: str, tmp_path: Path) -> None:
    found = subprocess.run(
        [ROOT / "scripts" / name, "--help"], cwd=tmp_path, capture_output=True, text=True, timeout=480
    )
    assert (found.returncode, found.stderr) == (0, "")
    assert name in found.stdout.splitlines()[0]


def test_bad_arguments() -> None:
    with pytest.raises(UserError, match=r"--mil: .* is not a program"):
        mil_program.find(Path("/no/such/program"))
    with pytest.raises(SystemExit):
        paper_report.parse_arguments(["--jobs", "0"])


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_scenarios_expect_and_protect(file: Path) -> None:
    content = tomllib.loads(file.read_text(encoding="utf-8"))
    assert content["name"] == file.stem
    assert content["mode"] == "event_exact"
    assert content["expect"]
    assert content["protection"]["over_current_a"] > 0
    assert "ours" in file.read_text(encoding="utf-8").lower() or content["description"].startswith("Negative")


def test_table6_is_the_papers() -> None:
    sweep = tomllib.loads((ROOT / "configs" / "sweeps" / "paper_table6.toml").read_text(encoding="utf-8"))
    upper, lower = (sweep["grid"]["control"]["dtc"][f"torque_band_{side}_nm"] for side in ("upper", "lower"))
    assert sorted((u, lo) for u in upper for lo in lower) == sorted(paper_cycle.FIGURES)
    assert sorted(paper_cycle.FIGURES.values()) == list(range(19, 28))


def test_committed_page_is_that_of_the_committed_numbers() -> None:
    assert check_paper.page_differences(COMMITTED, Numbers.load(paper_report.NUMBERS)) == []


def test_committed_numbers_say_where_they_come_from() -> None:
    content = json.loads((paper_report.NUMBERS).read_text(encoding="utf-8"))
    assert len(content) > 300
    for name, entry in content.items():
        assert entry["command"] and entry["meaning"] and entry["unit"], name


def test_a_changed_number_or_page_is_found(tmp_path: Path) -> None:
    numbers = Numbers.load(paper_report.NUMBERS)
    name = "response/centred/dead/15"
    off = Numbers(numbers.entries | {name: replace(numbers.entries[name], value=4.0)})
    assert len(differences(off, numbers)) == 1
    assert check_paper.self_test(numbers, numbers) == []
    for picture in paper_report.PICTURES:
        (tmp_path / f"{picture}.png").write_bytes(b"")
    (tmp_path / "README.md").write_text(render(off), encoding="utf-8")
    assert len(check_paper.page_differences(tmp_path, numbers)) == 1
    (tmp_path / "response.png").unlink()
    assert len(check_paper.page_differences(tmp_path, numbers)) == 2


def test_defaults_that_a_configuration_switches_off() -> None:
    configuration = """mode = "event_exact"  # how; "sampled" or "event_exact"; default "sampled"
[control]
flux_estimator = "voltage_model"  # a model; one or the other; "hybrid" or "voltage_model"; default "hybrid"
adapts = true  # whether; true or false; default true
[control.dtc]
torque_trim_ms = 0  # time; 0: not trimmed [ms]; a number from 0 to 10000; default derived from machine and link
torque_band_nm = 0.918  # band [N·m]; a number from 0.001 to 100000; default derived from machine and link
error_v = 0  # error [V]; a number from 0 to 1000; default derived from machine and link
limit_ms = 0  # limit; 0: none [ms]; a number from 0 to 1000; default 3
# later =  # not set; default not set
[drive]
magnetise_first = false  # the flux; true or false; default true
idle = 0  # nothing; a number from 0 to 1; default 0
[plant]
measures_angle = false  # the plant's; true or false; default true
"""
    assert paper_defaults.switched_off(configuration) == [
        ("control.flux_estimator", "hybrid", "voltage_model"),
        ("control.dtc.torque_trim_ms", "derived from machine and link", "0"),
        ("control.dtc.limit_ms", "3", "0"),
        ("drive.magnetise_first", "true", "false"),
    ]


def test_a_default_that_is_no_longer_switched_off_is_found() -> None:
    committed = Numbers()
    committed.add(f"{paper_defaults.PREFIX}drive.magnetise_first/true/false", 14, "scenarios", 0.0, "made up", "none")
    assert paper_defaults.gone(committed, committed) == []
    assert len(paper_defaults.gone(committed, Numbers())) == 1
    assert "| `drive.magnetise_first` | true | false | 14 |" in defaults_table(committed)
