"""Stages: the telemetry push on the control thread, and many drives in one process."""

import json

from sextant_py.paths import ROOT

from .figure import Figure, unmeasured
from .google import GoogleResult
from .growth_plot import draw_growth
from .lab import Lab, Stage

PROGRAM = "sextant_loop_bench"
PLOT = ROOT / "docs" / "images" / "growth.png"
FULL_TO_ROOM = 1.0  # a push that is refused copies no record, so it may not cost more than one that does
RESOLVED_NS = 2.0  # the clock tells whole nanoseconds; a shorter push cannot be told from none
GROWTH_FLAT = 1.2  # cost of a drive among 64 to that of one alone


def telemetry(lab: Lab) -> list[Figure]:
    result = lab.google("^telemetry_push", PROGRAM, repetitions=9)
    figures = [
        result.figure(
            "telemetry push on the control path, drained by a reader, median",
            "telemetry_push",
            "p50_ns",
            unit="ns",
            at_most=50.0,
            note="one reading of the clock included",
        )
    ]
    figures.append(full_ring(result))
    figures += [
        result.figure(f"telemetry push, {text}", name, counter, unit="ns")
        for name, counter, text in (
            ("telemetry_push", "clock_ns", "the reading of the clock alone, median"),
            ("telemetry_push_unread", "p50_ns", "nobody reads yet, median"),
            ("telemetry_push", "p99_ns", "drained by a reader, 99 %"),
            ("telemetry_push", "p999_ns", "drained by a reader, 99.9 %"),
        )
    ]
    return figures


def full_ring(result: GoogleResult) -> Figure:
    """A push that is refused beside one with room, both without the reading of the clock that times them."""
    measure = "telemetry push into a full ring / into one with room, medians less the clock's"
    names = ("telemetry_push_full", "telemetry_push")
    for name in names:
        for counter in ("p50_ns", "clock_ns"):
            if not result.has(name, counter):
                return result.figure(measure, name, counter)
    full, room = (result.median(name, "p50_ns") - result.median(name, "clock_ns") for name in names)
    options = {"unit": "x", "at_most": FULL_TO_ROOM}
    if room < RESOLVED_NS:
        return unmeasured(measure, f"a push of {room:.1f} ns is lost in the reading of the clock", **options)
    note = f"dropped and counted, never waited for; {full:.1f} / {room:.1f} ns"
    return Figure(measure, max(0.0, full) / room, note=note, **options)


def growth(lab: Lab) -> list[Figure]:
    result = lab.google("^growth", PROGRAM, repetitions=5)
    counters = result.counters.get("growth", {})
    sizes = sorted(int(key.removeprefix("us_")) for key in counters if key.startswith("us_"))
    largest = sizes[-1] if sizes else 64
    figures = [
        result.figure(
            f"cost of a drive among {largest} / of one alone, one process, telemetry at 1 kHz each over DDS",
            "growth",
            f"ratio_{largest}",
            unit="x",
            at_most=GROWTH_FLAT,
            note="each drive a DDS instance, every sample seen by a reader",
        )
    ]
    if not sizes:
        return figures
    cost_us = {n: result.median("growth", f"us_{n}") for n in sizes}
    worst = max(sizes, key=lambda n: result.median("growth", f"ratio_{n}"))
    figures.append(
        Figure(
            "dearest size of the process / a drive alone",
            result.median("growth", f"ratio_{worst}"),
            unit="x",
            at_most=GROWTH_FLAT,
            note=f"at N = {worst}",
        )
    )
    figures.append(
        Figure(
            "drives that one processor carries at 25 µs in real time, by CPU time, plants and telemetry included",
            1000.0 / cost_us[largest],
        )
    )
    (lab.out / "growth.json").write_text(json.dumps(cost_us), encoding="utf-8")
    draw_growth(cost_us, lab.out / "growth.png")
    return figures


TELEMETRY = Stage("telemetry", "the telemetry push on the control thread", 5, telemetry)
GROWTH = Stage("growth", "1 to 64 drives in one process", 10, growth)
