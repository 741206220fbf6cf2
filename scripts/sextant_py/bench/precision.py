"""Stage: the fixed step's error on one recorded switching sequence, from the program of the work-precision diagram."""

import json

from sextant_py.errors import UserError

from .figure import Figure, number, unmeasured
from .lab import Lab, Stage

PROGRAM = "sextant_work_precision"
LIMIT_NM = 1e-6
KNOWN_NM = 2e-6  # CVODE at 1e-10 is itself so far from the truth, on any machine: it is arithmetic, not time
MEASURE = "torque error of the fixed step (one RK4 step a period) against CVODE at 1e-10, worst over 1 s"


def figures(result: dict) -> list[Figure]:
    """Of the program's JSON; the free shaft, where the equations are not linear."""
    try:
        free = result["free_shaft"]
        fixed = next(p for p in free["points"] if p["integrator"] == "fixed" and p["default"])
        own = free["torque_error_of_cvode_nm"]
        loose = f"CVODE at 1e-10 itself is {number(own['1e-10'])} N·m from RK4 at 1 µs"
        tight = f"CVODE at 1e-12 itself is {number(own['1e-12'])} N·m from RK4 at 1 µs"
        against = fixed["torque_difference_to_cvode_1e_12_nm"]
        against_loose = fixed["torque_difference_to_cvode_1e_10_nm"]
        true = fixed["torque_error_nm"]
    except (KeyError, StopIteration, TypeError) as error:
        raise UserError(f"{PROGRAM} prints another form than expected ({type(error).__name__}: {error})") from error
    return [
        Figure(
            MEASURE,
            against_loose,
            "N·m",
            at_most=LIMIT_NM,
            note=loose,
            accepted_at_most=KNOWN_NM,
            accepted_because="it is the error of CVODE at 1e-10, which begins anew after each change of the voltage",
        ),
        Figure("the same against CVODE at 1e-12", against, "N·m", at_most=LIMIT_NM, note=tight),
        Figure("the same against RK4 at 1 µs", true, "N·m", at_most=LIMIT_NM),
    ]


def precision(lab: Lab) -> list[Figure]:
    if not (lab.programs / PROGRAM).exists():
        return [unmeasured(MEASURE, f"there is no program {PROGRAM}", unit="N·m", at_most=LIMIT_NM)]
    return figures(json.loads(lab.run(lab.programs / PROGRAM)))


PRECISION = Stage("precision", "error of the fixed step on a recorded switching sequence", 60, precision)
