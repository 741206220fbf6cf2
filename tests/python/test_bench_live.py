"""scripts/bench, stage live: histograms put together, verdicts from the programs' files, the section of the page."""

import json
import math
import os
import tomllib
from collections.abc import Callable
from pathlib import Path

import pytest
from sextant_py.errors import UserError
from studies.bench import gates, live, live_runs
from studies.bench.figure import MET, MISSED, NOT_MEASURED, PUBLISHED, Figure, NotMeasurableError
from studies.bench.google import GoogleResult
from studies.bench.histogram import Histogram
from studies.bench.lab import Lab


def measured(part: str, measure: Callable[[], gates.Values]) -> dict[str, Figure]:
    """The figures of a part by the names of its table."""
    return dict(zip(live.TABLE[part], live.figures_of(part, measure), strict=True))


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


@pytest.mark.parametrize(("ours_ns", "verdict"), [(11_000, MET), (11_200, MISSED)])
def test_wake_ups_are_judged_by_the_ratio_of_a_round(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, ours_ns: int, verdict: str
) -> None:
    timing = {"wake_latency": histogram_json(ours_ns)}
    monkeypatch.setattr(live_runs, "ecu", lambda *_, **__: timing)
    monkeypatch.setattr(live_runs, "cyclictest", lambda *_: Histogram.of([10_000]))
    figures = measured("wake-ups", live.LiveLab(Lab(out=tmp_path)).wakes)
    assert [figure.verdict for figure in figures.values()] == [verdict] * 4


def test_a_body_is_compared_with_the_loops_of_its_round(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    ours_ns = 390
    asked: list[dict] = []

    def loop(*_: object, **options: float) -> dict:
        asked.append(options)
        return {"execution": histogram_json(200)}

    step = {"run_type": "iteration", "run_name": "peer_loop/fixed", "cpu_time": 100.0, "time_unit": "ns"}
    monkeypatch.setattr(live_runs, "ecu", lambda *_, **__: {"execution": histogram_json(ours_ns)})
    monkeypatch.setattr(live_runs, "empty_loop", loop)
    monkeypatch.setattr(Lab, "google", lambda *_, **__: GoogleResult({"benchmarks": [step]}))
    own = live.LiveLab(Lab(out=tmp_path))
    ours, stamped, *others = measured("execution", own.execution).values()
    assert ours.value == stamped.value == ours_ns / (200 + 100)
    assert "390 ns / (200 + 100 ns)" in ours.note
    assert [figure.value for figure in others] == [ours_ns / 200] * 2
    assert {figure.verdict for figure in (ours, stamped, *others)} == {PUBLISHED}
    assert {"tick_lead_us": 6, "busy_ns": ours_ns - 200.0} in asked, "the busy body takes as long as ours"
    assert set(own.shapes) == set(live.EXECUTIONS.values())


def test_the_loops_wait_as_the_drive_does() -> None:
    realtime = tomllib.loads(live_runs.HARD.read_text(encoding="utf-8"))["realtime"]
    assert realtime["tick_lead_us"] == live.TICK_LEAD_US


def commanded(way_us: float | None, hand_over_us: float | None = 40.0, **told: object) -> dict:
    def histogram(value_us: float | None) -> dict:
        return {"buckets": [], "max_ns": 0} if value_us is None else histogram_json(round(value_us * 1000))

    return {
        "command_to_gate": histogram(way_us),
        "command_hand_over": histogram(hand_over_us),
        "wake_latency": histogram_json(1_000),
        "reference": Histogram.of([40_000]),
        "where": "native",
        "period_us": 250,
        "ended_early": "",
    } | told


def judged(timing: dict, own: live.LiveLab | None = None) -> list[Figure]:
    own = own or live.LiveLab(Lab())
    return list(measured("commands by vcan", lambda: own.evaluate_commands("vcan", timing)).values())


@pytest.mark.parametrize("where", ["native", "uml"])
@pytest.mark.parametrize(("way_us", "verdict"), [(290, MET), (292, MISSED)])
def test_a_command_may_take_a_period_and_the_wake_ups(way_us: int, verdict: str, where: str) -> None:
    own = live.LiveLab(Lab())
    way, own_part = judged(commanded(way_us, where=where), own)
    assert (way.verdict, own_part.verdict) == (verdict, PUBLISHED)
    assert len(own.shapes) == 4
    assert all(("User Mode Linux" in name) == (where == "uml") for name in own.shapes)


def test_a_slow_receive_thread_does_not_excuse_itself() -> None:
    way, own_part = judged(commanded(900, hand_over_us=800))
    assert way.verdict == MISSED
    assert own_part.value == pytest.approx(20.0)


def test_a_stop_of_the_guest_stops_its_vehicle_too() -> None:
    # Ten commands would have come in the stop, had the vehicle run on.
    stopped = {"wake_latency": {"buckets": [[0, 400], [100_000_000, 1]], "max_ns": 100_000_000}}
    native, _ = judged(commanded(900, **stopped))
    guest, _ = judged(commanded(900, where="uml", **stopped))
    assert (native.verdict, guest.verdict) == (MET, MISSED)


def test_a_late_wake_up_counts_for_as_long_as_it_was_waited_for() -> None:
    # A hundred periods of 250 µs in time and one that took 2 750 µs: a tenth of the time.
    wake = Histogram.of([0] * 100 + [2_500_000])
    assert wake.percentile_ns(99.0) == 0
    assert wake.by_time(250_000).percentile_ns(90.0) == 0
    assert wake.by_time(250_000).percentile_ns(91.0) == 2_500_000


def test_commands_that_reach_no_gate_pattern_are_missed_wherever_it_was() -> None:
    for where in ("native", "uml", "qemu"):
        way, _ = judged(commanded(None, where=where))
        assert (way.verdict, way.note) == (MISSED, "of 1 accepted commands none was seen in a gate pattern")


def test_a_drive_that_accepts_nothing_is_missed() -> None:
    way, _ = judged(commanded(None, hand_over_us=None, ended_early="no answer"))
    assert (way.verdict, way.note) == (MISSED, "no command was accepted: no answer")


def test_an_emulated_processor_has_no_verdict_but_shows_its_distribution() -> None:
    own = live.LiveLab(Lab())
    way, _ = judged(commanded(1, where="qemu", period_us=1000), own)
    assert way.verdict == NOT_MEASURED
    assert "command to gate, vcan of an emulated guest" in own.shapes


def told(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, **answer: object) -> dict:
    """What `commanded` makes of the last line of a run, and of what it left."""

    def run(*_: object) -> str:
        (tmp_path / "one.json").write_text('{"execution": 1}')
        (tmp_path / "one.cyclictest").write_text("   0:       0:      7\n   0:       1:     9\n")
        return "something else\n" + json.dumps({"where": "native", "refused": ""} | answer)

    lab = Lab(out=tmp_path)
    monkeypatch.setattr(lab, "run", run)
    return live_runs.commanded(lab, "one", "udp_multicast:239.0.0.1")


def test_a_run_tells_why_there_is_no_timing(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    timing = told(monkeypatch, tmp_path)
    assert (timing["execution"], timing["reference"].counts) == (1, {7: 1, 9: 1})
    with pytest.raises(NotMeasurableError, match="SCHED_FIFO is refused"):
        told(monkeypatch, tmp_path, refused="SCHED_FIFO is refused here")


def test_without_rights_nothing_is_measured(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(live_runs, "refusal_of_real_time", lambda: "SCHED_FIFO is refused here")
    lab = Lab(out=tmp_path)
    monkeypatch.setattr(lab, "run", lambda *_, **__: pytest.fail("it ran all the same"))
    own = live.LiveLab(lab)
    parts = {"wake-ups": own.wakes, "execution": own.execution, "spin mode": own.spin}
    for name, part in (parts | {"gates of a killed drive": lambda: gates.killed(lab)}).items():
        for figure in measured(name, part).values():
            assert (figure.verdict, figure.note) == (NOT_MEASURED, "SCHED_FIFO is refused here")


@pytest.mark.parametrize(
    ("message", "kind"),
    [
        ("Unable to change scheduling policy! either run as root", NotMeasurableError),
        ("ERROR: mlockall: Cannot allocate memory", NotMeasurableError),
        ("unrecognized option '--nsecs'", UserError),
    ],
)
def test_a_refusal_of_cyclictest_is_not_measured(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, message: str, kind: type
) -> None:
    program = tmp_path / "cyclictest"
    program.write_text(f'#!/bin/sh\necho "{message}" >&2\nexit 1\n')
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:{os.environ['PATH']}")
    with pytest.raises(UserError) as found:
        live_runs.cyclictest(Lab(out=tmp_path), 1, 250)
    assert type(found.value) is kind


@pytest.mark.parametrize(
    ("error", "verdict"),
    [(NotMeasurableError("no bus"), NOT_MEASURED), (UserError("it failed"), MISSED), (KeyError("gone"), MISSED)],
)
def test_a_part_that_fails_shows_all_its_figures_so(error: Exception, verdict: str) -> None:
    def part() -> gates.Values:
        raise error

    figures = live.figures_of("commands by vcan", part)
    assert [figure.measure for figure in figures] == [row.measure for row in live.TABLE["commands by vcan"].values()]
    assert {figure.verdict for figure in figures} == {verdict}
    assert all(str(error.args[0]) in figure.note for figure in figures)


def test_every_miss_needs_its_gap(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    timing = {
        "wake_latency": histogram_json(1),
        "overruns_without_gap": 1,
        "overruns": 3,
        "overruns_by_cause": {"machine gap": 2, "own execution": 1},
        "periods": 97,
        "periods_missed": 3,
    }
    monkeypatch.setattr(live_runs, "ecu", lambda *_, **__: timing)
    own, overruns, share = measured("spin mode", live.LiveLab(Lab(out=tmp_path)).spin).values()
    assert own.verdict == MISSED
    assert "3 overruns; machine gap: 2, own execution: 1" in own.note
    assert (overruns.value, share.value) == (3, 3.0)


def test_the_worst_period_with_cvode_is_shown(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    asked = []

    def run(_: Lab, *arguments: object) -> dict:
        asked.extend(arguments)
        execution = histogram_json(2_000, 3_000, 26_000, 31_000)
        return {"execution": execution, "periods": 95, "periods_missed": 5, "ended_early": ""}

    monkeypatch.setattr(live_runs, "commanded", run)
    own = live.LiveLab(Lab(out=tmp_path))
    longest, late, lost = measured("CVODE", own.cvode).values()
    assert "plant.integrator=cvode" in asked
    assert (longest.value, late.value, lost.value) == (31.0, 50.0, 5.0)
    assert [figure.verdict for figure in (longest, late, lost)] == [PUBLISHED] * 3
    assert len(own.shapes) == 1


def test_gates_off_is_read_by_its_cause() -> None:
    text = (
        "01:00 warning gates stay off since 12.500100 s: the drive has timed out; last pattern at 12.499850 s, 0.250 ms"
        " before, seen at 12.505000 s\n"
        "01:00 warning gates stay off since 13.000000 s: the gate-enable line is off; last pattern at 12.999000 s,"
        " 1.000 ms before, seen at 13.000250 s\n"
        "gates are off as from the start: the drive has timed out\n"
    )
    assert gates.gates_off_ns(text, gates.TIMED_OUT) == [(12_500_100_000, 12_505_000_000)]
    assert gates.gates_off_ns(text, gates.LINE_OFF) == [(13_000_000_000, 13_000_250_000)]


@pytest.mark.parametrize(("late_ms", "verdict"), [(9.9, MET), (10.1, MISSED)])
def test_gates_have_the_verdict_of_the_median_round(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, late_ms: float, verdict: str
) -> None:
    monkeypatch.setattr(live_runs, "refusal_of_real_time", lambda: "")
    times = iter([1.0, 2.0, late_ms, 50.0, 60.0])
    monkeypatch.setattr(gates, "gates_off_ms", lambda *_, **__: next(times))
    figure = measured("gates of a killed drive", lambda: gates.killed(Lab(out=tmp_path)))["killed"]
    assert (figure.value, figure.verdict) == (late_ms, verdict)


def test_a_watchdog_needs_a_processor_of_its_own(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(live_runs, "refusal_of_real_time", lambda: "")
    monkeypatch.setattr(gates.os, "sched_getaffinity", lambda _: {0})
    with pytest.raises(NotMeasurableError, match="second processor"):
        gates.hung(Lab(out=tmp_path))


def test_lockstep_runs_that_differ_are_told(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    runs = iter(((4.0, "a"), (5.0, "b"), (6.0, "a")))
    monkeypatch.setattr(live_runs, "lockstep", lambda *_: next(runs))
    factor, digests = measured("lockstep", live.LiveLab(Lab(out=tmp_path)).lockstep).values()
    assert (factor.value, factor.verdict, digests.verdict) == (5.0, MET, MISSED)


@pytest.mark.parametrize(
    ("which", "value", "verdict"),
    [
        (0, 9.9, MET),
        (0, 10.1, MISSED),
        (1, 60.0, MET),
        (1, 60.1, MISSED),
        (2, 199.9, MISSED),
        (2, 200.4, MET),
        (2, 205.1, MISSED),
        (3, 100.0, MET),
        (3, 100.1, MISSED),
    ],
)
def test_deadlines_are_judged_by_the_median_round(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, which: int, value: float, verdict: str
) -> None:
    sound, names = [5.0, 50.0, 200.5, 40.0], list(live.TABLE["deadlines"])
    middle, far, early = ([*sound[:which], one, *sound[which + 1 :]] for one in (value, 300.0, 0.0))
    rounds = iter([dict(zip(names, one, strict=True)) for one in (early, far, middle, far, early)])
    monkeypatch.setattr(live_runs, "refusal_of_real_time", lambda: "")
    monkeypatch.setattr(gates, "deadline_round", lambda _: next(rounds))
    found = measured("deadlines", lambda: gates.deadlines(Lab(out=tmp_path))).values()
    assert [figure.verdict for figure in found] == [verdict if n == which else MET for n in range(4)]


def test_nobody_but_root_cuts_a_wire(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(live_runs, "refusal_of_real_time", lambda: "")
    monkeypatch.setattr(gates.os, "geteuid", lambda: 1000)
    with pytest.raises(NotMeasurableError, match="root"):
        gates.cut(Lab(out=tmp_path))
