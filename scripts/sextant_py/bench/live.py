"""Stage: what the live drive does with its time, beside cyclictest and an empty loop, and the lockstep run."""

import json
import re
import shutil
import statistics
from dataclasses import dataclass
from pathlib import Path

from sextant_py.errors import UserError
from sextant_py.paths import ROOT

from . import deadlines, gates, live_runs
from .figure import Figure, failed, report_unexpected, unmeasured
from .histogram import Histogram
from .lab import Lab, Stage
from .live_plot import draw_latency
from .report import put

PLOT = ROOT / "docs" / "images" / "latency.png"
AUDITED = ("heap allocations", "locks", "page faults", "system calls")
AUDIT_MEASURE = "allocations, locks, page faults and system calls of the control thread"
AUDITS = (  # as scripts/check_control_thread_audit
    ("10⁷ periods, spin mode", ("--periods", "10000000", "--period-us", "5", "--wait", "spin")),
    ("10⁶ periods asleep, beyond clock_nanosleep", ("--periods", "1000000", "--period-us", "25", "--wait", "sleep")),
    (
        "10⁵ periods in spin mode with the plant behind shared memory",
        ("--periods", "100000", "--period-us", "100", "--wait", "spin", "--shared-memory"),
    ),
)
WAKE_ROUNDS, WAKE_SECONDS = 6, 5
BODY_ROUNDS, BODY_SECONDS = 7, 2
BODY_LINES = 197  # a period touches 76 cache lines of data and 121 of code (docs/performance.md)
BODY_ACCEPTED = 25.0  # medians from 11, quiet, to 16, where the hypervisor stopped 0.12 % of the bodies
BODY_BECAUSE = "stops hit a body by its length, and leave 197 cache lines of it cold where an empty loop has a few"
TICK_LEAD_US = 6  # as in configs/ecu_hard.toml
SPIN_SECONDS = 60
LOCKSTEP_RUNS, LOCKSTEP_SECONDS = 3, 10
SPIN = {"control__period_us": 25, "realtime__wait": "spin"}
UNSTAMPED = {**SPIN, "realtime__stage_statistics": "false"}
CVODE = {**SPIN, "plant__integrator": "cvode"}
SHIPPED, ASLEEP, REFERENCE = "hard mode as shipped (hybrid wait)", "hard mode asleep (wait = sleep)", "cyclictest"
WAY = "command to gate, "  # and the bus
GUESTS = {"uml": " of a User Mode Linux guest", "qemu": " of an emulated guest"}
LATENCIES = "latency.json"  # in the folder of the results: every distribution of this stage


def spread(values: list[float]) -> str:
    return f"{min(values):.3g} to {max(values):.3g} in {len(values)} rounds"


def wakes(lab: Lab, distributions: dict[str, Histogram]) -> list[Figure]:
    rounds: list[dict[str, Histogram]] = []
    for number in range(WAKE_ROUNDS):
        shipped = live_runs.ecu(lab, "wake_hybrid", WAKE_SECONDS, realtime__wait="hybrid")
        asleep = live_runs.ecu(lab, "wake_sleep", WAKE_SECONDS, realtime__wait="sleep")
        rounds.append(
            {
                SHIPPED: Histogram.from_json(shipped["wake_latency"]),
                ASLEEP: Histogram.from_json(asleep["wake_latency"]),
                REFERENCE: live_runs.cyclictest(lab, WAKE_SECONDS, 250),
            }
        )
        lab.say(f"wake-ups, round {number + 1} of {WAKE_ROUNDS}")
    for name in (REFERENCE, SHIPPED, ASLEEP):
        distributions[name] = sum((one[name] for one in rounds), Histogram())
    figures = []
    for name in (SHIPPED, ASLEEP):
        for percent, text in ((50.0, "median"), (99.0, "99 %")):
            ratios = [one[name].percentile_ns(percent) / one[REFERENCE].percentile_ns(percent) for one in rounds]
            figures.append(
                Figure(
                    f"wake-up latency at 250 µs, {name} / cyclictest, {text}",
                    statistics.median(ratios),
                    unit="x",
                    at_most=1.1,
                    note=spread(ratios),
                )
            )
    return figures


def body(lab: Lab, distributions: dict[str, Histogram]) -> list[Figure]:
    rounds: list[BodyRound] = []
    for number in range(BODY_ROUNDS):
        rounds.append(body_round(lab))
        lab.say(f"bodies, round {number + 1} of {BODY_ROUNDS}")
    for field, name in BODIES.items():
        distributions[name] = sum((getattr(one, field) for one in rounds), Histogram())
    return [
        body_figure(rounds, "ours", at_most=1.3, accepted_at_most=BODY_ACCEPTED, accepted_because=BODY_BECAUSE),
        body_figure(rounds, "stamped", ", with time stamps by stage"),
        likeness_figure(rounds, "busy", "a loop that computes as long in registers"),
        likeness_figure(rounds, "lines", f"a loop that touches as many cache lines ({BODY_LINES})"),
    ]


@dataclass(frozen=True)
class BodyRound:
    """Everything of one round was measured within the same seconds."""

    ours: Histogram
    stamped: Histogram
    empty: Histogram
    busy: Histogram
    lines: Histogram
    step_ns: float


BODIES = {
    "ours": "body of a 25 µs period",
    "stamped": "the same with time stamps by stage, as shipped",
    "empty": "body of an empty loop",
    "busy": "body of a loop that computes as long in registers",
    "lines": "body of a loop that touches as many cache lines",
}


def body_round(lab: Lab) -> BodyRound:
    def drive(name: str, **values: object) -> Histogram:
        return Histogram.from_json(live_runs.ecu(lab, name, BODY_SECONDS, **values)["body"])

    def loop(**options: float) -> Histogram:
        timing = live_runs.empty_loop(lab, BODY_SECONDS, 25, "spin", tick_lead_us=TICK_LEAD_US, **options)
        return Histogram.from_json(timing["body"])

    ours, empty = drive("body_spin", **UNSTAMPED), loop()
    busy_ns = max(0.0, ours.percentile_ns(50.0) - empty.percentile_ns(50.0))
    step = lab.google("^peer_loop/fixed", "sextant_loop_bench", repetitions=3)
    if not step.has("peer_loop/fixed", "cpu_ns"):
        raise UserError(step.figure("the benchmarked step", "peer_loop/fixed", "cpu_ns").note)
    return BodyRound(
        ours=ours,
        stamped=drive("body_stamped", **SPIN),
        empty=empty,
        busy=loop(busy_ns=busy_ns),
        lines=loop(lines=BODY_LINES),
        step_ns=step.median("peer_loop/fixed", "cpu_ns"),
    )


def p99_9(histogram: Histogram) -> float:
    return histogram.percentile_ns(99.9)


def body_figure(rounds: list[BodyRound], side: str, text: str = "", **options) -> Figure:
    """The measure of the target: the empty loop and the benchmarked step stand below the line."""
    ratios = [p99_9(getattr(one, side)) / (p99_9(one.empty) + one.step_ns) for one in rounds]
    ours_ns = statistics.median(p99_9(getattr(one, side)) for one in rounds)
    empty_ns = statistics.median(p99_9(one.empty) for one in rounds)
    step_ns = statistics.median(one.step_ns for one in rounds)
    measure = f"body of a 25 µs period with plant, spin mode / (empty loop + benchmarked step), 99.9 %{text}"
    note = f"{ours_ns:.0f} ns / ({empty_ns:.0f} + {step_ns:.0f} ns); {spread(ratios)}"
    return Figure(measure, statistics.median(ratios), unit="x", note=note, **options)


def likeness_figure(rounds: list[BodyRound], side: str, text: str) -> Figure:
    """Beside a body that is like ours in one respect and a few lines of code in all others."""
    ratios = [p99_9(one.ours) / p99_9(getattr(one, side)) for one in rounds]
    ours_ns = statistics.median(p99_9(one.ours) for one in rounds)
    theirs_ns = statistics.median(p99_9(getattr(one, side)) for one in rounds)
    measure = f"body of a 25 µs period with plant, spin mode / {text}, 99.9 %"
    note = f"{ours_ns:.0f} ns / {theirs_ns:.0f} ns; {spread(ratios)}"
    return Figure(measure, statistics.median(ratios), unit="x", note=note)


def spin(lab: Lab, distributions: dict[str, Histogram]) -> list[Figure]:
    timing = live_runs.ecu(lab, "spin", SPIN_SECONDS, **SPIN)
    distributions[f"wake-up latency, spin mode at 25 µs, {SPIN_SECONDS} s"] = Histogram.from_json(
        timing["wake_latency"]
    )
    causes = ", ".join(f"{cause}: {count}" for cause, count in timing["misses_by_cause"].items() if count)
    return [
        Figure(
            f"misses without a detected gap, spin mode at 25 µs for {SPIN_SECONDS} s",
            timing["misses_without_gap"],
            at_most=0,
            wanted="0",
            note=f"{timing['overruns']} misses{'; ' + causes if causes else ''}",
        ),
        Figure(f"misses, spin mode at 25 µs for {SPIN_SECONDS} s", timing["overruns"]),
        Figure("part of the periods that were skipped in them", lost_share(timing), unit="%"),
    ]


def lost_share(timing: dict) -> float:
    return 100.0 * timing["periods_skipped"] / max(1, timing["periods"] + timing["periods_skipped"])


def commands(lab: Lab, distributions: dict[str, Histogram]) -> list[Figure]:
    # To the host a guest is one more program: what SCHED_FIFO is worth inside begins with what it is outside.
    guest = () if live_runs.refusal_of_real_time() else ("chrt", "--rr", "5")
    vcan = (*guest, str(ROOT / "scripts" / "with_vcan"), "--time-limit", "300", "--")
    figures = []
    for name, bus, inside in (("vcan", "socketcan:vcan0", vcan), ("udp multicast", live_runs.BUS, ())):
        try:
            timing = live_runs.commanded_beside_cyclictest(lab, f"command_{name.split()[0]}", bus, inside)
        except UserError as error:
            figures.append(failed(command_measure(name), error))
            continue
        figures += command_figures(name, timing, distributions)
    return figures


def command_measure(bus: str) -> str:
    return f"CAN frame received to first gate pattern / (one period + own wake-ups), 99 %, {bus}"


def command_figures(bus: str, timing: dict, distributions: dict[str, Histogram]) -> list[Figure]:
    """Of one commanded run. What is allowed comes from elsewhere than what is judged: the wake-up of the control thread
    from its deadlines, that of the receive thread from cyclictest in its place."""
    measure = command_measure(bus)
    way, hand_over, wake = (
        Histogram.from_json(timing[key]) for key in ("command_to_gate", "command_hand_over", "wake_latency")
    )
    reference: Histogram = timing["reference"]
    emulated = timing["where"] == "qemu"  # its times are not a machine's
    if hand_over.count == 0:
        why = f"no command was accepted: {timing['ended_early'] or 'none came'}"
        return [unmeasured(measure, why) if emulated else failed(measure, why)]
    if way.count == 0:
        return [failed(measure, f"of {hand_over.count} accepted commands none was seen in a gate pattern")]
    if reference.count == 0:
        return [unmeasured(measure, "cyclictest counted nothing beside it")]
    for text, histogram in (
        (WAY.rstrip(", "), way),
        ("of it until the receive thread has handed it over", hand_over),
        ("cyclictest in the receive thread's place beside it", reference),
        ("wake-up of the control thread beside it", wake),
    ):
        distributions[f"{text}, {bus}{GUESTS.get(timing['where'], '')}"] = histogram
    # A command comes at any time. But what stops a guest stops the vehicle in it as well.
    met = wake.by_time(timing["period_us"] * 1000) if timing["where"] == "native" else wake
    sides = (way, hand_over, reference, met)
    way_us, hand_over_us, reference_us, wake_us = (side.percentile_ns(99.0) * 1e-3 for side in sides)
    note = f"{way.count} frames; {way_us:.0f} / ({timing['period_us']} + {reference_us:.0f} + {wake_us:.1f}) µs"
    if timing["ended_early"]:
        note += f"; {timing['ended_early']}"
    if emulated:
        return [unmeasured(measure, f"in a guest with an emulated processor, asleep at 1 ms: {note}")]
    return [
        Figure(
            measure,
            way_us / (timing["period_us"] + reference_us + wake_us),
            unit="x",
            at_most=1.0,
            note=note,
            accepted_at_most=1.25,
            accepted_because="to take a frame from the socket, check and decode it is work besides the wake-up",
        ),
        Figure(
            f"of it the receive thread's part / wake-up of cyclictest in its place, 99 %, {bus}",
            hand_over_us / reference_us,
            unit="x",
            note=f"{hand_over_us:.0f} / {reference_us:.0f} µs; socket, checks and decoding are in it",
        ),
    ]


def cvode(lab: Lab, distributions: dict[str, Histogram]) -> list[Figure]:
    """The adaptive integrator in a live period of 25 µs, while commands are followed. Its time has no bound, so that
    the longest counts; the catching up after a stop of the machine is in it."""
    timing = live_runs.commanded(lab, "cvode", live_runs.BUS, (), *live_runs.settings(**CVODE))
    body = Histogram.from_json(timing["body"])
    name = "a 25 µs period that integrates with CVODE, following commands"
    distributions[f"body of {name}"] = body
    p50_us, p99_9_us = (body.percentile_ns(percent) * 1e-3 for percent in (50.0, 99.9))
    note = f"{body.count} wake-ups; median {p50_us:.3g} µs, 99.9 % {p99_9_us:.3g} µs"
    if timing["ended_early"]:
        note += f"; {timing['ended_early']}"
    return [
        Figure(f"longest body of {name}", body.max_ns * 1e-3, unit="µs", note=note),
        Figure("part of these bodies that took longer than the period", 100.0 * body.part_above(25_000), unit="%"),
        Figure("part of the periods that were skipped in that run", lost_share(timing), unit="%"),
    ]


def audit(lab: Lab) -> list[Figure]:
    figures = []
    for name, options in AUDITS:
        lab.say(f"audit, {name}")
        try:
            figures.append(audited(lab, f"{AUDIT_MEASURE}, {name}", options))
        except UserError as error:  # of the other runs the figures still count
            figures.append(failed(f"{AUDIT_MEASURE}, {name}", error))
    return figures


def audited(lab: Lab, measure: str, options: tuple[str, ...]) -> Figure:
    text = lab.run(lab.audit, *options, accept=(0, 1))
    if "(memory is not locked)" in text:
        return unmeasured(measure, "memory cannot be locked here; scripts/rt_check says how to get it")
    lines = [re.search(rf"^  {name} +(\d+)  (?:ok|FOUND)", text, re.MULTILINE) for name in AUDITED]
    if not all(lines):
        return failed(measure, f"it says: {text.strip()[-200:]}")
    counts = [int(line[1]) for line in lines]
    return Figure(measure, sum(counts), at_most=0, wanted="0", text="/".join(map(str, counts)))


def lockstep(lab: Lab) -> list[Figure]:
    runs = [live_runs.lockstep(lab, number, LOCKSTEP_SECONDS) for number in range(LOCKSTEP_RUNS)]
    factors = [run.realtime_factor for run in runs]
    return [
        Figure(
            "lockstep HIL at 25 µs, both processes on two processors: virtual / real time",
            statistics.median(factors),
            unit="x",
            at_least=2.0,
            note=spread(factors),
        ),
        Figure(
            "lockstep HIL: digests that differ from the first run's",
            len({run.digest for run in runs}) - 1,
            at_most=0,
            wanted="0",
            note=" ".join(sorted({run.digest for run in runs})),
        ),
    ]


def live(lab: Lab) -> list[Figure]:
    lab.out.mkdir(parents=True, exist_ok=True)
    distributions: dict[str, Histogram] = {}
    figures: list[Figure] = []
    for name, part in (
        ("wake-ups", lambda: wakes(lab, distributions)),
        ("body", lambda: body(lab, distributions)),
        ("spin mode", lambda: spin(lab, distributions)),
        ("commands", lambda: commands(lab, distributions)),
        ("CVODE", lambda: cvode(lab, distributions)),
        ("audit", lambda: audit(lab)),
        ("gates of a killed drive", lambda: gates.killed(lab)),
        ("gates of a drive that hangs", lambda: gates.hung(lab)),
        ("gates behind a wire that is cut", lambda: deadlines.cut(lab)),
        ("deadlines", lambda: deadlines.deadlines(lab)),
        ("lockstep", lambda: lockstep(lab)),
    ):
        lab.say(name)
        try:
            figures += part()
        except Exception as error:  # of the other parts the figures still count
            report_unexpected(error)
            figures.append(failed(f"live: {name}", error))
    summaries = {name: histogram.summary() for name, histogram in distributions.items() if histogram.count}
    (lab.out / LATENCIES).write_text(json.dumps(summaries, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    draw_latency(
        {name: distributions[name] for name in (REFERENCE, SHIPPED, ASLEEP) if name in distributions},
        {name.removeprefix(WAY): shown for name, shown in distributions.items() if name.startswith(WAY)},
        lab.out / PLOT.name,
    )
    return figures


def latency_section(summaries: dict[str, dict[str, float]]) -> str:
    """The text of the page between the marks `latency`."""
    lines = [
        "| [µs] | samples | median | 99 % | 99.9 % | 99.99 % | longest |",
        "| --- | ---: | ---: | ---: | ---: | ---: | ---: |",
    ]
    for name, summary in summaries.items():
        values = [f"{summary[key]:.3g}" for key in ("p50_us", "p99_us", "p99.9_us", "p99.99_us")]
        lines.append(f"| {name} | {summary['count']} | {' | '.join(values)} | {summary['max_us']:.4g} |")
    return "\n".join(
        [
            *lines,
            "",
            f"![Wake-up latency beside cyclictest, and command to gate](images/{PLOT.name})",
            "",
            "*Left: the part of the wake-ups that came later than so many microseconds. Right: the same for the time"
            " from the arrival of a command's frame, as the kernel stamped it, to the first gate pattern that was"
            " decided with it.*",
        ]
    )


def write_latency(page: Path, results: Path, copy_plot: bool) -> None:
    """The section of the page, from the files of the stage's last run; without them it stays."""
    file, plot = results / LATENCIES, results / PLOT.name
    if not (file.exists() and plot.exists()):
        return
    section = latency_section(json.loads(file.read_text(encoding="utf-8")))
    page.write_text(put(page.read_text(encoding="utf-8"), "latency", section), encoding="utf-8")
    if copy_plot:
        shutil.copyfile(plot, PLOT)


LIVE = Stage("live", "the live drive: wake-ups, work, commands, audit, gates, deadlines, lockstep", 510, live)
