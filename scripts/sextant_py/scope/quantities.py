"""The signals that a trigger can evaluate: those of DriveWaveform, and magnitudes of its vectors."""

import difflib
from collections.abc import Callable

import numpy as np

from ..errors import UserError
from ..telemetry_contract import signals

OFFSETS = "offset_ns"


def current(rows: np.ndarray) -> np.ndarray:
    """Magnitude of the stator current vector, amplitude-invariant."""
    alpha = (2.0 * rows["i_a_a"] - rows["i_b_a"] - rows["i_c_a"]) / 3.0
    beta = (rows["i_b_a"] - rows["i_c_a"]) / np.sqrt(3.0)
    return np.hypot(alpha, beta)


def flux(rows: np.ndarray) -> np.ndarray:
    """Magnitude of the estimated stator flux linkage."""
    return np.hypot(rows["flux_alpha_wb"], rows["flux_beta_wb"])


MAGNITUDES: dict[str, tuple[Callable[[np.ndarray], np.ndarray], str, str]] = {
    "current_a": (current, "A", "magnitude of the stator current vector (peak)"),
    "flux_wb": (flux, "Wb", "magnitude of the estimated stator flux linkage"),
}


def known() -> dict[str, tuple[str, str]]:
    """Unit and text of every signal that a trigger can evaluate."""
    of_contract = {
        signal.name: (signal.unit, signal.text)
        for signal in signals("DriveWaveform")
        if signal.type.startswith("sequence<") and signal.name != OFFSETS
    }
    return of_contract | {name: (unit, text) for name, (_, unit, text) in MAGNITUDES.items()}


def check(name: str) -> str:
    """The name itself. UserError, with the nearest known names, where there is no such signal."""
    if name in known():
        return name
    near = difflib.get_close_matches(name, known(), 3, 0.4)
    hint = f"; the nearest are {', '.join(near)}" if near else "; scripts/scope --list names them"
    raise UserError(f'the waveform has no signal "{name}"{hint}.')


def values(rows: np.ndarray, name: str) -> np.ndarray:
    """The values of a signal as numbers in double precision."""
    column = MAGNITUDES[name][0](rows) if name in MAGNITUDES else rows[name]
    return np.asarray(column, np.float64)
