"""Stages: the control step, the plant, the closed loop, whole scenarios."""

from .figure import Figure, failed
from .google import GoogleResult
from .lab import Lab, Stage

FLAT = 1.1  # cost a period in a long run to that in a short one


def control(lab: Lab) -> list[Figure]:
    result = lab.google("^(dtc_step|drive_step)")
    return [
        result.figure(
            "DTC step / hand-written reference of the same arithmetic", "dtc_step_ratio", "ratio", unit="x", at_most=1.2
        ),
        result.figure(
            "`Drive::step` with every check / the same reference",
            "drive_step_ratio",
            "ratio",
            unit="x",
            at_most=4.0,
        ),
        result.figure(
            "`Drive::step` / a whole drive by hand: same checks, same record",
            "drive_step_same_ratio",
            "ratio",
            unit="x",
            at_most=1.1,
        ),
        *(
            result.figure(f"CPU time of {text}", name, "cpu_ns", "least", unit="ns")
            for name, text in (
                ("dtc_step_reference", "the hand-written DTC step"),
                ("dtc_step", "the DTC step"),
                ("drive_step", "`Drive::step`"),
            )
        ),
    ]


def plant(lab: Lab) -> list[Figure]:
    result = lab.google("^plant_")
    figures = [
        result.figure(
            "fixed-step plant / hand-written RK4 of the same equations",
            "plant_period_ratio",
            "ratio",
            unit="x",
            at_most=1.2,
        )
    ]
    for name in result.names("^plant_period_ratio/"):
        kind = name.removeprefix("plant_period_ratio/").replace("_", " ")
        figures.append(result.figure(f"a period of the plant / the same RK4, {kind}", name, "ratio", unit="x"))
    for name in result.names("^plant_(rk4_reference$|period/)"):
        kind = name.removeprefix("plant_period/").replace("_", " ").replace("plant rk4 reference", "hand-written RK4")
        figures.append(result.figure(f"CPU time of 25 µs of plant, {kind}", name, "cpu_ns", "least", unit="ns"))
    return figures


def flatness(result: GoogleResult) -> Figure:
    """Benchmarks closed_loop_growth/N: the cost of a period after N periods to that at the beginning."""
    measure = "cost of a period, late in a run / at its beginning"
    names = result.names(r"^closed_loop_\w+/\d+$")
    if not names:
        return failed(measure, "the program has no benchmark closed_loop_growth", unit="x", at_most=FLAT)
    oldest = max(names, key=lambda name: int(name.rsplit("/", 1)[1]))
    dearest = max(names, key=lambda name: result.median(name, "ratio"))
    age = int(oldest.rsplit("/", 1)[1])
    note = f"the worst of {len(names)} ages up to {age:,} periods".replace(",", " ")
    return result.figure(measure, dearest, "ratio", unit="x", at_most=FLAT, note=note)


def loop(lab: Lab) -> list[Figure]:
    result = lab.google("^closed_loop_", repetitions=5)
    return [
        result.figure(
            "closed loop, 25 µs, fixed-step plant: simulated time / CPU time",
            "closed_loop_fixed",
            "realtime_factor",
            "most",
            unit="x",
            at_least=250.0,
        ),
        result.figure(
            "closed loop, 25 µs, CVODE: simulated time / CPU time",
            "closed_loop_cvode",
            "realtime_factor",
            "most",
            unit="x",
            at_least=2.5,
        ),
        flatness(result),
    ]


SAMPLED = (("sampled_3_1_cvode", 1.5), ("sampled_3_1_fixed", 60.0), ("sampled_nycc_traced", 150.0))
EXACT = ("3_1", "3_2", "3_3", "3_4", "nycc", "table6")
EXACT_ON_CVODE = ("3_1", "3_2", "3_3", "3_4")


def scenarios(lab: Lab) -> list[Figure]:
    result = lab.google("^scenario/", repetitions=3)
    limits = [
        *SAMPLED,
        *((f"exact_{name}_fixed", 30.0) for name in EXACT),
        *((f"exact_{name}_cvode", 0.7) for name in EXACT_ON_CVODE),
    ]
    return [
        result.figure(
            f"scenario {name} with metrics: simulated time / CPU time",
            f"scenario/{name}",
            "realtime_factor",
            "most",
            unit="x",
            at_least=limit,
        )
        for name, limit in limits
    ]


CONTROL = Stage("control", "the control step against a hand-written one", 15, control)
PLANT = Stage("plant", "the plant against a hand-written one", 15, plant)
LOOP = Stage("loop", "drive and plant in one loop", 25, loop)
SCENARIOS = Stage("scenarios", "whole scenarios of the paper", 90, scenarios)
