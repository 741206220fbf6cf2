"""The rows of a trace or a recording as intervals within which torque, flux and current are known by their extremes.

A row has the time of its end and covers what came since the row before. Of a trace the plant's values count, as in
sextant-mil, of a recording the drive's own.
"""

from dataclasses import dataclass

import numpy as np

from .errors import UserError
from .recording.model import begin_of_run
from .signal_file import GroupRows, SignalFile

LOST = 1.5  # intervals from row to row, beyond which a row is missing between them
QUANTITIES = ("torque_mean_nm", "torque_min_nm", "torque_max_nm", "flux_mean_wb", "flux_min_wb", "flux_max_wb")


@dataclass(frozen=True)
class Course:
    """A quantity over the rows: its mean in each lies between two values, and so do its minimum and its maximum."""

    mean_low: np.ndarray
    mean_high: np.ndarray
    min_low: np.ndarray
    min_high: np.ndarray
    max_low: np.ndarray
    max_high: np.ndarray

    @classmethod
    def of(cls, mean: np.ndarray, low: np.ndarray, high: np.ndarray, known: np.ndarray) -> "Course":
        """Of a quantity that the rows have. Where it is not known anything is possible."""
        return cls(mean, mean, low, low, high, high).within(known)

    def within(self, known: np.ndarray) -> "Course":
        ends = (-np.inf, np.inf) * 3
        columns = (self.mean_low, self.mean_high, self.min_low, self.min_high, self.max_low, self.max_high)
        return Course(*(np.where(known & np.isfinite(c), c, end) for c, end in zip(columns, ends, strict=True)))

    def less(self, low: np.ndarray, high: np.ndarray) -> "Course":
        """The difference to a quantity that runs anywhere between two values within each row."""
        return Course(
            self.mean_low - high, self.mean_high - low, self.min_low - high, self.min_high - low,
            self.max_low - high, self.max_high - low,
        )  # fmt: skip


@dataclass(frozen=True)
class Rows:
    """Intervals from begin to end. [s]"""

    begin_s: np.ndarray
    end_s: np.ndarray
    requested: np.ndarray  # torque request from the end of the row on [N·m]
    torque: Course  # [N·m]
    error: Course  # torque less request [N·m]
    flux: Course  # magnitude [Wb]
    current_max: np.ndarray  # magnitude of the current vector; infinite where it is not known [A]
    phase_max: np.ndarray  # largest of the phases at the end of the row [A]
    columns: frozenset[str]  # names of the signals that the file has


def _begin(file: SignalFile, rows: GroupRows) -> tuple[np.ndarray, bool]:
    """Where each row begins, and whether the first one begins with the run, of which nothing was before. A recording
    has no beginning of its first row: it is empty."""
    end_s = rows.time_s
    source = rows.source
    is_run = begin_of_run(source.metadata, next(source.blocks(file.main, 1))) is not None
    first = min(0.0, end_s[0]) if is_run else end_s[0]
    return np.concatenate(([first], end_s[:-1])), is_run


def _column(rows: GroupRows, plant: GroupRows | None, name: str) -> np.ndarray:
    for group in (plant, rows):
        if group is not None and name in (group.group.dtype.names or ()):
            return group.values(name).astype(float)
    return np.full(len(rows.time_s), np.nan)


def _columns(*groups: GroupRows | None) -> frozenset[str]:
    return frozenset(name for group in groups if group is not None for name in group.group.dtype.names or ())


def rows_of(file: SignalFile, zero_s: float) -> Rows:
    """zero_s: the beginning of the scenario on the time axis of the file. [s] UserError: it has no telemetry."""
    main = file.groups[file.main]
    if missing := sorted({"torque_requested_nm", "torque_min_nm"} - _columns(main)):
        lacks = f"lacks {' and '.join(missing)} of a drive's telemetry"
        raise UserError(f"{file.path} {lacks}, of which a scenario's limits are evaluated.")
    plant = (
        file.groups["plant"] if "plant" in file.filled() and file.groups["plant"].group.time_of == file.main else None
    )
    begin_s, is_run = _begin(file, main)
    end_s = main.time_s
    lengths = end_s - begin_s
    known = lengths <= LOST * np.median(lengths[1:] if len(lengths) > 1 else lengths)
    torque, flux = (
        Course.of(*(_column(main, plant, name) for name in names_of), known)
        for names_of in (QUANTITIES[:3], QUANTITIES[3:])
    )
    requested = main.values("torque_requested_nm").astype(float)
    before = np.concatenate(([0.0 if is_run else requested[0]], requested[:-1]))
    error = torque.less(np.minimum(before, requested), np.maximum(before, requested)).within(known)
    current = _column(main, plant, "current_max_a")
    phases = np.abs([_column(main, plant, f"i_{phase}_a") for phase in "abc"])
    return Rows(
        begin_s - zero_s, end_s - zero_s, requested, torque, error, flux,
        np.where(known & np.isfinite(current), current, np.inf), np.nan_to_num(np.max(phases, axis=0)),
        _columns(main, plant),
    )  # fmt: skip
