"""Finds in a trace or a recording the instant at which a trigger of scripts/scope is fulfilled first."""

from pathlib import Path

import numpy as np

from .errors import UserError
from .plots.series import STATISTIC
from .recording.model import TRIGGER
from .recording.topics import WAVEFORM
from .scope import quantities
from .scope.trigger_text import parse
from .signal_file import GroupRows, SignalFile

OWN = "trigger"  # the instant that a capture was triggered at


def _evaluated(time_s: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """What a trigger can evaluate, by the names of the waveform. Telemetry has means over its intervals, and the flux
    by magnitude and angle."""
    names = rows.dtype.names or ()
    found = {"t_ns": np.rint(time_s * 1e9).astype(np.int64)}
    means = {f"{m[1]}_{m[3]}": m[0] for m in map(STATISTIC.fullmatch, names) if m and m[2] == "mean"}
    for name in (*quantities.known(), "state"):
        if source := name if name in names else means.get(name):
            found[name] = rows[source]
    if "flux_alpha_wb" not in found and {"flux_mean_wb", "flux_angle_rad"} <= set(names):
        magnitude, angle = rows["flux_mean_wb"], rows["flux_angle_rad"]
        found |= {"flux_alpha_wb": magnitude * np.cos(angle), "flux_beta_wb": magnitude * np.sin(angle)}
    return np.rec.fromarrays(list(found.values()), names=list(found))


def rows_for(file: SignalFile) -> GroupRows:
    """The control periods where there are any, else the main group."""
    return file.groups[WAVEFORM if WAVEFORM in file.filled() else file.main]


def interval_s(time_s: np.ndarray) -> float:
    """From one row to the next, the median. [s]"""
    return float(np.median(np.diff(time_s))) if len(time_s) > 1 else 0.0


def instant(path: Path, file: SignalFile, text: str) -> tuple[float, float]:
    """When the trigger is first fulfilled, on the time axis of the file's signals, and by how much earlier that may
    have been: the time since the row before. [s] UserError: never, or the file lacks what the trigger evaluates."""
    if text == OWN:
        if TRIGGER not in file.groups[file.main].source.metadata:
            raise UserError(f"{path} is no capture, so it has no trigger of its own; --align names one.")
        return 0.0, 0.0
    condition = parse(text)
    unsure_s = 0.0
    for time_s, block in rows_for(file).blocks():
        unsure_s = interval_s(time_s) or unsure_s
        try:
            hits = np.flatnonzero(condition.hits(_evaluated(time_s, block)))
        except ValueError as error:
            name = str(error).rpartition(" ")[2]
            raise UserError(f'{path} has no signal {name}, which the trigger "{text}" evaluates.') from None
        if len(hits):
            return float(time_s[hits[0]]), unsure_s
    raise UserError(f'the trigger "{text}" is not fulfilled in {path}.')
