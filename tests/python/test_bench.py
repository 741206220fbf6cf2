"""scripts/bench: verdicts, what is read of Google Benchmark, kept figures, the page, stages that fail."""

import json
import math
import os
import re
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from sextant_py.errors import UserError
from sextant_py.paths import ROOT
from studies import page as pages
from studies.bench import bench, peer_python, peers, results, speed
from studies.bench.figure import MET, MISSED, NOT_MEASURED, PUBLISHED, Figure, NotMeasurableError, number
from studies.bench.google import GoogleResult
from studies.bench.histogram import Histogram
from studies.bench.lab import Lab, Stage
from studies.bench.results import Run, StageResult
from studies.origin import Origin
from studies.work_precision import closed_loops

ORIGIN = Origin("a processor", 2, "Linux 6.1", "2026-01-02 03:04", "0123456789", clean=True, load=0.07)


def google_run(name: str, repetition: int = 0, **values: object) -> dict:
    return {
        "run_name": name,
        "run_type": "iteration",
        "repetition_index": repetition,
        "cpu_time": 2.0,
        "real_time": 9.0,
        "time_unit": "us",
    } | values


@pytest.mark.parametrize(
    ("value", "limits", "verdict"),
    [
        (1.2, {"at_most": 1.2}, MET),
        (1.2001, {"at_most": 1.2}, MISSED),
        (250.0, {"at_least": 250.0}, MET),
        (249.9, {"at_least": 250.0}, MISSED),
        (0.98, {"at_least": 0.9, "at_most": 1.1}, MET),
        (0.8, {"at_least": 0.9, "at_most": 1.1}, MISSED),
        (math.nan, {"at_most": 1.2}, MISSED),
        (math.nan, {"at_least": 1.2}, MISSED),
        (7.0, {}, PUBLISHED),
        (None, {"at_most": 1.2}, NOT_MEASURED),
        (math.nan, {}, MISSED),
        (None, {}, NOT_MEASURED),
    ],
)
def test_verdicts(value: float | None, limits: dict, verdict: str) -> None:
    assert Figure("x", value=value, **limits).verdict == verdict


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"),
        (1.2345, "1.23"),
        (0.0269, "0.0269"),
        (8838.4, "8 838"),
        (153.2, "153"),
        (4e-9, "4e-9"),
        (2.5e7, "2.5e7"),
        (math.nan, "nan"),
        (math.inf, "inf"),
    ],
)
def test_numbers(value: float, text: str) -> None:
    assert number(value) == text


def test_google_benchmark_is_read_by_repetition() -> None:
    result = GoogleResult(
        {
            "benchmarks": [
                google_run("a/iterations:1", cpu_time=3.0, ratio=1.5, threads=1),
                google_run("a/iterations:1", 1, cpu_time=2.5, ratio=1.1),
                google_run("a/iterations:1", 2, cpu_time=9.0, ratio=1.2),
                google_run("a/iterations:1", 3, cpu_time=0.1, run_type="aggregate", ratio=77.0),
                google_run("b/8/repeats:3", time_unit="ms", realtime_factor=4.0),
                google_run("replay", items_per_second=5e7),
                google_run("bad", error_occurred=True, error_message="the drive makes no torque"),
            ]
        }
    )
    assert result.value("a", "cpu_ns", "least") == 2500.0
    assert result.value("a", "ratio") == 1.2
    assert result.value("a", "ratio", "most") == 1.5
    assert result.value("b/8", "cpu_ns", "least") == 2e6
    assert result.value("replay", "cpu_ns", "least") == pytest.approx(20.0)  # of one of many items
    row = Figure("m", at_most=1.4, note="of a settled drive")
    assert result.figure(row, "a", "ratio", "most").verdict == MISSED
    least = result.figure(row, "a", "ratio", "least")
    assert (least.value, least.verdict, least.note) == (1.1, MET, "of a settled drive")
    failed = result.figure(row, "bad", "ratio")
    assert (failed.verdict, failed.note) == (MISSED, "the drive makes no torque")
    missing = result.figure(row, "none", "ratio")
    assert missing.verdict == MISSED
    assert "no benchmark none" in missing.note


def ages(**ratios: float) -> GoogleResult:
    return GoogleResult({"benchmarks": [google_run(f"closed_loop_growth/{k[1:]}", ratio=v) for k, v in ratios.items()]})


def test_a_cost_that_grows_with_the_length_of_the_run_is_seen() -> None:
    flat = speed.flatness(ages(n10000=1.01, n10000000=1.05))
    assert (flat.verdict, flat.value) == (MET, 1.05)
    assert "10 000 000 periods" in flat.note
    assert speed.flatness(ages(n10000=1.3, n10000000=1.05)).verdict == MISSED
    assert speed.flatness(ages()).verdict == MISSED


def peer_round(fixed: float, motulator: float, gem: float) -> dict:
    return {"ours": {"fixed": fixed, "cvode": fixed / 30}} | {
        tool: {"factor": factor, "version": "1", "python": "3.12.1"}
        for tool, factor in (
            ("motulator", motulator),
            ("motulator_averaged", 2 * motulator),
            ("gem", gem),
            ("gem_euler", 2 * gem),
        )
    }


def test_peers_are_compared_within_a_round() -> None:
    # The second round ran on a machine half as fast: the ratios stand.
    rounds = [peer_round(200, 0.025, 0.16), peer_round(100, 0.0125, 0.08), peer_round(200, 0.025, 0.25)]
    figures = {figure.measure: figure for figure in peers.compare(rounds)}
    against_motulator = figures["simulated seconds a second, ours / motulator, current-vector control with PWM"]
    assert (against_motulator.value, against_motulator.verdict) == (pytest.approx(8000), MET)
    gem = figures["simulated seconds a second, ours / gym-electric-motor, finite control set, no controller"]
    assert (gem.value, gem.verdict) == (pytest.approx(1250), MET)
    euler = figures["simulated seconds a second, ours / gym-electric-motor with its Euler solver"]
    assert euler.verdict == PUBLISHED
    slow = peers.compare([peer_round(100, 0.025, 0.16)])
    assert [figure.verdict for figure in slow if figure.target] == [MISSED, MISSED]


def test_each_figure_of_a_peer_names_its_version() -> None:
    figures = peers.compare([peer_round(200, 0.025, 0.16)])
    of_peers = [figure for figure in figures if "motulator" in figure.measure or "gym" in figure.measure]
    assert len(of_peers) == len(peers.RATIOS) + len(peers.TOOLS)
    assert all(figure.note.startswith("version 1, Python 3.12.1") for figure in of_peers)


def fake_program(folder: Path, name: str, script: str) -> Path:
    program = folder / name
    program.write_text(f"#!/bin/sh\n{script}\n")
    program.chmod(0o755)
    return program


def test_the_peers_get_the_oldest_python_that_is_new_enough_and_runs(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    fake_program(tmp_path, "python3.91", "echo command not found >&2; exit 127")  # as a shim without its version
    fake_program(tmp_path, "python3.92", "echo 3 11")  # not what its name says
    found = fake_program(tmp_path, "python3.93", "echo 3 93")
    fake_program(tmp_path, "python3.94", "echo 3 94")
    fake_program(tmp_path, "python3.93-config", "echo 3 93")
    monkeypatch.setattr(peer_python, "folders", lambda: [tmp_path / "none", tmp_path])
    assert peer_python.interpreter((3, 90)) == str(found)
    assert peer_python.interpreter((3, 95)) == sys.executable
    assert peer_python.interpreter((3, 0)) == sys.executable


def test_pyenv_is_searched_beside_the_path(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    folder = tmp_path / "versions" / "3.99.0" / "bin"
    folder.mkdir(parents=True)
    monkeypatch.setenv("PYENV_ROOT", str(tmp_path))
    monkeypatch.setenv("PATH", f"/first{os.pathsep}/second")
    assert peer_python.folders() == [Path("/first"), Path("/second"), folder]


def test_each_python_gets_one_version_of_motulator() -> None:
    lines = peer_python.REQUIREMENTS.read_text(encoding="utf-8").splitlines()
    needed = ".".join(map(str, peer_python.NEWEST_NEEDS))
    markers = [line.partition("; ")[2] for line in lines if line.startswith("motulator==")]
    assert sorted(markers) == [f'python_version < "{needed}"', f'python_version >= "{needed}"']


def test_a_peer_that_ran_something_else_is_refused(tmp_path: Path) -> None:
    peer = fake_program(tmp_path, "peer", 'echo \'{"version": "1", "simulated_s": 1, "cpu_s": 2, "torque": 20}\'')
    with pytest.raises(UserError, match=r"stands at 20\.0 N·m"):
        peers.run_peer(Lab(), peer, "gem", 1.0)


def test_peers_that_cannot_be_installed_are_not_measured(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail() -> Path:
        raise UserError("no network")

    monkeypatch.setattr(peer_python, "install", fail)
    figures = peers.peers(Lab())
    assert [(f.verdict, f.note, f.at_least) for f in figures] == [
        (NOT_MEASURED, "no network", 5000.0),
        (NOT_MEASURED, "no network", 1000.0),
    ]


def work_precision(difference: float, error: float) -> dict:
    """difference: to CVODE at 1e-12; to that at 1e-10 it is a hundred times as much."""

    def point(integrator: str, setting: str, default: bool, value: float) -> dict:
        return {
            "integrator": integrator,
            "setting": setting,
            "default": default,
            "torque_error_nm": value / difference * error,
            "torque_difference_to_cvode_1e_10_nm": 100.0 * value,
            "torque_difference_to_cvode_1e_12_nm": value,
        }

    points = [
        point("fixed", "2.5 us", False, 9.0),
        point("exact", "25 us", True, 9.0),
        point("fixed", "25 us", True, difference),
    ]
    return {"free_shaft": {"torque_error_of_cvode_nm": {"1e-10": 3e-5, "1e-12": 3e-7}, "points": points}}


def test_the_error_of_the_fixed_step_is_that_of_its_default_step() -> None:
    loose, tight, true = speed.precision_figures(work_precision(3e-9, 4e-9))
    assert (loose.value, loose.verdict) == (pytest.approx(3e-7), MET)
    assert "1e-10 itself is 3e-5 N·m" in loose.note
    assert (tight.value, tight.verdict) == (3e-9, MET)
    assert "1e-12 itself is 3e-7 N·m" in tight.note
    assert (true.value, true.verdict) == (pytest.approx(4e-9), MET)
    assert [f.verdict for f in speed.precision_figures(work_precision(2e-6, 1.1e-6))] == [MISSED, MISSED, MISSED]
    for other in ({}, {"free_shaft": {"points": []}}):
        with pytest.raises(UserError, match="another form than expected"):
            speed.precision_figures(other)


def test_a_missing_program_is_a_miss_of_its_stage(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="cannot be run"):
        speed.precision(Lab(programs=tmp_path))


def loop(controller: str, speed: float | None, cpu_s: float, error: float) -> dict:
    one = {"cpu_s_per_simulated_s": cpu_s, "error_of_peak": error}
    return {
        "controller": controller,
        "speed_rad_s": speed,
        "integrators": {name: dict(one) for name in closed_loops.INTEGRATORS},
    }


def test_closed_loops_are_summed_over_time_and_the_largest_error_counts() -> None:
    loops = [loop("foc", 0.0, 0.01, 1e-6), loop("foc", 50.0, 0.01, 3e-6), loop("foc", -50.0, 0.03, 2e-6)]
    loops += [loop("foc", None, 0.01, 4e-6)]
    fixed = closed_loops.rows(loops)[0]
    assert (fixed.controller, fixed.integrator) == ("foc", "fixed")
    assert fixed.factor == pytest.approx(4 / 0.06)
    assert fixed.errors == {0.0: 1e-6, 50.0: 3e-6, None: 4e-6}


def test_closed_loops_have_targets_for_foc() -> None:
    figures = {figure.measure: figure for figure in speed.loop_figures([loop("foc", None, 0.02, 1.5e-5)])}
    assert len(figures) == 2 * len(closed_loops.INTEGRATORS)
    name = "closed loop of foc on {}, times real time"
    assert figures[name.format("fixed")].verdict == MISSED
    assert figures[name.format("cvode")].verdict == MET
    assert figures[name.format("erk")].verdict == PUBLISHED
    error = "closed loop of foc on {}: torque error in parts of the peak torque, 0 to 300 rad/s"
    assert figures[error.format("fixed")].verdict == MET
    assert figures[error.format("cvode")].verdict == MISSED


def test_the_table_of_the_closed_loops_has_a_row_for_each_integrator() -> None:
    speeds = (0.0, *(sign * one for one in (50.0, 150.0, 300.0) for sign in (1, -1)), None)
    table = closed_loops.table([loop(c, one, 0.1, 2e-7) for c in ("dtc", "foc") for one in speeds]).splitlines()
    assert len(table) == 2 + 2 * len(closed_loops.INTEGRATORS)
    assert table[2] == "| `dtc` | `fixed` | 10 | 2.0e-07 | 2.0e-07 |"


def some_run() -> Run:
    away = Figure("wake-up", "x", at_most=1.1).failed(NotMeasurableError("no cyclictest"))
    stages = {
        "control": StageResult("the step", [Figure("too slow", "x", 1.2, value=1.4), Figure("time", "ns", value=12.0)]),
        "plant": StageResult("the plant", [Figure("ratio | of it", "x", 1.2, value=1.1, note="in turns")], 3.0, 0.5),
        "growth": StageResult("many drives", [Figure("time", "ns", value=12.0)]),
        "scenarios": StageResult(
            "whole runs", [Figure("slow", "x", 1.2, value=1.3), Figure("fast", "x", 1.2, value=1.1)]
        ),
        "live": StageResult("the drive", [away], distributions={"cyclictest": Histogram.of([1000, 2500]).summary()}),
    }
    return Run(ORIGIN, stages)


def test_results_survive_the_file(tmp_path: Path) -> None:
    file = tmp_path / "deep" / "bench.json"
    results.write(file, some_run())
    assert results.read(file) == some_run()
    assert json.loads(file.read_text())["stages"]["control"]["figures"][0]["verdict"] == MISSED


@pytest.mark.parametrize(
    "text", ["", "[]", "{}", '{"format": 3, "stages": {"a": {}}}', '{"format": 3, "stages": {}}', '{"format": 2}']
)
def test_a_file_of_something_else_is_refused_in_a_sentence(tmp_path: Path, text: str) -> None:
    file = tmp_path / "bench.json"
    file.write_text(text)
    with pytest.raises(UserError, match=r"bench\.json"):
        results.read(file)


def test_the_page_has_figures_with_a_target_and_few_others() -> None:
    found = results.blocks(some_run())
    assert found["judged figures"].splitlines()[2:] == [
        "| too slow | ≤ 1.2 × | 1.4 ×, **missed** | `control` |",
        "| ratio \\| of it | ≤ 1.2 × | 1.1 × | `plant` |",
        "| slow | ≤ 1.2 × | 1.3 ×, **missed** | `scenarios` |",
    ]
    assert found["published figures"].splitlines()[2:] == ["| time | 12 ns | `growth` |"]
    assert found["not measured"] == "- Not measured: wake-up: no cyclictest."
    assert "| cyclictest | 1 | 2.5 | 2.5 | 2.5 |" in found["latency"]
    assert results.blocks(Run(ORIGIN, {}))["latency"] == ""


def test_the_page_says_of_which_machine_date_and_commit_it_is() -> None:
    text = results.blocks(some_run())["run"]
    assert text == (
        "a processor, 2 cores, Linux 6.1; 2026-01-02 03:04 UTC; commit 0123456789; load average at the start 0.07."
    )
    assert "commit 0123456789 with changes that are not committed;" in replace(ORIGIN, clean=False).text


def test_the_origin_is_that_of_this_checkout() -> None:
    here = Origin.now()
    assert re.fullmatch(r"[0-9a-f]{10,}", here.commit)
    assert here.processor
    assert here.cores == os.cpu_count()


def test_text_is_put_between_the_marks_and_nowhere_else() -> None:
    page = "a\n<!-- x -->\nold\n<!-- end of x -->\nb\n"
    once = pages.put(page, {"x": r"new \1"})
    assert once == "a\n<!-- x -->\nnew \\1\n<!-- end of x -->\nb\n"
    assert pages.put(once, {"x": r"new \1"}) == once
    assert pages.put("a <!-- x -->old<!-- end --> b\n", {"x": "new"}) == "a <!-- x -->new<!-- end --> b\n"
    with pytest.raises(UserError, match="once"):
        pages.put("a\n", {"x": "new"})
    with pytest.raises(UserError, match="once"):
        pages.put(page + page, {"x": "new"})


@pytest.fixture
def two_stages(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(lab: Lab) -> list[Figure]:
        lab.run("/no/such/program")
        raise AssertionError

    monkeypatch.setattr(
        bench,
        "STAGES",
        (
            Stage("good", "a good one", 1, lambda _: [Figure("slow", "x", 1.0, value=2.0)]),
            Stage("broken", "a broken one", 1, broken),
        ),
    )


def page_of(folder: Path) -> Path:
    """A page with every mark and old figures between them."""
    page = folder / "page.md"
    page.write_text("".join(f"<!-- {mark} -->\nold\n<!-- end of {mark} -->\n" for mark in results.blocks(Run(ORIGIN))))
    return page


@pytest.mark.usefixtures("two_stages")
def test_a_stage_that_fails_is_told_and_does_not_stop_the_others(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "bench.json"
    assert bench.main(["--out", str(out)]) == 0
    assert bench.main(["--out", str(out), "--judge"]) == 1
    printed = capsys.readouterr().out
    assert "bench: missed: stage broken: /no/such/program cannot be run: No such file or directory" in printed
    assert "bench: missed: slow" in printed
    assert set(results.read(out).stages) == {"good", "broken"}
    assert bench.main(["--out", str(out), "--judge", "--only", "broken"]) == 1
    assert set(results.read(out).stages) == {"broken"}, "a file holds one run"


@pytest.mark.parametrize("error", [KeyError("wake_latency"), json.JSONDecodeError("no value", "", 0)])
def test_an_error_that_nobody_expected_is_a_miss_of_its_stage_alone(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str], error: Exception
) -> None:
    def broken(_: Lab) -> list[Figure]:
        raise error

    good = Stage("good", "a good one", 1, lambda _: [Figure("quick", at_most=2.0, value=1.0)])
    monkeypatch.setattr(bench, "STAGES", (Stage("broken", "a broken one", 1, broken), good))
    out = tmp_path / "bench.json"
    assert bench.main(["--out", str(out), "--judge"]) == 1
    printed = capsys.readouterr()
    assert f"bench: missed: stage broken: {type(error).__name__}: " in printed.out
    assert "Traceback" in printed.err
    assert results.read(out).stages["good"].figures[0].verdict == MET


def judged(monkeypatch: pytest.MonkeyPatch, out: Path, *figures: Figure) -> int:
    monkeypatch.setattr(bench, "STAGES", (Stage("one", "one", 1, lambda _: list(figures)),))
    return bench.main(["--out", str(out / "bench.json"), "--judge"])


def test_the_exit_status_tells_missed_from_not_measured(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    good, missed = Figure("a", at_most=2.0, value=1.0), Figure("b", at_most=2.0, value=3.0)
    away = Figure("e", at_most=1.1).failed(NotMeasurableError("no cyclictest"))
    broken = GoogleResult(
        {"benchmarks": [google_run("sample", error_occurred=True, error_message="a sample did not arrive")]}
    ).figure(Figure("f", at_most=1.1), "sample", "ratio")
    assert judged(monkeypatch, tmp_path, good) == 0
    assert judged(monkeypatch, tmp_path, good, away) == 0
    assert "bench: not measured: e: no cyclictest" in capsys.readouterr().out
    assert judged(monkeypatch, tmp_path, away, missed) == 1
    assert judged(monkeypatch, tmp_path, away, broken) == 1
    assert "bench: missed: f: a sample did not arrive" in capsys.readouterr().out
    assert bench.main(["--out", str(tmp_path / "bench.json"), "--report"]) == 0


def test_what_is_not_installed_is_not_measured_and_what_crashes_is_missed(tmp_path: Path) -> None:
    lab = Lab(out=tmp_path)
    with pytest.raises(NotMeasurableError, match="cannot be run"):
        lab.run("no-such-program-of-the-system")
    for command in (["sh", "-c", "kill -SEGV $$"], ["false"], ["/no/such/program"]):
        with pytest.raises(UserError) as found:
            lab.run(*command)
        assert not isinstance(found.value, NotMeasurableError)
    assert lab.run("sh", "-c", "echo found; exit 1", accept=(0, 1)) == "found\n"
    with_vcan = tmp_path / "with_vcan"
    with_vcan.write_text("#!/bin/sh\nexit $1\n")
    with_vcan.chmod(0o755)
    with pytest.raises(NotMeasurableError, match="no kernel with vcan"):
        lab.run("env", with_vcan, "125")
    with pytest.raises(UserError, match="failed"):
        lab.run("env", with_vcan, "3")


def pushes(full: float, room: float, clock: float = 27.0) -> GoogleResult:
    return GoogleResult(
        {
            "benchmarks": [
                google_run("telemetry_push_full", p50_ns=full, clock_ns=clock),
                google_run("telemetry_push", p50_ns=room, clock_ns=clock),
            ]
        }
    )


def test_a_full_ring_is_judged_without_the_clock() -> None:
    good = speed.full_ring(pushes(29.0, 35.0))
    assert (good.value, good.verdict) == (0.25, MET)
    # With the clock on both sides these two would be 1.09.
    slow = speed.full_ring(pushes(38.0, 35.0))
    assert (slow.value, slow.verdict) == (1.375, MISSED)
    assert speed.full_ring(pushes(26.0, 35.0)).value == 0.0
    assert speed.full_ring(pushes(29.0, 27.0)).verdict == NOT_MEASURED
    broken = {"benchmarks": [google_run("telemetry_push_full", error_occurred=True, error_message="room left")]}
    assert (speed.full_ring(GoogleResult(broken)).verdict, speed.full_ring(GoogleResult(broken)).note) == (
        MISSED,
        "room left",
    )


@pytest.mark.usefixtures("two_stages")
def test_the_page_is_that_of_the_run_alone(tmp_path: Path) -> None:
    page = page_of(tmp_path)
    assert bench.main(["--out", str(tmp_path / "bench.json"), "--page", str(page), "--write-page"]) == 0
    text = page.read_text()
    assert "| slow | ≤ 1 × | 2 ×, **missed** | `good` |" in text
    assert "load average at the start" in text
    assert "old" not in text


@pytest.mark.usefixtures("two_stages")
def test_the_page_takes_no_part_of_a_run(tmp_path: Path) -> None:
    page, out = page_of(tmp_path), tmp_path / "bench.json"
    before = page.read_text()
    command = ["--out", str(out), "--page", str(page), "--write-page"]
    with pytest.raises(UserError, match="the page takes a whole run"):
        bench.main([*command, "--only", "good"])
    assert not out.exists()
    assert bench.main(["--out", str(out), "--only", "good"]) == 0
    with pytest.raises(UserError, match=r"bench\.json has no broken; run scripts/bench"):
        bench.main([*command, "--report"])
    assert page.read_text() == before


def test_a_part_of_a_run_has_a_file_of_its_own() -> None:
    assert bench.parse_arguments([]).out == bench.OUT
    assert bench.parse_arguments(["--only", "control"]).out == bench.OUT_OF_SOME


def test_unknown_stages_are_refused(tmp_path: Path) -> None:
    with pytest.raises(UserError, match='--only: there is no "nonsense"; they are control, plant'):
        bench.main(["--out", str(tmp_path / "bench.json"), "--only", "control,nonsense"])
    with pytest.raises(UserError, match="is missing; scripts/bench writes it"):
        bench.main(["--out", str(tmp_path / "bench.json"), "--report"])


def test_a_program_that_hangs_is_ended(tmp_path: Path) -> None:
    lab = Lab(out=tmp_path)
    lab.deadline = 0.0
    with pytest.raises(UserError, match="sleep took longer than the stage may"):
        lab.run("sleep", "30")


def test_the_committed_page_has_the_marks_and_no_row_of_a_stage_that_is_gone() -> None:
    text = (ROOT / "docs" / "performance.md").read_text(encoding="utf-8")
    named = set(re.findall(r"\| `([a-z]+)` \|$", text, re.MULTILINE))
    assert named <= {stage.name for stage in bench.STAGES}
    for mark in results.blocks(Run(ORIGIN)):
        assert f"<!-- {mark} -->" in text
