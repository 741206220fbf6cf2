"""scripts/bench, stage live: histograms put together, verdicts from the programs' files, the section of the page."""

import json
import math
import os
import subprocess
import tomllib
from pathlib import Path

import pytest
from sextant_py.bench import commanded_run, deadlines, gates, live, live_runs
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


@pytest.mark.parametrize("where", ["native", "uml"])
@pytest.mark.parametrize(("way_us", "verdict"), [(290, OK), (292, MISSED)])
def test_a_command_may_take_a_period_and_the_wake_ups(way_us: int, verdict: str, where: str) -> None:
    distributions: dict[str, Histogram] = {}
    judged, own_part = live.command_figures("vcan", commanded(way_us, where=where), distributions)
    assert (judged.verdict, own_part.verdict) == (verdict, PUBLISHED)
    assert len(distributions) == 4
    assert all(("User Mode Linux" in name) == (where == "uml") for name in distributions)


def test_a_slow_receive_thread_does_not_excuse_itself() -> None:
    judged, own_part = live.command_figures("vcan", commanded(900, hand_over_us=800), {})
    assert (judged.verdict, judged.is_accepted_miss) == (MISSED, False)
    assert own_part.value == pytest.approx(20.0)
    reading, _ = live.command_figures("vcan", commanded(330, hand_over_us=80), {})
    assert (reading.verdict, reading.is_accepted_miss) == (MISSED, True)


def test_a_stop_of_the_guest_stops_its_vehicle_too() -> None:
    # Ten commands would have come in the stop, had the vehicle run on.
    stopped = {"wake_latency": {"buckets": [[0, 400], [100_000_000, 1]], "max_ns": 100_000_000}}
    native, _ = live.command_figures("vcan", commanded(900, **stopped), {})
    guest, _ = live.command_figures("vcan", commanded(900, where="uml", **stopped), {})
    assert (native.verdict, guest.verdict) == (OK, MISSED)


def test_commands_that_reach_no_gate_pattern_are_missed_wherever_it_was() -> None:
    for where in ("native", "uml", "qemu"):
        (figure,) = live.command_figures("vcan", commanded(None, where=where), {})
        assert (figure.verdict, figure.note) == (MISSED, "of 1 accepted commands none was seen in a gate pattern")


def test_a_drive_that_accepts_nothing_is_missed_and_only_an_emulated_one_is_excused() -> None:
    for where, verdict in (("native", MISSED), ("uml", MISSED), ("qemu", NOT_JUDGED)):
        timing = commanded(None, hand_over_us=None, where=where, ended_early="no answer")
        (figure,) = live.command_figures("vcan", timing, {})
        assert (figure.verdict, figure.note) == (verdict, "no command was accepted: no answer")


def test_an_emulated_processor_judges_nothing_but_shows_its_distribution() -> None:
    distributions: dict[str, Histogram] = {}
    (figure,) = live.command_figures("vcan", commanded(1, where="qemu", period_us=1000), distributions)
    assert figure.verdict == NOT_JUDGED
    assert "command to gate, vcan of an emulated guest" in distributions


def test_a_late_wake_up_counts_for_as_long_as_it_was_waited_for() -> None:
    # A hundred periods of 250 µs in time and one that took 2 750 µs: a tenth of the time.
    wake = Histogram.of([0] * 100 + [2_500_000])
    assert wake.percentile_ns(99.0) == 0
    assert wake.by_time(250_000).percentile_ns(90.0) == 0
    assert wake.by_time(250_000).percentile_ns(91.0) == 2_500_000


class Bus:
    """One on which the drive is in this state, or silent."""

    def __init__(self, state: str | None) -> None:
        self.state = lambda: state
        self.start = self.stop = self.shutdown = lambda: None


@pytest.mark.parametrize(("state", "answers"), [("STANDBY", True), (None, False)])
def test_the_vehicle_waits_until_the_drive_is_heard(
    monkeypatch: pytest.MonkeyPatch, state: str | None, answers: bool
) -> None:
    monkeypatch.setattr(commanded_run.can_bus, "open_bus", lambda _: Bus(state))
    monkeypatch.setattr(commanded_run, "Reports", lambda bus, _: bus)
    with subprocess.Popen(["sleep", "60"]) as drive:
        assert commanded_run.drive_answers("socketcan:vcan0", drive, 0.1) is answers
        commanded_run.leave(drive)
    if state is None:
        with pytest.raises(UserError, match="ended at once"):
            commanded_run.drive_answers("socketcan:vcan0", drive, 10.0)


def told(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, **answer: object) -> dict:
    """What `commanded` makes of the last line of a run that wrote no timing."""
    (tmp_path / "one.json").unlink(missing_ok=True)

    def run(*_: object) -> str:
        (tmp_path / "one.json").write_text('{"body": 1}')
        return "something else\n" + json.dumps({"where": "native", "refused": "", "answered": True} | answer)

    lab = Lab(out=tmp_path)
    monkeypatch.setattr(lab, "run", run)
    return live_runs.commanded(lab, "one", "udp_multicast:239.0.0.1")


def test_a_run_tells_why_there_is_no_timing(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    assert told(monkeypatch, tmp_path)["body"] == 1
    with pytest.raises(NotMeasurableError, match="SCHED_FIFO is refused"):
        told(monkeypatch, tmp_path, refused="SCHED_FIFO is refused here")
    with pytest.raises(NotMeasurableError, match="was not heard"):
        told(monkeypatch, tmp_path, where="qemu", answered=False)
    with pytest.raises(UserError, match="was not heard") as found:
        told(monkeypatch, tmp_path, where="uml", answered=False)
    assert not isinstance(found.value, NotMeasurableError)


def test_without_rights_nothing_is_judged(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(live_runs, "refusal_of_real_time", lambda: "SCHED_FIFO is refused here")
    lab = Lab(out=tmp_path)
    monkeypatch.setattr(lab, "run", lambda *_, **__: pytest.fail("it ran all the same"))
    parts = (
        lambda: live.wakes(lab, {}),
        lambda: live.body(lab, {}),
        lambda: live.spin(lab, {}),
        lambda: gates.killed(lab),
    )
    for part in parts:
        with pytest.raises(NotMeasurableError, match="SCHED_FIFO is refused here"):
            part()


@pytest.mark.parametrize(
    ("message", "kind"),
    [
        ("Unable to change scheduling policy! either run as root", NotMeasurableError),
        ("ERROR: mlockall: Cannot allocate memory", NotMeasurableError),
        ("unrecognized option '--nsecs'", UserError),
    ],
)
def test_a_refusal_of_cyclictest_is_not_judged(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, message: str, kind: type
) -> None:
    program = tmp_path / "cyclictest"
    program.write_text(f'#!/bin/sh\necho "{message}" >&2\nexit 1\n')
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:{os.environ['PATH']}")
    with pytest.raises(UserError) as found:
        live_runs.cyclictest(Lab(out=tmp_path), 1, 250)
    assert type(found.value) is kind


def test_without_a_bus_nothing_is_judged(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def no_bus(*_: object) -> dict:
        raise NotMeasurableError("no bus here")

    monkeypatch.setattr(live_runs, "commanded_beside_cyclictest", no_bus)
    figures = live.commands(Lab(out=tmp_path), {})
    assert [(figure.verdict, figure.note) for figure in figures] == [(NOT_JUDGED, "no bus here")] * 2


def test_a_drive_that_fails_on_its_bus_is_missed(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def crash(*_: object) -> dict:
        raise UserError("sextant-ecu failed")

    monkeypatch.setattr(live_runs, "commanded_beside_cyclictest", crash)
    assert [figure.verdict for figure in live.commands(Lab(out=tmp_path), {})] == [MISSED] * 2


@pytest.mark.parametrize(
    ("faults", "status", "verdict", "shown"),
    [(0, 0, OK, "0/0/0/0"), (3, 1, MISSED, "0/0/3/0")],
)
def test_a_count_of_the_audit_is_a_figure(tmp_path: Path, faults: int, status: int, verdict: str, shown: str) -> None:
    program = tmp_path / "audit"
    counts = {"heap allocations": 0, "locks": 0, "page faults": faults, "system calls": 0}
    table = "".join(f"  {name:<18} {n:>6}  {'FOUND' if n else 'ok'}\n" for name, n in counts.items())
    program.write_text(f"#!/bin/sh\ncat <<'END'\n  other counts   7  ok\n{table}END\nexit {status}\n")
    program.chmod(0o755)
    figures = live.audit(Lab(audit=program, out=tmp_path))
    assert [(f.value, f.verdict, f.shown) for f in figures] == [(faults, verdict, shown)] * 3
    assert "asleep" in figures[1].measure


def test_an_audit_that_did_not_count_is_missed(tmp_path: Path) -> None:
    program = tmp_path / "audit"
    program.write_text("#!/bin/sh\necho '  locks  0  ok'\nexit 1\n")
    program.chmod(0o755)
    assert [figure.verdict for figure in live.audit(Lab(audit=program, out=tmp_path))] == [MISSED] * 3
    gone = live.audit(Lab(audit=tmp_path / "gone", out=tmp_path))
    assert [figure.verdict for figure in gone] == [MISSED] * 3


def test_page_faults_without_locked_memory_are_not_judged(tmp_path: Path) -> None:
    program = tmp_path / "audit"
    program.write_text("#!/bin/sh\necho '  page faults  3  FOUND (memory is not locked)'\nexit 1\n")
    program.chmod(0o755)
    assert [figure.verdict for figure in live.audit(Lab(audit=program, out=tmp_path))] == [NOT_JUDGED] * 3


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


def test_the_worst_period_with_cvode_is_shown(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    asked = []

    def run(_: Lab, *arguments: object) -> dict:
        asked.extend(arguments)
        body = histogram_json(2_000, 3_000, 26_000, 31_000)
        return {"body": body, "periods": 95, "periods_skipped": 5, "ended_early": ""}

    monkeypatch.setattr(live_runs, "commanded", run)
    distributions: dict[str, Histogram] = {}
    longest, late, lost = live.cvode(Lab(out=tmp_path), distributions)
    assert "plant.integrator=cvode" in asked
    assert (longest.value, late.value, lost.value) == (31.0, 50.0, 5.0)
    assert [figure.verdict for figure in (longest, late, lost)] == [PUBLISHED] * 3
    assert len(distributions) == 1


def test_openings_are_read_by_their_cause() -> None:
    text = (
        "01:00 warning gates stay open since 12.500100 s: the drive is silent; last pattern at 12.499850 s, 0.250 ms"
        " before, seen at 12.505000 s\n"
        "01:00 warning gates stay open since 13.000000 s: the gate-enable line is off; last pattern at 12.999000 s,"
        " 1.000 ms before, seen at 13.000250 s\n"
        "gates are open as from the start: the drive is silent\n"
    )
    assert gates.openings_ns(text, gates.SILENT) == [(12_500_100_000, 12_505_000_000)]
    assert gates.openings_ns(text, gates.LINE_OFF) == [(13_000_000_000, 13_000_250_000)]


@pytest.mark.parametrize(("late_ms", "verdict"), [(9.9, OK), (10.1, MISSED)])
def test_gates_are_judged_by_the_median_round(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, late_ms: float, verdict: str
) -> None:
    monkeypatch.setattr(live_runs, "refusal_of_real_time", lambda: "")
    times = iter([1.0, 2.0, late_ms, 50.0, 60.0])
    monkeypatch.setattr(gates, "opening_ms", lambda *_, **__: next(times))
    (figure,) = gates.killed(Lab(out=tmp_path))
    assert (figure.value, figure.verdict) == (late_ms, verdict)


def test_a_watchdog_needs_a_processor_of_its_own(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(live_runs, "refusal_of_real_time", lambda: "")
    monkeypatch.setattr(gates.os, "sched_getaffinity", lambda _: {0})
    with pytest.raises(NotMeasurableError, match="second processor"):
        gates.hung(Lab(out=tmp_path))


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


@pytest.mark.parametrize(
    ("which", "value", "verdict"),
    [
        (0, 9.9, OK),
        (0, 10.1, MISSED),
        (1, 60.0, OK),
        (1, 60.1, MISSED),
        (2, 199.9, MISSED),
        (2, 200.4, OK),
        (2, 205.1, MISSED),
        (3, 100.0, OK),
        (3, 100.1, MISSED),
    ],
)
def test_deadlines_are_judged_by_the_median_round(which: int, value: float, verdict: str) -> None:
    sound = [5.0, 50.0, 200.5, 40.0]
    judged, far = ([*sound[:which], middle, *sound[which + 1 :]] for middle in (value, 300.0))
    early = [*sound[:which], 0.0, *sound[which + 1 :]]
    found = deadlines.figures([deadlines.Round(*one) for one in (early, far, judged)])
    assert [figure.verdict for figure in found] == [verdict if n == which else OK for n in range(4)]


def test_nobody_but_root_cuts_a_wire(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(live_runs, "refusal_of_real_time", lambda: "")
    monkeypatch.setattr(deadlines.os, "geteuid", lambda: 1000)
    with pytest.raises(NotMeasurableError, match="root"):
        deadlines.cut(Lab(out=tmp_path))
