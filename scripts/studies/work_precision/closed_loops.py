"""The closed loops of sextant_work_precision by controller and integrator."""

from dataclasses import dataclass

from studies import page

INTEGRATORS = ("fixed", "exact", "erk", "cvode")
SPEEDS = (0.0, 50.0, 150.0, 300.0)  # in both directions [rad/s]


@dataclass(frozen=True)
class LoopRow:
    controller: str
    integrator: str
    factor: float  # simulated time by CPU time, over all loops
    errors: dict[float | None, float]  # by speed the largest, in parts of the peak torque; None: the free shaft


def speed_of(loop: dict) -> float | None:
    return None if loop["speed_rad_s"] is None else abs(loop["speed_rad_s"])


def row_of(controller: str, integrator: str, loops: list[dict]) -> LoopRow:
    found = [(speed_of(loop), loop["integrators"][integrator]) for loop in loops]
    largest: dict[float | None, float] = {}
    for speed, one in found:
        largest[speed] = max(largest.get(speed, 0.0), one["error_of_peak"])
    return LoopRow(controller, integrator, len(found) / sum(one["cpu_s_per_simulated_s"] for _, one in found), largest)


def rows(loops: list[dict]) -> list[LoopRow]:
    """Controllers as they come."""
    found = []
    for controller in dict.fromkeys(loop["controller"] for loop in loops):
        own = [loop for loop in loops if loop["controller"] == controller]
        found += [row_of(controller, integrator, own) for integrator in INTEGRATORS]
    return found


def table(loops: list[dict]) -> str:
    cells = (
        (
            *(f"`{row.controller}`", f"`{row.integrator}`", f"{row.factor:.3g}"),
            *(f"{error:.1e}" for error in (max(row.errors[speed] for speed in SPEEDS), row.errors[None])),
        )
        for row in rows(loops)
    )
    head = ("`control.controller`", "`plant.integrator`", "times real time", "imposed speed", "free shaft")
    return page.table(head, cells, left=(0, 1))
