"""Two runs compared: tolerances, tables, JSON, Markdown and JUnit, and what a bad argument is told."""

import json
import subprocess
from pathlib import Path

import junitparser
import pytest
from sextant_py import compare
from sextant_py.comparison import IGNORED, OUT, SAME, Tolerance, Tolerances
from sextant_py.comparison import compare as compare_runs
from sextant_py.errors import UserError, status_or_refusal
from sextant_py.paths import ROOT
from sextant_py.recording.formats import SUFFIXES

METRICS = {"ripple_nm": 10.0, "bias_nm": -0.5, "peak_a": 80.0, "thd_percent": None, "wall_s": 0.3}


def write(directory: Path, scenario: str = "step", verdict: str = "pass", **metrics: float | None) -> Path:
    directory.mkdir(parents=True, exist_ok=True)
    summary = {"scenario": scenario, "verdict": verdict, "metrics": METRICS | metrics, "expect": []}
    (directory / "summary.json").write_text(json.dumps(summary), encoding="utf-8")
    return directory


@pytest.mark.parametrize(
    ("text", "first", "second", "allowed"),
    [
        ("1%", 100.0, 101.0, True),
        ("1%", 100.0, 101.1, False),
        ("1%", -100.0, -99.0, True),
        ("1%", 0.0, 1e-12, False),
        ("0.5", 0.0, 0.5, True),
        ("0.5", -0.5, 0.01, False),
        ("0", 3.0, 3.0, True),
        ("ignore", 1.0, 1e9, True),
    ],
)
def test_tolerances(text: str, first: float, second: float, allowed: bool) -> None:
    assert Tolerance.parse(text, "here").allows(first, second) == allowed


@pytest.mark.parametrize("text", ["", "x", "-1", "nan", "inf%", "1 %%"])
def test_bad_tolerances(text: str) -> None:
    with pytest.raises(UserError, match="here: expected a tolerance such as 1%"):
        Tolerance.parse(text, "here")


def run(*words: object, capsys: pytest.CaptureFixture) -> tuple[int, str, str]:
    status = status_or_refusal("compare", lambda: compare.main([str(word) for word in words]))
    said = capsys.readouterr()
    return status, said.out, said.err


def test_runs_that_agree(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    a, b = write(tmp_path / "a"), write(tmp_path / "b", ripple_nm=10.09, wall_s=99.0)
    status, said, _ = run(a, b / "summary.json", capsys=capsys)
    assert status == 0
    assert "5 values agree within their tolerances" in said
    assert "\x1b" not in said  # no colour where there is no terminal


def test_a_metric_out_of_tolerance_is_named(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    a, b = write(tmp_path / "a"), write(tmp_path / "b", ripple_nm=10.2, peak_a=100.0)
    assert run(a, b, capsys=capsys)[0] == 1
    status, said, _ = run(a, b, "--tolerance", "ripple_nm=0.3", "--json", capsys=capsys)
    assert status == 1
    found = json.loads(said)
    rows = {row["metric"]: row for row in found["rows"]}
    assert not found["equal"]
    assert {name: row["result"] for name, row in rows.items()} == {
        "verdict": SAME, "ripple_nm": SAME, "bias_nm": SAME, "peak_a": OUT, "thd_percent": SAME, "wall_s": IGNORED,
    }  # fmt: skip
    assert (rows["peak_a"]["difference"], rows["peak_a"]["relative"]) == (20.0, 0.25)
    assert run(a, b, "--tolerance", "default=30%", capsys=capsys)[0] == 0


def test_a_missing_value_and_another_verdict_are_out(tmp_path: Path) -> None:
    first = {"step": json.loads((write(tmp_path / "a") / "summary.json").read_text())}
    second = {"step": json.loads((write(tmp_path / "b", verdict="fail", bias_nm=None) / "summary.json").read_text())}
    del second["step"]["metrics"]["peak_a"]
    rows = {row.metric: row for row in compare_runs(first, second, Tolerances())}
    assert [name for name, row in rows.items() if row.result == OUT] == ["verdict", "bias_nm", "peak_a"]
    assert rows["verdict"].reason == "fail instead of pass"
    assert rows["peak_a"].reason == "only the first run has this metric"


def faulted(directory: Path, *faults: tuple[str, float], **metrics: float) -> Path:
    file = write(directory, **metrics) / "summary.json"
    latched = [{"fault": name, "t_s": t_s} for name, t_s in faults]
    file.write_text(json.dumps(json.loads(file.read_text()) | {"faults": latched}), encoding="utf-8")
    return directory


def test_faults_and_their_times_belong_to_the_comparison(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    a = faulted(tmp_path / "a", ("OVER_CURRENT", 0.25), ("DC_OVER_VOLTAGE", 0.3))
    cases = {
        "same": ([("OVER_CURRENT", 0.25), ("DC_OVER_VOLTAGE", 0.3)], []),
        "close": ([("OVER_CURRENT", 0.2509), ("DC_OVER_VOLTAGE", 0.3)], []),
        "late": ([("OVER_CURRENT", 0.25), ("DC_OVER_VOLTAGE", 0.302)], ["fault DC_OVER_VOLTAGE"]),
        "other": ([("OVER_CURRENT", 0.25), ("OVER_SPEED", 0.3)], ["faults"]),
        "order": ([("DC_OVER_VOLTAGE", 0.25), ("OVER_CURRENT", 0.3)], ["faults"]),
        "none": ([], ["faults"]),
    }
    for name, (faults, out) in cases.items():
        b = faulted(tmp_path / name, *faults)
        status, said, _ = run(a, b, "--json", capsys=capsys)
        rows = json.loads(said)["rows"]
        assert ([row["metric"] for row in rows if row["result"] == OUT], status) == (out, int(bool(out))), name
    assert run(a, tmp_path / "late", "--tolerance", "fault_s=0.005", capsys=capsys)[0] == 0


def test_a_shift_in_time_points_to_align(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    a = faulted(tmp_path / "a", ("OVER_CURRENT", 0.1), ("DRIVE_STALL", 0.7))
    shifted = faulted(tmp_path / "b", ("OVER_CURRENT", 0.15), ("DRIVE_STALL", 0.75))
    other = faulted(tmp_path / "c", ("OVER_CURRENT", 0.1), ("DRIVE_STALL", 0.8))
    for words in ((), ("--json",), ("--markdown",)):
        status, said, hint = run(a, shifted, *words, capsys=capsys)
        assert status == 1
        assert hint.startswith("compare: every fault of B comes 0.05 s later than in A: --align TRIGGER compares")
        assert "--align" not in said
    assert "comes 0.05 s earlier" in run(shifted, a, capsys=capsys)[2]
    for same in (a, other):
        assert run(a, same, capsys=capsys)[2] == ""  # nothing is shifted, or not by one time


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_recordings_are_compared_by_align(tmp_path: Path, suffix: str, capsys: pytest.CaptureFixture) -> None:
    file = tmp_path / f"run{suffix}"
    file.write_bytes(b"\x89HDF")
    status, _, said = run(file, write(tmp_path / "b"), capsys=capsys)
    assert status == 2
    assert f"run{suffix} is a recording, not a summary: --align TRIGGER compares recordings" in said


def test_near_zero_a_share_is_of_the_scale_of_the_unit(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    """A bias of 1e-9 N·m beside a ripple of 10 N·m counts as 0.1 N·m, a hundredth of it: 1 % of that is 1 mN·m."""
    a = write(tmp_path / "a", bias_nm=1e-9, ripple_nm=10.0)
    for bias, status in ((-0.9e-3, 0), (1.1e-3, 1)):
        assert run(a, write(tmp_path / "b", bias_nm=bias), capsys=capsys)[0] == status
    # What is not near zero keeps its own share, whatever the scale.
    assert run(a, write(tmp_path / "b", bias_nm=1e-9, ripple_nm=10.11), capsys=capsys)[0] == 1
    assert run(a, write(tmp_path / "b", bias_nm=1.1e-3), "--tolerance", "bias_nm=0", capsys=capsys)[0] == 1


def test_tolerances_from_a_file(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    a, b = write(tmp_path / "a"), write(tmp_path / "b", ripple_nm=10.4, bias_nm=-0.45, wall_s=0.31)
    file = tmp_path / "limits.toml"
    file.write_text('default = "5%"\n[metrics]\nbias_nm = 0.1\n')
    assert run(a, b, "--tolerances", file, capsys=capsys)[0] == 0
    assert run(a, b, "--tolerances", file, "--tolerance", "wall_s=1%", capsys=capsys)[0] == 1  # then it is compared


def test_directories_of_runs_are_matched_by_scenario(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    for name in ("one", "two"):
        write(tmp_path / "a" / name, name)
        write(tmp_path / "b" / name, name)
    assert run(tmp_path / "a", tmp_path / "b", capsys=capsys)[0] == 0
    write(tmp_path / "b" / "three", "three")
    status, said, _ = run(tmp_path / "a", tmp_path / "b", "--markdown", capsys=capsys)
    assert status == 1
    assert "### three" in said
    assert "| **verdict** | **-** | **pass** |" in said


def test_markdown_is_a_table_of_equal_rows(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    a, b = write(tmp_path / "a"), write(tmp_path / "b", peak_a=90.0)
    _, said, _ = run(a, b, "--markdown", capsys=capsys)
    rows = [line for line in said.splitlines() if line.startswith("|")]
    assert len(rows) == 2 + 1 + len(METRICS)
    assert {line.count("|") for line in rows} == {8}
    assert "| **peak_a** | **80** | **90** | **+10** | **+12.50%** | **1%** | **OUT** |" in rows


def test_the_junit_file_is_read_by_an_independent_parser(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    """lxml is another parser than the one of the writer."""
    from lxml import etree

    a, b = write(tmp_path / "a", 'a "<&>" b'), write(tmp_path / "b", 'a "<&>" b', peak_a=90.0)
    file = tmp_path / "deep" / "compare.xml"
    assert run(a, b, "--junit", file, capsys=capsys)[0] == 1
    (suite,) = etree.parse(file).getroot()
    assert suite.get("name") == 'a "<&>" b'
    assert (suite.get("tests"), suite.get("failures"), suite.get("skipped")) == ("6", "1", "1")
    (failure,) = suite.findall("testcase/failure")
    assert failure.getparent().get("name") == "peak_a"
    assert failure.get("message") == "90 instead of 80: tolerance 1%"
    assert sum(len(list(found)) for found in junitparser.JUnitXml.fromfile(str(file))) == 6


def test_bad_input_has_status_2(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    a = write(tmp_path / "a")
    (tmp_path / "text").write_text("no JSON")
    (tmp_path / "bad.toml").write_text("nonsense = 1\n")
    for words, said in (
        ((a, tmp_path / "none"), "none does not exist."),
        ((a, tmp_path), None),
        ((a, tmp_path / "text"), "text is no summary of a run; sextant-mil writes one to summary.json."),
        ((a, a, "--tolerance", "nonsense"), '--tolerance: expected NAME=TOLERANCE, got "nonsense".'),
        ((a, a, "--tolerance", "no_such_metric=1"), 'no run has a metric "no_such_metric"'),
        ((a, a, "--tolerances", tmp_path / "bad.toml"), "nonsense: unknown key; known here are default, metrics."),
        ((a, a, "--junit", a / "summary.json" / "x.xml"), "cannot be written"),
    ):
        status, _, refused = run(*words, capsys=capsys)
        if said is None:
            assert status == 0  # the directory that holds a
            continue
        assert (status, said in refused, refused.count("\n")) == (2, True, 1), refused
    found = subprocess.run([ROOT / "scripts" / "compare", a], capture_output=True, text=True)
    assert found.returncode == 2
