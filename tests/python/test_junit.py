"""sextant-mil --junit and --summary-markdown against its summary.json, read by parsers of others."""

import json
import os
import re
import signal
import subprocess
import sys
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
    """Messages by test case that did not pass."""
    return {case.name: result.message for case in suite for result in case.result}


def skipped(suite: junitparser.TestSuite) -> list[str]:
    """Names of the test cases that are skipped."""
    return [case.name for case in suite for result in case.result if isinstance(result, junitparser.Skipped)]


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
    file, markdown, out = tmp_path / "new" / "junit.xml", tmp_path / "newer" / "summary.md", tmp_path / "out"
    scenarios = [SCENARIOS / "constant_torque.toml", SCENARIOS / "reversal.toml"]
    done = run(*scenarios, *QUICK, "--out", out, "--junit", file, "--summary-markdown", markdown)
    assert done.returncode == 0, done.stderr
    assert markdown.read_text(encoding="utf-8").count("\n### ") == 1
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
    assert run(SCENARIOS / "constant_torque.toml", *QUICK, *trip).returncode == 3
    check_counts(file)
    (suite,) = suites(file).values()
    (result,) = next(case for case in suite if case.name == "verdict").result
    assert isinstance(result, junitparser.Error)
    assert (result.type, "the drive tripped with OVER_CURRENT at" in result.message) == ("tripped", True)
    expected = ("--set", 'expect.fault="COMMAND_LOST"')
    run(SCENARIOS / "constant_torque.toml", *QUICK, *expected, *trip)
    (suite,) = suites(file).values()
    assert re.match(r"OVER_CURRENT came first, at 0\.\d+ s$", failed(suite)["fault COMMAND_LOST, 0 s to the end"])


def test_a_run_of_which_nothing_is_expected_is_skipped_or_fails(tmp_path: Path) -> None:
    file, scenario = tmp_path / "junit.xml", tmp_path / "silent.toml"
    text = (SCENARIOS / "constant_torque.toml").read_text().replace("../machines", str(SCENARIOS.parent / "machines"))
    scenario.write_text(text[: text.index("[expect]")])
    out = ("--out", tmp_path / "out", "--junit", file)
    assert run(scenario, *QUICK, *out).returncode == 0
    check_counts(file)
    (suite,) = suites(file).values()
    assert (skipped(suite), suite.failures) == (["verdict"], 0)
    assert run(scenario, *QUICK, *out, "--require-expectations").returncode == 9
    check_counts(file)
    (suite,) = suites(file).values()
    assert failed(suite)["verdict"].startswith("nothing is expected of the run")


@pytest.mark.parametrize(
    ("files", "settings", "reason"),
    [
        (["wrong.toml"], (), "wrong.toml:3: speed: unknown key"),
        (["good.toml", "wrong.toml"], (), "wrong.toml:3: speed: unknown key"),
        (["wrong.toml", "good.toml"], (), "wrong.toml:3: speed: unknown key"),
        (["none.toml", "good.toml"], (), "none.toml: cannot be read"),
        (["good.toml", "good.toml"], (), "is taken by"),
        (["good.toml"], ("--set", "plant.u_dc_v=-1"), "plant.u_dc_v"),
    ],
)
def test_no_earlier_report_stays_where_nothing_can_run(
    tmp_path: Path, files: list[str], settings: tuple, reason: str
) -> None:
    """A green report of an earlier run would be taken for this one's."""
    scenario = (SCENARIOS / "constant_torque.toml").read_text(encoding="utf-8").replace("../", f"{SCENARIOS.parent}/")
    (tmp_path / "good.toml").write_text(scenario, encoding="utf-8")
    (tmp_path / "wrong.toml").write_text('name = "wrong"\nduration_s = 1\nspeed = 3\n', encoding="utf-8")
    reports = ("--junit", tmp_path / "junit.xml", "--summary-markdown", tmp_path / "summary.md")
    assert run(tmp_path / "good.toml", "--out", tmp_path, *QUICK, *reports).returncode == 0
    found = run(*(tmp_path / file for file in files), "--out", tmp_path, *QUICK, *settings, *reports)
    assert found.returncode == 2
    assert reason in found.stderr
    check_counts(tmp_path / "junit.xml")
    xml = list(junitparser.JUnitXml.fromfile(str(tmp_path / "junit.xml")))
    assert len(xml) == len(files)
    for suite in xml:
        assert suite.errors == suite.tests == 1
        assert all("did not run: " in said and reason in said for said in failed(suite).values())
    assert (tmp_path / "summary.md").read_text(encoding="utf-8").count("did not run: ") == len(files)


def test_names_are_escaped(tmp_path: Path) -> None:
    file, markdown = tmp_path / "junit.xml", tmp_path / "summary.md"
    name = 'a "b" <c> & d | *e* `f` \\u0001\\uFFFE\\uFFFF ü€\U0001f600'
    settings = ("--set", f'name="{name}"'.replace('"b"', '\\"b\\"'), "--out", tmp_path / "out")
    done = run(SCENARIOS / "constant_torque.toml", *QUICK, *settings, "--junit", file, "--summary-markdown", markdown)
    assert done.returncode == 0, done.stderr
    (suite,) = suites(file).values()
    assert suite.name == 'a "b" <c> & d | *e* `f` ??? ü€\U0001f600'
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
    names = ["constant_torque", "reversal"]
    words = [
        *(SCENARIOS / f"{name}.toml" for name in names),
        "--set",
        "duration_s=10000",
        "--out",
        out,
        "--junit",
        file,
    ]
    with subprocess.Popen(
        [program("sextant-mil"), *map(str, words)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    ) as process:
        try:
            deadline_s = time.monotonic() + 60
            while not (out / names[0] / "trace.h5").is_file():
                assert process.poll() is None and time.monotonic() < deadline_s
                time.sleep(0.02)
            check_counts(file)  # the file is whole at any time
            assert {name: skipped(suite) for name, suite in suites(file).items()} == {key: ["verdict"] for key in names}
            process.send_signal(signal.SIGTERM)
            assert process.wait(60) == 128 + signal.SIGTERM
        finally:
            process.kill()
    check_counts(file)
    first, second = suites(file).values()
    assert (first.errors, second.errors, skipped(first), skipped(second)) == (1, 0, [], ["verdict"])
    assert failed(first)["verdict"].startswith("interrupted at")
    assert failed(second) == {"verdict": "not run"}


def test_a_scenario_whose_results_cannot_be_kept_is_an_error_of_its_suite(tmp_path: Path) -> None:
    file, markdown, out = tmp_path / "junit.xml", tmp_path / "summary.md", tmp_path / "out"
    out.mkdir()
    (out / "reversal").write_text("a file")
    names = ("constant_torque", "reversal", "paper/3_1_constant_torque")
    scenarios = [SCENARIOS / f"{name}.toml" for name in names]
    done = run(*scenarios, *QUICK, "--out", out, "--junit", file, "--summary-markdown", markdown)
    sentence = f"the directory {out}/reversal cannot be made: "
    assert done.returncode == 2 and f"sextant-mil: {sentence}" in done.stderr
    check_counts(file)
    found = suites(file)
    assert failed(found["constant_torque"]) == {} and skipped(found["constant_torque"]) == []
    (result,) = next(iter(found["reversal"])).result
    assert isinstance(result, junitparser.Error) and result.message.startswith(sentence)
    assert failed(found["3_1_constant_torque"]) == {"verdict": "not run"}
    assert "### reversal: error\n\nthe directory " in markdown.read_text(encoding="utf-8")


@pytest.mark.parametrize("path", [b"o\xff", b"o\xed\xa0\x80", b"o\xc0\xaf", b"o\xf4\x90\x80\x80", b"o\xe2\x82"])
def test_what_is_no_utf_8_is_replaced(tmp_path: Path, path: bytes) -> None:
    file, out = tmp_path / "junit.xml", Path(os.fsdecode(os.fsencode(tmp_path) + b"/" + path))
    out.write_text("a file")
    command = [program("sextant-mil"), SCENARIOS / "reversal.toml", "--out", out, "--junit", file]
    assert subprocess.run(command, capture_output=True, timeout=60).returncode == 2
    (suite,) = suites(file).values()
    shown = str(tmp_path / "o") + "?" * (len(path) - 1)
    assert failed(suite)["verdict"].startswith(f"the directory {shown} cannot be made")


def test_the_reason_of_an_incomplete_trace_stands_once_in_each_report(tmp_path: Path) -> None:
    file, markdown, out = tmp_path / "junit.xml", tmp_path / "summary.md", tmp_path / "out"
    words = ["--set", "plant.integrator=fixed", "--out", out, "--junit", file, "--summary-markdown", markdown]
    command = [program("sextant-mil"), SCENARIOS / "constant_torque.toml", *words]
    limit = "import os, resource, sys; resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000)); "
    started = [sys.executable, "-c", limit + "os.execv(sys.argv[1], sys.argv[1:])", *map(str, command)]
    # Python ignores SIGXFSZ, and so does the program then.
    done = subprocess.run(started, capture_output=True, text=True, timeout=300, restore_signals=False)
    assert done.returncode == 8, done.stderr
    check_counts(file)
    (suite,) = suites(file).values()
    reason = failed(suite)["verdict"]
    assert re.match(rf"{out}/trace\.h5: recording stopped, cannot write the trace: .+$", reason)
    assert done.stderr == f"sextant-mil: constant_torque: {reason}\n"
    text = markdown.read_text(encoding="utf-8")
    assert text.startswith("### constant\\_torque: trace\\_incomplete\n\n")
    assert text.count("recording stopped, cannot write the trace") == 1


def test_each_sentence_has_a_line_of_the_markdown(tmp_path: Path) -> None:
    markdown = tmp_path / "summary.md"
    keys = {
        "control.dtc.comparator_reading": "memoryless",
        "event_exact.minimum_dwell_ns": "0",
        "event_exact.max_events": "1",
        "expect.fault": '"COMMAND_LOST"',
    }
    settings = [word for key, value in keys.items() for word in ("--set", f"{key}={value}")]
    scenario = SCENARIOS / "paper" / "3_1_constant_torque.toml"
    done = run(scenario, *QUICK, *settings, "--out", tmp_path / "out", "--summary-markdown", markdown)
    assert done.returncode == 6, done.stderr
    paragraph = MarkdownIt("commonmark").parse(markdown.read_text(encoding="utf-8"))[4]
    kinds = [child.type for child in paragraph.children]
    assert paragraph.content.startswith("the events do not end at") and kinds.count("hardbreak") == 1
    assert "softbreak" not in kinds


def test_test_cases_of_windows_that_are_nearly_the_same_have_names_of_their_own(tmp_path: Path) -> None:
    file = tmp_path / "junit.xml"
    windows = ",".join(f"{{from_s={start},to_s=0.5,flux_mean_wb={{max=2}}}}" for start in ("0.3", "0.3000001"))
    settings = ("--set", f"expect.window=[{windows}]", "--out", tmp_path / "out", "--junit", file)
    assert run(SCENARIOS / "constant_torque.toml", *QUICK, *settings).returncode == 0
    check_counts(file)
    (suite,) = suites(file).values()
    assert {"flux_mean_wb, 0.3 s to 0.5 s ≤ 2", "flux_mean_wb, 0.3000001 s to 0.5 s ≤ 2"} < {
        case.name for case in suite
    }


@pytest.mark.parametrize("text", ['name = "x"\n', '{"scenario": "x"}', "about <testsuites>\n", "<html/>", "\n"])
def test_a_file_that_is_no_junit_file_stays(tmp_path: Path, text: str) -> None:
    file = tmp_path / "mine"
    file.write_text(text)
    (tmp_path / "link").symlink_to(file)
    for name in (file, tmp_path / "link"):
        done = run(SCENARIOS / "constant_torque.toml", *QUICK, "--out", tmp_path / "out", "--junit", name)
        assert done.returncode == 2
        sentence = "is there and is no JUnit file: move it, or name another file with --junit"
        assert done.stderr == f"sextant-mil: {name} {sentence}\n"
        assert file.read_text() == text and not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    "head", ["", "<testsuite/>", "<?xml version='1.0'?>\n<!-- x -->\n<testsuites " + 5000 * " " + "/>"]
)
def test_an_older_junit_file_is_replaced(tmp_path: Path, head: str) -> None:
    file = tmp_path / "junit.xml"
    file.write_text(head)
    assert run(SCENARIOS / "reversal.toml", *QUICK, "--out", tmp_path / "out", "--junit", file).returncode == 0
    check_counts(file)
    assert list(suites(file)) == ["reversal"]


@pytest.mark.parametrize("link", ["junit.xml", "summary.md", None])
def test_both_reports_in_one_file_are_refused(tmp_path: Path, link: str | None) -> None:
    (tmp_path / "new").mkdir()
    both = tmp_path / "new" / ".." / "both"
    files = {"junit.xml": both, "summary.md": tmp_path / "both"}
    if link:
        (tmp_path / link).symlink_to("both")  # which is not there yet
        files[link] = tmp_path / link
    words = ("--junit", files["junit.xml"], "--summary-markdown", files["summary.md"])
    done = run(SCENARIOS / "constant_torque.toml", *QUICK, "--out", tmp_path / "out", *words)
    assert done.returncode == 2
    sentence = "--junit and --summary-markdown name the same file: name two files"
    assert done.stderr == f"sextant-mil: {files['junit.xml']}: {sentence}\n"
    assert not both.exists() and not (tmp_path / "out").exists()


def test_a_link_to_a_report_stays(tmp_path: Path) -> None:
    link, target = tmp_path / "junit.xml", tmp_path / "target.xml"
    target.touch(0o600)
    link.symlink_to(target.name)
    assert run(SCENARIOS / "reversal.toml", *QUICK, "--out", tmp_path / "out", "--junit", link).returncode == 0
    assert link.is_symlink() and target.stat().st_mode & 0o777 == 0o600
    check_counts(target)
