"""Stages whose figures are ratios, CPU times and counts of one process, with their targets."""

import json
from collections.abc import Callable

from sextant_py.control_methods import METHODS
from sextant_py.errors import UserError

from studies.work_precision import closed_loops

from . import instructions
from .figure import Figure, NotMeasurableError, number
from .google import GoogleResult, Row, row
from .lab import Lab, Stage
from .plots import draw_growth

LOOP_PROGRAM, PRECISION_PROGRAM = "sextant_loop_bench", "sextant_work_precision"
RESOLVED_NS = 2.0  # the clock tells whole nanoseconds; a shorter push cannot be told from none

PLANTS = {"fixed": "fixed", "exact": "exact", "exact_at_constant_speed": "exact at constant speed"}
PLANTS |= {"erk": "erk", "cvode": "cvode"}
ESTIMATORS = (
    "voltage_model",
    "compensated_voltage_model",
    "current_model",
    "hybrid",
    "observer",
    "sensorless_observer",
)
STEP_LIMITS = {"deadbeat": {"at_most": 100.0}}


def cpu_time(name: str, of: str, **limits: float) -> Row:
    return row(name, "cpu_ns", f"CPU time of {of}", "ns", "least", **limits)


CONTROL = (
    row("dtc_step_ratio", "ratio", "DTC step / hand-written reference of the same arithmetic", "x"),
    row("drive_step_ratio", "ratio", "`Drive::step` with estimator, protections and monitor / the same reference", "x"),
    cpu_time("dtc_step_reference", "the hand-written DTC step"),
    cpu_time("dtc_step", "the DTC step"),
    *(cpu_time(f"estimator_step/{kind}", f"the flux estimator `{kind}`") for kind in ESTIMATORS),
    *(cpu_time(f"controller_step/{m}", f"the control method `{m}`", **STEP_LIMITS.get(m, {})) for m in METHODS),
    cpu_time("drive_step", "`Drive::step`"),
)
PLANT = (
    row("plant_period_ratio", "ratio", "fixed-step plant / hand-written RK4 of the same equations", "x", at_most=1.2),
    *(
        row(f"plant_period_ratio/{kind}", "ratio", f"a period of the plant / the same RK4, {text}", "x")
        for kind, text in PLANTS.items()
        if kind != "fixed"
    ),
    cpu_time("plant_rk4_reference", "25 µs of plant, hand-written RK4"),
    *(cpu_time(f"plant_period/{kind}", f"25 µs of plant, {text}") for kind, text in PLANTS.items()),
)
SIMULATED = "times real time"  # simulated time / CPU time
LOOP = (
    row("closed_loop_ratio", "ratio", "closed loop, 25 µs, fixed-step plant / bare DTC and RK4 by hand", "x"),
    row("closed_loop_fixed", "realtime_factor", f"closed loop, 25 µs, fixed-step plant, {SIMULATED}", "x", "most"),
    row("closed_loop_cvode", "realtime_factor", f"closed loop, 25 µs, CVODE, {SIMULATED}", "x", "most", at_least=2.5),
)
FLATNESS = Figure("cost of a period, late in a run / at its beginning", "x", at_most=1.1)
SCENARIO_LIMITS = {"sampled_3_1_cvode": 1.5, "sampled_3_1_fixed": 60.0, "sampled_nycc_traced": 150.0}
SCENARIO_LIMITS |= {f"exact_{name}_fixed": 30.0 for name in ("3_1", "3_2", "3_3", "3_4", "nycc", "table6")}
SCENARIO_LIMITS |= {f"exact_{name}_cvode": 0.7 for name in ("3_1", "3_2", "3_3", "3_4")}
SCENARIOS = tuple(
    row(f"scenario/{name}", "realtime_factor", f"scenario {name}, {SIMULATED}", "x", "most", at_least=limit)
    for name, limit in SCENARIO_LIMITS.items()
)
TELEMETRY = (
    row(
        "telemetry_push",
        "p50_ns",
        "telemetry push on the control path, drained by a reader, median",
        "ns",
        at_most=50.0,
        note="one reading of the clock included",
    ),
    row("telemetry_push", "clock_ns", "telemetry push, the reading of the clock alone, median", "ns"),
    row("telemetry_push_unread", "p50_ns", "telemetry push, nobody reads yet, median", "ns"),
    row("telemetry_push", "p99_ns", "telemetry push, drained by a reader, 99 %", "ns"),
    row("telemetry_push", "p999_ns", "telemetry push, drained by a reader, 99.9 %", "ns"),
)
# A push that is refused copies no record, so it may not cost more than one that does.
FULL_RING = Figure("telemetry push into a full ring / into one with room, medians less the clock's", "x", at_most=1.0)
AMONG = Figure(
    "cost of a drive among 64 / of one alone, one process, telemetry at 1 kHz each over DDS",
    "x",
    at_most=1.2,
    note="each drive a DDS instance, every sample seen by a reader",
)
DEAREST = Figure("dearest size of the process / a drive alone", "x", at_most=1.2)
CARRIED = Figure("drives that one processor carries at 25 µs in real time, by CPU time, plants and telemetry included")
PRECISION = {
    "torque_difference_to_cvode_1e_10_nm": "torque error of the fixed step (one RK4 step a period) against CVODE at"
    " 1e-10, worst over 1 s",
    "torque_difference_to_cvode_1e_12_nm": "the same against CVODE at 1e-12",
    "torque_error_nm": "the same against RK4 at 1 µs",
}
# By controller and integrator: the least simulated time by CPU time, the largest error in parts of the peak torque.
LOOP_LIMITS = {("foc", "fixed"): (60.0, 2e-5), ("foc", "cvode"): (10.0, 1e-5)}
PRECISION_ROWS = {key: Figure(text, "N·m", at_most=1e-6) for key, text in PRECISION.items()}


def rows_of(pattern: str, rows: tuple[Row, ...], **options) -> Callable[[Lab], list[Figure]]:
    """A stage that is its table."""

    def run(lab: Lab) -> list[Figure]:
        result = lab.google(pattern, **options)
        return [result.figure(*one) for one in rows]

    return run


def flatness(result: GoogleResult) -> Figure:
    """Benchmarks closed_loop_growth/N: the cost of a period after N periods to that at the beginning."""
    names = result.names(r"^closed_loop_growth/\d+$")
    if not names:
        return FLATNESS.failed("the program has no benchmark closed_loop_growth")
    oldest = max(int(name.rsplit("/", 1)[1]) for name in names)
    note = f"the worst of {len(names)} ages up to {oldest:,} periods".replace(",", " ")
    return FLATNESS.of(max(result.value(name, "ratio") for name in names), note)


def loop(lab: Lab) -> list[Figure]:
    result = lab.google("^closed_loop_", repetitions=5)
    return [*(result.figure(*one) for one in LOOP), flatness(result)]


def telemetry(lab: Lab) -> list[Figure]:
    result = lab.google("^telemetry_push", LOOP_PROGRAM, repetitions=9)
    return [full_ring(result), *(result.figure(*one) for one in TELEMETRY)]


def full_ring(result: GoogleResult) -> Figure:
    """A push that is refused beside one with room, both without the reading of the clock that times them."""
    try:
        full, room = (
            result.value(name, "p50_ns") - result.value(name, "clock_ns")
            for name in ("telemetry_push_full", "telemetry_push")
        )
    except UserError as error:
        return FULL_RING.failed(error)
    if room < RESOLVED_NS:
        return FULL_RING.failed(NotMeasurableError(f"a push of {room:.1f} ns is lost in the reading of the clock"))
    return FULL_RING.of(max(0.0, full) / room, f"dropped and counted, never waited for; {full:.1f} / {room:.1f} ns")


def growth(lab: Lab) -> list[Figure]:
    result = lab.google("^growth", LOOP_PROGRAM, repetitions=5)
    sizes = sorted(int(key[3:]) for key in result.counters.get("growth", {}) if key.startswith("us_"))
    if not sizes:
        return [result.figure(one, "growth", "ratio_64") for one in (AMONG, DEAREST, CARRIED)]
    cost_us = {n: result.value("growth", f"us_{n}") for n in sizes}
    worst = max(sizes, key=lambda n: result.value("growth", f"ratio_{n}"))
    draw_growth(cost_us, lab.out / "growth.png")
    return [
        result.figure(AMONG, "growth", "ratio_64"),
        DEAREST.of(result.value("growth", f"ratio_{worst}"), f"at N = {worst}"),
        CARRIED.of(1000.0 / cost_us[sizes[-1]]),
    ]


def precision_figures(result: dict) -> list[Figure]:
    """Of the JSON of the work-precision program; the free shaft, where the equations are not linear."""
    try:
        free = result["free_shaft"]
        fixed = next(p for p in free["points"] if p["integrator"] == "fixed" and p["default"])
        own = free["torque_error_of_cvode_nm"]
        notes = [f"CVODE at {t} itself is {number(own[t])} N·m from RK4 at 1 µs" for t in ("1e-10", "1e-12")]
        return [one.of(fixed[key], n) for (key, one), n in zip(PRECISION_ROWS.items(), [*notes, ""], strict=True)]
    except (KeyError, StopIteration, TypeError) as error:
        kind = f"{type(error).__name__}: {error}"
        raise UserError(f"{PRECISION_PROGRAM} prints another form than expected ({kind})") from error


def precision(lab: Lab) -> list[Figure]:
    return precision_figures(json.loads(lab.run(lab.programs / PRECISION_PROGRAM, "switching")))


def loop_figures(loops: list[dict]) -> list[Figure]:
    """As shipped, with metrics; the error against CVODE at 1e-12 that restarts at each switching."""
    figures = []
    for one in closed_loops.rows(loops):
        least, most = LOOP_LIMITS.get((one.controller, one.integrator), (None, None))
        name = f"closed loop of {one.controller} on {one.integrator}"
        factor = Figure(f"{name}, {SIMULATED}", "x", at_least=least)
        error = Figure(f"{name}: torque error in parts of the peak torque, 0 to 300 rad/s", at_most=most)
        figures += [factor.of(one.factor), error.of(max(one.errors.values()))]
    return figures


def methods(lab: Lab) -> list[Figure]:
    return loop_figures(json.loads(lab.run(lab.programs / PRECISION_PROGRAM, "closed_loops"))["closed_loops"])


def counts(lab: Lab) -> list[Figure]:
    found = instructions.measure(lab.programs / "sextant_instruction_probe")
    return [Figure(f"instructions of one {name.replace('_', ' ')}", value=value) for name, value in found.items()]


CONTROL_STAGE = Stage(
    "control",
    "the control step against a hand-written one",
    15,
    rows_of("^(dtc_step|estimator_step|controller_step|drive_step)", CONTROL),
)
PLANT_STAGE = Stage("plant", "the plant against a hand-written one", 15, rows_of("^plant_", PLANT))
PRECISION_STAGE = Stage("precision", "error of the fixed step on a recorded switching sequence", 60, precision)
METHODS_STAGE = Stage("methods", "dtc and foc on every integrator", 60, methods)
LOOP_STAGE = Stage("loop", "drive and plant in one loop", 25, loop)
TELEMETRY_STAGE = Stage("telemetry", "the telemetry push on the control thread", 5, telemetry)
GROWTH_STAGE = Stage("growth", "1 to 64 drives in one process", 10, growth)
INSTRUCTIONS_STAGE = Stage("instructions", "instructions of a step, by callgrind", 8, counts)
SCENARIOS_STAGE = Stage(
    "scenarios", "whole scenarios of the paper", 90, rows_of("^scenario/", SCENARIOS, repetitions=3)
)
