"""Stage: what the live drive does with its time, beside cyclictest and an empty loop, and the lockstep run."""

import json
import re
import shutil
import statistics
from dataclasses import dataclass
from pathlib import Path

from sextant_py.errors import UserError
from sextant_py.paths import ROOT

from . import live_runs
from .figure import Figure, failed, unmeasured
from .histogram import Histogram
from .lab import Lab, Stage
from .live_plot import draw_latency
from .report import put

PLOT = ROOT / "docs" / "images" / "latency.png"
AUDIT = ROOT / "build" / "dev" / "tests" / "audit" / "sextant_control_thread_audit"
AUDIT_COMMAND = "scripts/check_control_thread_audit"
AUDITED = ("heap allocations", "locks", "page faults", "system calls")
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
SHIPPED, ASLEEP, REFERENCE = "hard mode as shipped (hybrid wait)", "hard mode asleep (wait = sleep)", "cyclictest"
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
    vcan = (str(ROOT / "scripts" / "with_vcan"), "--time-limit", "120", "--")
    figures = []
    for name, bus, inside in (("vcan", "socketcan:vcan0", vcan), ("udp multicast", live_runs.BUS, ())):
        measure = (
            "CAN frame received to first gate pattern"
            f" / (one period + wake-ups of receive and control thread), 99 %, {name}"
        )
        try:
            timing = live_runs.commanded(lab, f"command_{name.split()[0]}", bus, inside)
        except UserError as error:
            figures.append(failed(measure, error))
            continue
        way, hand_over, wake = (
            Histogram.from_json(timing[key]) for key in ("command_to_gate", "command_hand_over", "wake_latency")
        )
        if way.count == 0:
            figures.append(unmeasured(measure, "the drive was not ready in time for a command"))
            continue
        distributions[f"command to gate, {name}"] = way
        distributions[f"of it until the receive thread has handed it over, {name}"] = hand_over
        distributions[f"wake-up of the control thread beside it, {name}"] = wake
        way_us, hand_over_us, wake_us = (side.percentile_ns(99.0) * 1e-3 for side in (way, hand_over, wake))
        allowed = f"({timing['period_us']} + {hand_over_us:.0f} + {wake_us:.1f}) µs"
        note = f"{way.count} frames; {way_us:.0f} / {allowed}"
        if timing["where"] == "qemu":  # its processor is emulated: its times are not a machine's
            figures.append(unmeasured(measure, f"in a guest with an emulated processor, asleep at 1 ms: {note}"))
            continue
        ratio = way_us / (timing["period_us"] + hand_over_us + wake_us)
        figures.append(Figure(measure, ratio, unit="x", at_most=1.0, note=note))
    return figures


def audit(lab: Lab) -> list[Figure]:
    measure = "allocations, locks, page faults and system calls of the control thread in 10⁷ periods, spin mode"
    if not AUDIT.exists():
        return [unmeasured(measure, f"{AUDIT_COMMAND} builds and runs it", command=AUDIT_COMMAND)]
    text = lab.run(AUDIT, "--periods", "10000000", "--period-us", "5", "--wait", "spin", accept=(0, 1))
    lines = [re.search(rf"^  {name} +(\d+)  (?:ok|FOUND)", text, re.MULTILINE) for name in AUDITED]
    if not all(lines):
        return [failed(measure, f"it says: {text.strip()[-200:]}", command=AUDIT_COMMAND)]
    counts = [int(line[1]) for line in lines]
    return [
        Figure(
            measure,
            sum(counts),
            at_most=0,
            wanted="0",
            text="/".join(map(str, counts)),
            command=AUDIT_COMMAND,
        )
    ]


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
        ("audit", lambda: audit(lab)),
        ("lockstep", lambda: lockstep(lab)),
    ):
        lab.say(name)
        try:
            figures += part()
        except UserError as error:  # of the other parts the figures still count
            figures.append(failed(f"live: {name}", error))
    summaries = {name: histogram.summary() for name, histogram in distributions.items() if histogram.count}
    (lab.out / LATENCIES).write_text(json.dumps(summaries, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    draw_latency(
        {name: distributions[name] for name in (REFERENCE, SHIPPED, ASLEEP) if name in distributions},
        {name: distributions[name] for name in distributions if name.startswith("command to gate")},
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


LIVE = Stage("live", "the live drive: wake-ups, work, commands, lockstep", 400, live)
