"""The report: what it says of runs, recordings, sweeps, JUnit and timing files; its configuration; bad input."""

import json
import random
import re
import subprocess
from functools import partial
from html.parser import HTMLParser
from pathlib import Path

import made_recording
import numpy as np
import pytest
from programs import program
from sextant_py import report
from sextant_py.errors import status_or_refusal
from sextant_py.paths import ROOT
from sextant_py.recording.formats import SUFFIXES
from sextant_py.recording.model import MAIN
from sextant_py.recording.topics import STATE, group_of
from sextant_py.report import configuration
from sextant_py.report.model import Settings

SUMMARY = {
    "scenario": "step",
    "verdict": "fail",
    "metrics": {"torque_bias_nm": -0.5, "peak_current_a": 80.25, "current_thd_percent": None},
    "expect": [
        {"metric": "torque_bias_nm", "limit": {"min": -1.0, "max": 1.0}, "value": -0.5, "pass": True},
        {"metric": "peak_current_a", "limit": {"max": 70.0}, "value": 80.25, "pass": False,
         "window": {"from_s": 0.5, "to_s": None}},
    ],
    "faults": [{"fault": "OVER_CURRENT", "t_s": 0.25}, {"fault": "CURRENT_SUM", "t_s": 0.251}],
    "expected_fault": None,
    "version": "1.2.3",
    "commit": "abcdef0",
}  # fmt: skip


class Page(HTMLParser):
    """The rows of the tables as lists of texts, and every address."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.rows: list[list[str]] = []
        self.addresses: list[str] = []
        self.tags: set[str] = set()
        self._in_cell = False
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)
        self.addresses += [value or "" for name, value in attrs if name in ("src", "srcset", "href")]
        if tag == "tr":
            self.rows.append([])
        if tag in ("td", "th"):
            self.rows[-1].append("")
            self._in_cell = True

    def handle_endtag(self, tag: str) -> None:
        self._in_cell &= tag not in ("td", "th")

    def handle_data(self, data: str) -> None:
        if self._in_cell:
            self.rows[-1][-1] += data


def directory(path: Path, **changes: object) -> Path:
    path.mkdir(parents=True, exist_ok=True)
    (path / "summary.json").write_text(json.dumps(SUMMARY | changes), encoding="utf-8")
    return path


def page_of(tmp_path: Path, *words: object) -> Page:
    out = tmp_path / "page" / "report.html"
    assert report.main([*map(str, words), "--out", str(out)]) == 0
    return Page(out.read_text(encoding="utf-8"))


def test_verdict_limits_and_faults_of_a_run(tmp_path: Path) -> None:
    page = page_of(tmp_path, directory(tmp_path / "run"))
    assert [
        "step",
        "run of sextant-mil",
        "fail",
        "1 of 2",
        "OVER_CURRENT at 0.25 s, CURRENT_SUM at 0.251 s",
    ] in page.rows
    assert ["torque_bias_nm", "-1 … 1", "-0.5", "holds", ""] in page.rows
    assert ["peak_current_a", "≤ 70", "80.25", "does not hold", "from 0.5 s to the end"] in page.rows
    faults = page.rows.index(["fault", "latched at [s]"])
    assert page.rows[faults + 1 : faults + 3] == [["OVER_CURRENT", "0.250000"], ["CURRENT_SUM", "0.251000"]]


def test_an_expected_fault_is_a_limit(tmp_path: Path) -> None:
    expected = {"fault": "OVER_SPEED", "from_s": 0.1, "to_s": 0.2, "pass": False}
    page = page_of(tmp_path, directory(tmp_path / "run", expected_fault=expected))
    assert ["first fault", "OVER_SPEED", "OVER_CURRENT", "does not hold", "from 0.1 s to 0.2 s"] in page.rows


def test_the_page_needs_no_network_and_no_script(tmp_path: Path) -> None:
    made_recording.write(live(), tmp_path / "run.h5")
    page = page_of(tmp_path, directory(tmp_path / "run", scenario="<script>x</script>"), tmp_path / "run.h5")
    assert "script" not in page.tags
    assert any("<script>x</script>" in row for row in page.rows)
    assert page.addresses
    assert all(address.startswith(("data:image/png;base64,", "#run-")) for address in page.addresses)


def test_every_directory_of_several_is_reported(tmp_path: Path) -> None:
    for name, verdict in (("a", "pass"), ("b", "tripped"), ("c", "nothing_expected")):
        directory(tmp_path / "out" / name, scenario=name, verdict=verdict)
    page = page_of(tmp_path, tmp_path / "out")
    assert [row[0::2][:2] for row in page.rows[1:4]] == [["a", "pass"], ["b", "tripped"], ["c", "nothing expected"]]


def live(faults: bool = True) -> made_recording.MadeSource:
    """Telemetry of a second, and the changes of the state: two faults, a reset, and one of them again."""
    telemetry = np.zeros(1000, group_of(MAIN).dtype)
    telemetry["t_ns"] = 5_000_000_000 + 1_000_000 * np.arange(1000)
    telemetry["torque_mean_nm"] = np.linspace(0, 20, 1000)
    telemetry["torque_min_nm"], telemetry["torque_max_nm"] = (
        telemetry["torque_mean_nm"] - 1,
        telemetry["torque_mean_nm"] + 1,
    )
    rows = [  # time [ms], state, latched, first
        (0, 4, 0, -1),
        (250, 6, 1 << 9 | 1 << 7, 9),
        (300, 6, 1 << 9 | 1 << 7 | 1 << 12, 9),
        (400, 2, 0, -1),
        (500, 6, 1 << 7, 7),
        (600, 2, 0, -1),
    ]
    states = np.zeros(len(rows), group_of(STATE).dtype)
    for row, (ms, state, latched, first) in zip(states, rows, strict=True):
        row["t_ns"], row["state"] = 5_000_000_000 + 1_000_000 * ms, state
        row["faults_latched"], row["first_fault"], row["reason"] = latched, first, b"why <not>"
    blocks = {MAIN: telemetry, STATE: states if faults else states[:1]}
    return made_recording.MadeSource(blocks, [group_of(MAIN), group_of(STATE)])


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_faults_of_a_recording_have_names_and_times(tmp_path: Path, suffix: str) -> None:
    """By the DBC: 7 CURRENT_SENSOR … see names(); each latches once until a reset, the first one of a row first."""
    path = tmp_path / f"live{suffix}"
    made_recording.write(live(), path)
    page = page_of(tmp_path, path)
    names = {bit: name for name, bit in dbc_faults().items()}
    expected = [(9, 0.25), (7, 0.25), (12, 0.3), (7, 0.5)]
    found = [row for row in page.rows if len(row) == 2 and row[0] in names.values()]
    assert found == [[names[bit], f"{t_s:.6f}"] for bit, t_s in expected]
    assert ["0.25", "FAULT", "why <not>"] in page.rows


def dbc_faults() -> dict[str, int]:
    """Names and values of FirstFault, read from the DBC itself."""
    text = (ROOT / "configs" / "interfaces" / "sextant.dbc").read_text(encoding="utf-8")
    line = re.search(r"^VAL_ \d+ FirstFault (.*);$", text, re.MULTILINE)[1]
    return {name: int(value) for value, name in re.findall(r'(\d+) "(\w+)"', line)}


def test_a_recording_that_ends_in_fault_has_that_verdict(tmp_path: Path) -> None:
    source = live()
    source._blocks[STATE] = source._blocks[STATE][:3]
    made_recording.write(source, tmp_path / "end.h5")
    made_recording.write(live(faults=False), tmp_path / "good.h5")
    page = page_of(tmp_path, tmp_path / "end.h5", tmp_path / "good.h5")
    assert [row[2] for row in page.rows[1:3]] == ["in FAULT at the end", "recorded"]
    assert page.rows[2][4] == "none"


def test_junit_timing_and_sweep(tmp_path: Path) -> None:
    (tmp_path / "j.xml").write_text(
        '<testsuites><testsuite name="s"><testcase name="good"/><testcase name="bad"><failure message="7 is above 5"/>'
        '</testcase><testcase name="left"><skipped message="no run"/></testcase></testsuite></testsuites>'
    )
    histogram = {"count": 3, "p50_ns": 1000, "p99_ns": 2000, "p99_9_ns": 3000, "p99_99_ns": 4000, "max_ns": 5500}
    timing = {"periods": 9, "periods_missed": 2, "overruns": 1, "overruns_by_cause": {"machine": 1}}
    timing |= {"wake_latency": histogram, "execution": histogram, "stages": {"read": histogram}}
    (tmp_path / "timing.json").write_text(json.dumps(timing))
    sweep = tmp_path / "sweep"
    sweep.mkdir()
    (sweep / "sweep.json").write_text(json.dumps({"name": "bands", "points": 3, "scenario": "x.toml", "seed": 7}))
    lines = [{"point": 1, "status": "failed", "metrics": {}, "reason": "tripped with OVER_CURRENT"}]
    lines.append({"point": 0, "status": "ok", "metrics": {}, "reason": ""})
    (sweep / "points.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines) + '{"point": 2, "sta')
    page = page_of(tmp_path, tmp_path / "j.xml", tmp_path / "timing.json", sweep)
    assert [row[2] for row in page.rows[1:4]] == ["fail", "2 periods missed", "not finished"]
    assert page.rows[3][3] == "1 of 3 points"
    assert ["bad", "does not hold", "7 is above 5"] in page.rows
    assert ["left", "not evaluated", "no run"] in page.rows
    assert ["stage read", "3", "1.0", "2.0", "3.0", "4.0", "5.5"] in page.rows
    assert ["1", "", "failed", "tripped with OVER_CURRENT"] in page.rows


def bad_inputs(place: Path) -> dict[str, list[object]]:
    (place / "empty").mkdir()
    (place / "no.json").write_text("{")
    (place / "list.json").write_text("[1]")
    (place / "timing.json").write_text('{"wake_latency": 1, "execution": 2, "periods": 3}')
    (place / "no.xml").write_text("<a")
    (place / "other.xml").write_text("<a/>")
    (place / "no.h5").write_text("x")
    (place / "notes.txt").write_text("x")
    (place / "sweep").mkdir()
    (place / "sweep" / "sweep.json").write_text("{}")
    good = directory(place / "good")
    made_recording.write(live(), place / "live.h5")
    files = (
        "empty",
        "no.json",
        "list.json",
        "timing.json",
        "no.xml",
        "other.xml",
        "no.h5",
        "notes.txt",
        "sweep",
        "absent",
    )
    bad: dict[str, list[object]] = {name: [good, place / name] for name in (*files, "absent.h5")}
    bad["signal"] = [place / "live.h5", "--signal", "tork"]
    bad["span"] = [place / "live.h5", "--from", "77"]
    bad["mil"] = [good, "--mil", place / "absent"]
    bad["ending"] = [good, "--out", place / "report.pdf"]
    return bad


def test_bad_input_is_one_sentence(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    for name, words in bad_inputs(tmp_path).items():
        out = [] if "--out" in words else ["--out", str(tmp_path / f"{name}.html")]
        perform = partial(report.main, [*map(str, words), *out])
        assert status_or_refusal("report", perform) == 2, name
        said = capsys.readouterr().err
        assert said.startswith("report: "), name
        assert said.endswith(".\n"), name
        assert said.count("\n") == 1, name
        assert not (tmp_path / f"{name}.html").exists(), name


def test_a_run_whose_trace_cannot_be_read_is_on_the_page(tmp_path: Path) -> None:
    run = directory(tmp_path / "run")
    (run / "trace.h5").write_text("x")
    out = tmp_path / "report.html"
    assert report.main([str(run), "--out", str(out)]) == 0
    assert "Nothing is drawn: " in out.read_text(encoding="utf-8")


SCENARIOS = ("constant_torque.toml", "reversal.toml", "paper/3_5_nycc_clip.toml")
CHANGES = {
    "control.controller": ["foc", "deadbeat"],
    "protection.over_current_a": [300.0],
    "plant.u_dc_v": [400, 610.5],
    "machine.r_s_ohm": [0.2, 0.7],
    "drive.period_us": [50, 100],
    "drive.current_limit_a": [120.5],
    "control.flux_reference_wb": [0.8],
    "trace.signals": [["standard", "link"]],
    "drive.flux_optimum": ["min_loss"],
}


@pytest.mark.parametrize("seed", range(6))
def test_the_differences_are_the_configuration(seed: int, tmp_path: Path) -> None:
    """A scenario of the differences alone has the configuration of the run, and each of them is needed."""
    print(f"seed {seed}")
    draw = random.Random(seed)
    chosen = {key: draw.choice(values) for key, values in draw.sample(sorted(CHANGES.items()), 4)} if seed else {}
    if seed % len(SCENARIOS) == 2:
        chosen.pop("control.controller", None)  # an event-exact run has dtc
    mil = program("sextant-mil")
    scenario = ROOT / "configs" / "scenarios" / SCENARIOS[seed % len(SCENARIOS)]
    settings = [word for key, value in chosen.items() for word in ("--set", f"{key}={configuration.toml_value(value)}")]
    settings += ["--set", "duration_s=0.5", "--no-trace", "--out", str(tmp_path)]
    done = subprocess.run([mil, scenario, *settings], capture_output=True, text=True)
    assert done.returncode not in (2, -11), done.stderr
    whole = json.loads((tmp_path / "summary.json").read_text())["configuration"]
    found = {entry.key: entry.value for entry in configuration.differences(mil, whole)}

    def printed(keys: dict[str, object]) -> dict[str, object]:
        return {key: entry.value for key, entry in configuration.print_config(mil, keys).items()}

    reference = printed(found)
    assert {
        key: value for key, value in whole.items() if value is not None and reference.get(key, value) != value
    } == {}
    assert len(found) < 70 < len(whole)
    required = {key for key in found if key in ("name", "duration_s") or key.startswith("machine.")}
    for key in draw.sample(sorted(found.keys() - required), 5):
        less = {name: value for name, value in found.items() if name != key}
        try:
            assert printed(less) != reference, key
        except configuration.UserError:
            continue  # without the key it cannot stand


def test_the_page_has_the_differences(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    mil = program("sextant-mil")
    keys = {
        "name": "step",
        "description": "",
        "duration_s": 2,
        "protection.over_current_a": 60.0,
        "drive.period_us": 25,
    }
    keys |= {"machine.r_s_ohm": 0.435, "machine.r_r_ohm": 0.816, "machine.x_ls_ohm": 0.754, "machine.x_lr_ohm": 0.754}
    keys |= {"machine.x_m_ohm": 26.13, "machine.reactance_frequency_hz": 50, "machine.poles": 4}
    keys |= {"machine.inertia_kg_m2": 0.089}
    page = page_of(tmp_path, directory(tmp_path / "run", configuration=keys), "--mil", mil)
    rows = {row[0]: row for row in page.rows}
    assert rows["protection.over_current_a"][1] == "60"
    assert rows["protection.over_current_a"][2].endswith(" (derived)")
    assert rows["machine.poles"][1:3] == ["4", "–"]
    assert "drive.period_us" not in rows  # its default
    # Without the program, or with one that does not take the configuration, all of it is shown.
    monkeypatch.setenv("SEXTANT_BIN", str(tmp_path))
    page = page_of(tmp_path, directory(tmp_path / "run", configuration=keys))
    assert ["drive.period_us", "25"] in page.rows
    page = page_of(tmp_path, directory(tmp_path / "run", configuration={**keys, "drive.gone": 7}), "--mil", mil)
    assert ["drive.gone", "7"] in page.rows


def test_default_of_a_text_with_the_mark_of_a_comment() -> None:
    text = 'description = "a  # b; default 7"  # what it shows; a string; default ""\n'
    text += "# x =  # y [A]; a number; default not set\n"
    keys = configuration.read_printed(text)
    assert keys["description"].value == "a  # b; default 7"
    assert keys["description"].fixed_default == ""
    assert keys["x"] == configuration.Key(None, "not set", "y [A]; a number")


def test_settings_without_a_program_are_refused_when_they_are_asked(tmp_path: Path) -> None:
    with pytest.raises(configuration.UserError, match="is not a program"):
        _ = Settings(mil=tmp_path / "absent").program
