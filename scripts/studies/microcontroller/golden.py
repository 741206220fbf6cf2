"""Golden runs of the drive: the answers of host and microcontroller, compared; and what each step cost."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from sextant_py.errors import UserError

# Output and PlantOutput of tests/cortex_m/golden/golden_record.hpp, with the tolerance of each number in its unit.
TOLERANCES = {
    "torque": 5e-4,  # [N·m]
    "torque_reference": 5e-4,  # [N·m]
    "psi_s_alpha": 2e-5,  # [Wb]
    "psi_s_beta": 2e-5,  # [Wb]
    "i_dc": 1e-4,  # [A]
    "plant_i_alpha": 1e-3,  # [A]
    "plant_i_beta": 1e-3,  # [A]
    "plant_tau_e": 2e-3,  # [N·m]
    "plant_omega_m": 1e-3,  # [rad/s]
}
DECISIONS = ("legs", "sector", "state", "lockout", "latched")
_FLOATS = list(TOLERANCES)
OUTPUT = np.dtype(
    [("latched", "<u8")]
    + [(name, "<f4") for name in _FLOATS[:5]]
    + [(name, "u1") for name in ("legs", "sector", "state", "lockout")]
    + [(name, "<f4") for name in _FLOATS[5:]]
)
COST = np.dtype([(name, "<u4") for name in ("drive", "controller", "plant", "driven")])
SETUP = np.dtype([("input_size", "<u4"), ("periods", "<u4"), ("period_ns", "<i4"), ("actuation_delay_periods", "<i4")])

# What `sextant_golden replay` moves by these amounts, up and down: the decisions that change hang on rounding.
SHIFTS = {"torque": TOLERANCES["torque"], "flux": TOLERANCES["psi_s_alpha"], "sector": 3e-4, "current": 2e-5}


@dataclass
class Comparison:
    """How far the answers of another arithmetic are from the reference."""

    different: int = 0  # periods with another decision
    on_edge: int = 0  # of these, those in which rounding may decide
    bit_identical: bool = False
    largest: dict[str, float] = field(default_factory=dict)  # difference by number
    problems: list[str] = field(default_factory=list)


def load_outputs(file: Path, periods: int) -> np.ndarray:
    outputs = np.fromfile(file, OUTPUT)
    if len(outputs) != periods:
        raise UserError(f"{file.name} has {len(outputs)} answers for {periods} inputs; the replay ended early.")
    return outputs


def other_decision(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """By period: whether any decision differs."""
    return np.any([a[name] != b[name] for name in DECISIONS], axis=0)


def admissible(other: np.ndarray, variants: list[np.ndarray]) -> np.ndarray:
    """By period: whether all decisions are those of one of the variants."""
    return np.any([~other_decision(other, variant) for variant in variants], axis=0)


def compare(
    reference: np.ndarray, other: np.ndarray, variants: list[np.ndarray], times: float = 1.0, others: int = 0
) -> Comparison:
    """Decisions must be equal, or those of a variant whose thresholds were shifted by a tolerance; numbers must agree
    within theirs, times a factor, and be no number in the same periods. So many other decisions are admitted."""
    result = Comparison(bit_identical=other.tobytes() == reference.tobytes())
    differ = other_decision(reference, other)
    edge = differ & admissible(other, variants) if variants else np.zeros_like(differ)
    result.different = int(differ.sum())
    result.on_edge = int(edge.sum())
    wrong = np.flatnonzero(differ & ~edge)
    if len(wrong) > others:
        k = int(wrong[0])
        was = ", ".join(f"{name} {other[name][k]} for {reference[name][k]}" for name in DECISIONS)
        result.problems.append(f"{len(wrong)} periods decide otherwise, first period {k}: {was}")
    for name, tolerance in TOLERANCES.items():
        a, b = reference[name].astype(float), other[name].astype(float)
        if not np.array_equal(np.isnan(a), np.isnan(b)):
            result.problems.append(f"{name} is no number in other periods")
        far = np.nan_to_num(np.abs(a - b))
        result.largest[name] = float(far.max())
        if far.max() > times * tolerance:
            k = int(np.argmax(far > times * tolerance))
            limit = times * tolerance
            result.problems.append(f"{name} is off by up to {far.max():.2g} for {limit:g}, first in period {k}")
    return result


@dataclass(frozen=True)
class Costs:
    """Instructions by period, without the call."""

    drive: np.ndarray
    controller: np.ndarray
    plant: np.ndarray
    driven: np.ndarray  # the legs were driven throughout the period


def load_costs(file: Path, ticks_per_instruction: float) -> Costs:
    """Refuses a timer that does not count instructions: 1000 more of them must be 1000 more."""
    raw = np.fromfile(file, "<u4")
    count = raw[:3] / ticks_per_instruction
    if not np.all(np.abs(count - count.round()) < 0.1) or not np.array_equal(np.diff(count.round()), [1000, 1000]):
        raise UserError(f"the timer of the emulator does not count instructions: calibration {raw[:3].tolist()}.")
    ticks = raw[3:].view(COST)
    call = round(count[0])

    def instructions(name: str) -> np.ndarray:
        return np.maximum(np.round(ticks[name] / ticks_per_instruction) - call, 0).astype(int)

    return Costs(*(instructions(name) for name in COST.names[:3]), ticks["driven"] != 0)
