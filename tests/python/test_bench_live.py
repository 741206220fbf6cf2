"""scripts/bench, stage live: histograms put together, verdicts from the programs' files, the section of the page."""

import json
import math
import tomllib
from pathlib import Path

import pytest
from sextant_py.bench import live, live_runs
from sextant_py.bench.figure import MISSED, NOT_JUDGED, OK, PUBLISHED, NotMeasurableError
from sextant_py.bench.google import GoogleResult
from sextant_py.bench.histogram import Histogram
from sextant_py.bench.lab import Lab
from sextant_py.errors import UserError


def histogram_json(*values_ns: int) -> dict:
    return {"buckets": [[value, 1] for value in values_ns], "max_ns": max(values_ns)}


def test_percentiles_are_those_of_the_nearest_rank() -> None:
    histogram = Histogram.of(range(1, 1001))
    assert [histogram.percentile_ns(p) for p in (50.0, 99.0, 99.9, 100.0)] == [500, 990, 999, 1000]
    assert histogram.summary()["max_us"] == 1.0
    assert math.isnan(Histogram().percentile_ns(50.0))


def test_runs_add_up() -> None:
    both = Histogram.from_json(histogram_json(1, 2)) + Histogram.from_json(histogram_json(2, 9))
    assert (both.count, both.max_ns, both.counts[2]) == (4, 9, 2)


def test_the_part_that_is_exceeded_falls_from_one() -> None:
    durations, parts = Histogram.of([1000, 1000, 2000, 4000]).exceeded()
    assert durations == [1.0, 2.0, 4.0]
    assert parts == [1.0, 0.5, 0.25]


@pytest.mark.parametrize(("ours_ns", "verdict"), [(11_000, OK), (11_200, MISSED)])
def test_wake_ups_are_judged_by_the_ratio_of_a_round(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, ours_ns: int, verdict: str
) -> None:
    timing = {"wake_latency": histogram_json(ours_ns)}
    monkeypatch.setattr(live_runs, "ecu", lambda *_, **__: timing)
    monkeypatch.setattr(live_runs, "cyclictest", lambda *_: Histogram.of([10_000]))
    figures = live.wakes(Lab(out=tmp_path), {})
    assert [figure.verdict for figure in figures] == [verdict] * 4


@pytest.mark.parametrize(
    ("ours_ns", "verdict", "accepted"), [(390, OK, False), (392, MISSED, True), (9_000, MISSED, False)]
)
def test_a_body_is_judged_beside_the_empty_loop_of_its_round(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, ours_ns: int, verdict: str, accepted: bool
) -> None:
    asked: list[dict] = []

    def loop(*_: object, **options: float) -> dict:
        asked.append(options)
        return {"body": histogram_json(200)}

    step = {"run_type": "iteration", "run_name": "peer_loop/fixed", "cpu_time": 100.0, "time_unit": "ns"}
    monkeypatch.setattr(live_runs, "ecu", lambda *_, **__: {"body": histogram_json(ours_ns)})
    monkeypatch.setattr(live_runs, "empty_loop", loop)
    monkeypatch.setattr(Lab, "google", lambda *_, **__: GoogleResult({"benchmarks": [step]}))
    distributions: dict[str, Histogram] = {}
    judged, *published = live.body(Lab(out=tmp_path), distributions)
    assert (judged.verdict, judged.is_accepted_miss) == (verdict, accepted)
    assert f"{ours_ns} ns / (200 + 100 ns)" in judged.note
    assert [figure.verdict for figure in published] == [PUBLISHED] * 3
    assert [figure.value for figure in published[1:]] == [ours_ns / 200] * 2
    assert {"tick_lead_us": 6, "busy_ns": ours_ns - 200.0} in asked, "the busy body takes as long as ours"
    assert set(distributions) == set(live.BODIES.values())


def test_the_loops_wait_as_the_drive_does() -> None:
    realtime = tomllib.loads(live_runs.HARD.read_text(encoding="utf-8"))["realtime"]
    assert realtime["tick_lead_us"] == live.TICK_LEAD_US


@pytest.mark.parametrize(("way_us", "verdict"), [(290, OK), (292, MISSED)])
def test_a_command_may_take_a_period_and_the_wake_ups(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, way_us: int, verdict: str
) -> None:
    timing = {
        "command_to_gate": histogram_json(way_us * 1000),
        "where": "native",
        "period_us": 250,
        "command_hand_over": histogram_json(40_000),
        "wake_latency": histogram_json(1_000),
    }
    monkeypatch.setattr(live_runs, "commanded", lambda *_: timing)
    assert [figure.verdict for figure in live.commands(Lab(out=tmp_path), {})] == [verdict] * 2


def test_an_emulated_processor_judges_nothing(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    names = ("command_to_gate", "command_hand_over", "wake_latency")
    timing = {name: histogram_json(1_000) for name in names} | {"where": "qemu", "period_us": 1000}
    monkeypatch.setattr(live_runs, "commanded", lambda *_: timing)
    assert [figure.verdict for figure in live.commands(Lab(out=tmp_path), {})] == [NOT_JUDGED] * 2


def test_without_a_bus_nothing_is_judged(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def no_bus(*_: object) -> dict:
        raise NotMeasurableError("no bus here")

    monkeypatch.setattr(live_runs, "commanded", no_bus)
    figures = live.commands(Lab(out=tmp_path), {})
    assert [(figure.verdict, figure.note) for figure in figures] == [(NOT_JUDGED, "no bus here")] * 2


def test_a_drive_that_fails_on_its_bus_is_missed(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def crash(*_: object) -> dict:
        raise UserError("sextant-ecu failed")

    monkeypatch.setattr(live_runs, "commanded", crash)
    assert [figure.verdict for figure in live.commands(Lab(out=tmp_path), {})] == [MISSED] * 2


@pytest.mark.parametrize(
    ("faults", "status", "verdict", "shown"),
    [(0, 0, OK, "0/0/0/0"), (3, 1, MISSED, "0/0/3/0")],
)
def test_a_count_of_the_audit_is_a_figure(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, faults: int, status: int, verdict: str, shown: str
) -> None:
    program = tmp_path / "audit"
    counts = {"heap allocations": 0, "locks": 0, "page faults": faults, "system calls": 0}
    table = "".join(f"  {name:<18} {n:>6}  {'FOUND' if n else 'ok'}\n" for name, n in counts.items())
    program.write_text(f"#!/bin/sh\ncat <<'END'\n  other counts   7  ok\n{table}END\nexit {status}\n")
    program.chmod(0o755)
    monkeypatch.setattr(live, "AUDIT", program)
    (figure,) = live.audit(Lab(out=tmp_path))
    assert (figure.value, figure.verdict, figure.shown) == (faults, verdict, shown)


def test_an_audit_that_did_not_count_is_missed(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    program = tmp_path / "audit"
    program.write_text("#!/bin/sh\necho '  locks  0  ok'\nexit 1\n")
    program.chmod(0o755)
    monkeypatch.setattr(live, "AUDIT", program)
    assert [figure.verdict for figure in live.audit(Lab(out=tmp_path))] == [MISSED]


def test_every_miss_needs_its_gap(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    timing = {
        "wake_latency": histogram_json(1),
        "misses_without_gap": 1,
        "overruns": 3,
        "misses_by_cause": {"machine stopped us": 2, "own body": 1},
        "periods": 97,
        "periods_skipped": 3,
    }
    monkeypatch.setattr(live_runs, "ecu", lambda *_, **__: timing)
    judged, misses, share = live.spin(Lab(out=tmp_path), {})
    assert judged.verdict == MISSED
    assert "machine stopped us: 2, own body: 1" in judged.note
    assert (misses.value, share.value) == (3, 3.0)


def test_lockstep_runs_that_differ_are_told(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    runs = iter([live_runs.LockstepRun(factor, digest) for factor, digest in ((4.0, "a"), (5.0, "b"), (6.0, "a"))])
    monkeypatch.setattr(live_runs, "lockstep", lambda *_: next(runs))
    factor, digests = live.lockstep(Lab(out=tmp_path))
    assert (factor.value, factor.verdict, digests.verdict) == (5.0, OK, MISSED)


def test_the_section_shows_every_distribution(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text("<!-- latency -->\nold\n<!-- end of latency -->\n", encoding="utf-8")
    summary = Histogram.of([1000, 2500]).summary()
    (tmp_path / live.LATENCIES).write_text(json.dumps({"cyclictest": summary}), encoding="utf-8")
    live.write_latency(page, tmp_path, copy_plot=False)
    assert "old" in page.read_text(encoding="utf-8"), "without the plot the section stays"
    (tmp_path / live.PLOT.name).write_bytes(b"")
    live.write_latency(page, tmp_path, copy_plot=False)
    assert "| cyclictest | 2 | 1 | 2.5 | 2.5 | 2.5 | 2.5 |" in page.read_text(encoding="utf-8")
