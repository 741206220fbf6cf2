"""sextant-mil --junit and --summary-markdown against its summary.json, read by parsers of others."""

import json
import re
import signal
import subprocess
import time
from pathlib import Path

import junitparser
import pytest
from markdown_it import MarkdownIt
from programs import program
from sextant_py.paths import ROOT

SCENARIOS = ROOT / "configs" / "scenarios"
# Long enough for the shipped windows of the metrics, and fast.
QUICK = ("--set", "plant.integrator=fixed", "--no-trace")


def run(*words: object) -> subprocess.CompletedProcess:
    command = [program("sextant-mil"), *map(str, words)]
    return subprocess.run(command, capture_output=True, text=True, timeout=300, stdin=subprocess.DEVNULL)


def suites(file: Path) -> dict[str, junitparser.TestSuite]:
    return {suite.name: suite for suite in junitparser.JUnitXml.fromfile(str(file))}


def failed(suite: junitparser.TestSuite) -> dict[str, str]:
    """Messages by test case."""
    return {case.name: result.message for case in suite for result in case.result}


def check_counts(file: Path) -> None:
    """The counts of a JUnit file are those of its elements, and all of its elements are known ones."""
    xml = junitparser.JUnitXml.fromfile(str(file))
    kinds = {"failures": junitparser.Failure, "errors": junitparser.Error, "skipped": junitparser.Skipped}
    totals = dict.fromkeys((*kinds, "tests"), 0)
    for suite in xml:
        cases = list(suite)
        assert suite.tests == len(cases) > 0
        assert len({case.name for case in cases}) == len(cases)
        assert {case.classname for case in cases} == {suite.name}
        for name, kind in kinds.items():
            count = sum(isinstance(result, kind) for case in cases for result in case.result)
            assert getattr(suite, name) == count
            totals[name] += count
        totals["tests"] += len(cases)
    assert {name: getattr(xml, name) for name in totals} == totals


def test_every_limit_is_a_test_case(tmp_path: Path) -> None:
    file, out = tmp_path / "new" / "junit.xml", tmp_path / "out"
    scenarios = [SCENARIOS / "constant_torque.toml", SCENARIOS / "reversal.toml"]
    done = run(*scenarios, *QUICK, "--out", out, "--junit", file)
    assert done.returncode == 0, done.stderr
    check_counts(file)
    found = suites(file)
    assert list(found) == ["constant_torque", "reversal"]
    for name, suite in found.items():
        summary = json.loads((out / name / "summary.json").read_text())
        cases = [case.name for case in suite]
        assert cases[0] == "verdict"
        assert [case.split(",")[0].split(" ")[0] for case in cases[1:]] == [row["metric"] for row in summary["expect"]]
        assert failed(suite) == {}
        assert suite.time == pytest.approx(summary["metrics"]["wall_s"], abs=1e-6)
        assert {item.name: item.value for item in suite.properties()}["version"] == summary["version"]


def test_a_limit_that_does_not_hold_is_a_failure_with_value_and_limit(tmp_path: Path) -> None:
    file, out = tmp_path / "junit.xml", tmp_path / "out"
    window = "expect.window=[{from_s=0.3,to_s=0.5,flux_mean_wb={max=0.5}}]"
    settings = ("--set", "expect.torque_ripple_pp_nm.max=2", "--set", window)
    done = run(SCENARIOS / "constant_torque.toml", *QUICK, *settings, "--out", out, "--junit", file)
    assert done.returncode == 1, done.stderr
    check_counts(file)
    (suite,) = suites(file).values()
    rows = json.loads((out / "summary.json").read_text())["expect"]
    values = {row["metric"]: row["value"] for row in rows if not row["pass"]}
    assert set(values) == {"torque_ripple_pp_nm", "flux_mean_wb"}
    messages = failed(suite)
    assert messages == {
        "verdict": "a limit does not hold",
        "torque_ripple_pp_nm ≤ 2": f"torque_ripple_pp_nm is {values['torque_ripple_pp_nm']:.5g} N·m, expected ≤ 2 N·m",
        "flux_mean_wb, 0.3 s to 0.5 s ≤ 0.5": f"flux_mean_wb is {values['flux_mean_wb']:.5g} Wb, expected ≤ 0.5 Wb",
    }


def test_a_trip_is_an_error_and_an_expected_one_a_test_case(tmp_path: Path) -> None:
    file = tmp_path / "junit.xml"
    trip = ("--set", "protection.over_current_a=50", "--out", tmp_path / "out", "--junit", file)
    assert run(SCENARIOS / "constant_torque.toml", *QUICK, *trip).returncode == 1
    check_counts(file)
    (suite,) = suites(file).values()
    (result,) = next(case for case in suite if case.name == "verdict").result
    assert isinstance(result, junitparser.Error)
    assert (result.type, "the drive tripped with OVER_CURRENT at" in result.message) == ("tripped", True)
    expected = ("--set", 'expect.fault="COMMAND_LOST"')
    run(SCENARIOS / "constant_torque.toml", *QUICK, *expected, *trip)
    (suite,) = suites(file).values()
    assert re.match(r"OVER_CURRENT came first, at 0\.\d+ s$", failed(suite)["fault COMMAND_LOST, 0 s to the end"])


def test_names_are_escaped(tmp_path: Path) -> None:
    file, markdown = tmp_path / "junit.xml", tmp_path / "summary.md"
    name = 'a "b" <c> & d | *e* `f` \\u0001 ü'
    settings = ("--set", f'name="{name}"'.replace('"b"', '\\"b\\"'), "--out", tmp_path / "out")
    done = run(SCENARIOS / "constant_torque.toml", *QUICK, *settings, "--junit", file, "--summary-markdown", markdown)
    assert done.returncode == 0, done.stderr
    (suite,) = suites(file).values()
    assert suite.name == 'a "b" <c> & d | *e* `f` ? ü'
    heading = MarkdownIt("commonmark").parse(markdown.read_text(encoding="utf-8"))[1]
    assert {child.type for child in heading.children} <= {"text", "text_special"}  # no markup
    assert "".join(child.content for child in heading.children).startswith('a "b" <c> & d | *e* `f`')


def test_the_markdown_is_appended_and_has_the_limits(tmp_path: Path) -> None:
    markdown = tmp_path / "summary.md"
    markdown.write_text("# Before\n\n")
    settings = ("--set", "expect.torque_ripple_pp_nm.max=2", "--out", tmp_path / "out", "--summary-markdown", markdown)
    assert run(SCENARIOS / "constant_torque.toml", *QUICK, *settings).returncode == 1
    text = markdown.read_text(encoding="utf-8")
    assert text.startswith("# Before\n\n### constant\\_torque: fail\n")
    tokens = MarkdownIt("commonmark").enable("table").parse(text)
    cells = [tokens[k + 1].content for k, token in enumerate(tokens) if token.type == "td_open"]
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    rows = [cells[k : k + 5] for k in range(0, 5 * len(summary["expect"]), 5)]
    assert [row[0] for row in rows] == [f"`{row['metric']}`" for row in summary["expect"]]
    assert [row[4] for row in rows] == ["pass" if row["pass"] else "**FAIL**" for row in summary["expect"]]
    limited = {row["metric"] for row in summary["expect"]}
    assert all((f"| `{metric}` |" in text) for metric in set(summary["metrics"]) | limited)


@pytest.mark.parametrize("option", ["--junit", "--summary-markdown"])
def test_a_report_that_cannot_be_written_ends_the_program_before_the_run(tmp_path: Path, option: str) -> None:
    (tmp_path / "file").write_text("")
    done = run(SCENARIOS / "constant_torque.toml", *QUICK, "--out", tmp_path / "out", option, tmp_path / "file" / "x")
    assert done.returncode == 2
    assert re.match(r"sextant-mil: \S+/file/x: cannot write the .+: Not a directory\n$", done.stderr)
    assert not (tmp_path / "out").exists()


def test_an_interrupted_run_is_an_error_of_its_suite(tmp_path: Path) -> None:
    file, out = tmp_path / "junit.xml", tmp_path / "out"
    words = [SCENARIOS / "constant_torque.toml", "--set", "duration_s=10000", "--out", out, "--junit", file]
    with subprocess.Popen(
        [program("sextant-mil"), *map(str, words)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    ) as process:
        deadline_s = time.monotonic() + 60
        while not (out / "trace.h5").is_file():
            assert process.poll() is None and time.monotonic() < deadline_s
            time.sleep(0.02)
        assert suites(file) == {}  # the file is whole at any time
        process.send_signal(signal.SIGTERM)
        assert process.wait(60) == 128 + signal.SIGTERM
    check_counts(file)
    (suite,) = suites(file).values()
    assert suite.errors == 1
    assert failed(suite)["verdict"].startswith("interrupted at")
