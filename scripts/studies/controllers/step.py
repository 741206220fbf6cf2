"""The picture of a torque step by the paper's method and by the one that the drives ship with."""

import subprocess
import tempfile
from pathlib import Path

from sextant_py.errors import UserError
from sextant_py.sweep_reader import set_words

from studies.picture import picture

from .cases import REFERENCE, STEP_S, at

METHODS = {"dtc": "the paper's switching table (dtc)", "foc": "field-oriented control (foc)"}  # all at 25 us
BEFORE_S, AFTER_S = 0.002, 0.012  # of the step
COLUMNS = {"least": "plant/torque_min_nm", "most": "plant/torque_max_nm", "i_a": "plant/i_a_a"}

Curves = dict[str, dict[str, list[float]]]  # by method: time after the step [ms], torque in each period [N·m], current


def measure(mil: Path, scenario: Path) -> Curves:
    return {method: _curves(mil, scenario, method) for method in METHODS}


def _curves(mil: Path, scenario: Path, method: str) -> dict[str, list[float]]:
    import h5py

    settings = at(*REFERENCE, 25) | {
        "control.controller": method,
        "duration_s": STEP_S + AFTER_S,
        "metrics.window_from_s": 0,
        "trace.interval_us": 25,
        "trace.signals": ["all"],
    }
    with tempfile.TemporaryDirectory(prefix="sextant-step-") as out:
        done = subprocess.run([mil, scenario, *set_words(settings), "--out", out], capture_output=True, text=True)
        file = Path(out) / "trace.h5"
        if not file.is_file():
            raise UserError(f"{scenario}: sextant-mil wrote no trace with {method}: {done.stderr.strip()}")
        with h5py.File(file) as trace:
            t_s = trace["t_ns"][:] * 1e-9 - STEP_S
            shown = t_s >= -BEFORE_S
            curves = {"t_ms": (t_s[shown] * 1e3).round(3).tolist()}
            return curves | {key: trace[name][:][shown].round(2).tolist() for key, name in COLUMNS.items()}


def draw(curves: Curves, file: Path) -> None:
    with picture(file, 2, len(curves), (10, 5), sharex=True, sharey="row") as (_, axes):
        for column, (method, c) in enumerate(curves.items()):
            torque, current = axes[0][column], axes[1][column]
            torque.fill_between(c["t_ms"], c["least"], c["most"], step="pre", label="in the machine")
            commanded = ([-BEFORE_S * 1e3, 0, AFTER_S * 1e3], [0, REFERENCE[1], REFERENCE[1]])
            torque.step(*commanded, "k--", lw=1, where="post", label="commanded")
            torque.set_title(METHODS[method])
            current.plot(c["t_ms"], c["i_a"], lw=1)
            current.set_xlabel("time after the step [ms]")
        axes[0][0].legend(loc="lower right")
        axes[0][0].set_ylabel("torque [N·m]")
        axes[1][0].set_ylabel("current of phase a at the\ncontrol instants [A]")
