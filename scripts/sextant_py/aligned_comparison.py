"""Two recordings signal by signal, with the instant of a trigger as time zero of both."""

import json
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from . import alignment
from .comparison import FAULT_TIME, IGNORE, IGNORED, NEAR_ZERO, OUT, SAME, Row, Tolerance, Tolerances
from .comparison import fault_rows as fault_rows_of
from .errors import UserError
from .plots import series
from .plots.panels import AXIS, COUNTER, PHASE
from .recorded_faults import faults_of
from .recording.topics import STATE as STATES
from .signal_file import SignalFile

ENDS = ("from_s", "to_s")  # rows of the time that is compared
STATE = "state"
ANGLE, TIME_STAMP = "rad", "ns"
Span = tuple[float, float]  # [s]


@dataclass(frozen=True)
class Recording:
    """A recording whose times count from the trigger."""

    path: Path
    signals: series.SeriesFile
    zero_s: float  # the trigger on the axis of the signals
    unsure_s: float  # by which the trigger may have been earlier
    faults: list[dict]  # as a summary has them
    faults_unsure_s: float  # by which a fault may have been earlier

    def time_s(self, signal: series.Series) -> np.ndarray:
        return signal.time_s - self.zero_s


@dataclass(frozen=True)
class Wish:
    """What is compared: signals by their names, none: those that are chosen; and a part of the time that both have."""

    trigger: str
    signals: tuple[str, ...] = ()
    begin_s: float = -np.inf  # from the trigger [s]
    end_s: float = np.inf  # [s]


def trace_of(path: Path) -> Path:
    """The trace of a result directory."""
    if not path.exists():
        raise UserError(f"{path} does not exist.")
    if not path.is_dir():
        return path
    if not (path / "trace.h5").is_file():
        raise UserError(f"{path} holds no trace.h5, which --align compares.")
    return path / "trace.h5"


def faults_of_result(path: Path, file: SignalFile, zero_s: float) -> tuple[list[dict], float]:
    """By the summary beside the trace of a result directory, which has their names, else by the file itself; and how
    much earlier they may have been, where they are known to a row of the telemetry. [s]"""
    unsure_s = 0.0
    summary = path / "summary.json"
    if path.is_dir() and summary.is_file():
        try:
            listed = [(fault["fault"], fault["t_s"]) for fault in json.loads(summary.read_text("utf-8"))["faults"]]
        except (ValueError, KeyError, TypeError):
            raise UserError(f"{summary} is no summary of a run; sextant-mil writes one to summary.json.") from None
    else:
        listed = [(fault.name, fault.t_s) for fault in faults_of(file)]
        unsure_s = 0.0 if STATES in file.filled() else alignment.interval_s(file.groups[file.main].time_s)
    return [{"fault": name, "t_s": t_s - zero_s} for name, t_s in listed], unsure_s


def load(path: Path, trigger: str) -> Recording:
    place = trace_of(path)
    file = SignalFile(place)
    zero_s, unsure_s = alignment.instant(place, file, trigger)
    (signals,) = series.load([place], None, None)
    return Recording(place, signals, zero_s, unsure_s, *faults_of_result(path, file, zero_s))


def _chosen(recording: Recording, wanted: tuple[str, ...]) -> dict[str, series.Series]:
    """The wanted signals; without a wish the state and the quantities of the main group, without those that turn with
    the field, as phases and angles do, and without counters and times."""
    if wanted:
        return {signal.name: signal for name in wanted for signal in recording.signals.find(name)}
    found = {}
    for name, signal in recording.signals.series.items():
        turns = PHASE.fullmatch(signal.stem) or AXIS.fullmatch(signal.stem) or signal.unit == ANGLE
        counts = signal.unit == TIME_STAMP or COUNTER.fullmatch(name) or (signal.is_discrete and name != STATE)
        if name in recording.signals.main and "/" not in name and not turns and not counts:
            found[name] = signal
    return found


def _windows(time_s: np.ndarray, at_s: np.ndarray, unsure_s: float) -> tuple[np.ndarray, np.ndarray]:
    """First and last row of those that may belong to each instant: of `unsure_s` about it, and the row at either
    side, between which the signal goes on."""
    first = np.searchsorted(time_s, at_s - unsure_s, "right") - 1
    last = np.searchsorted(time_s, at_s + unsure_s, "left")
    return np.clip(first, 0, len(time_s) - 1), np.clip(last, 0, len(time_s) - 1)


def _nearest(values: np.ndarray, first: np.ndarray, last: np.ndarray, other: np.ndarray, discrete: bool) -> np.ndarray:
    """Of each window the value nearest to the other recording's: of a quantity any between the smallest and the
    largest, of a state one that occurs. NaN where the window has none, or has a row without a value and the other
    recording has none."""
    low, high = np.full(len(other), np.nan), np.full(len(other), np.nan)
    exact = np.zeros(len(other), bool)
    for step in range(int((last - first).max()) + 1):
        row = np.minimum(first + step, last)
        low, high = np.fmin(low, values[row]), np.fmax(high, values[row])
        exact |= (values[row] == other) | (np.isnan(values[row]) & np.isnan(other))
    nearest = low if discrete else np.where(np.isnan(other), low, np.clip(other, low, high))
    return np.where(exact, other, nearest)


def _signal_row(
    name: str, a: Recording, b: Recording, tolerance: Tolerance, scales: dict[str, float], span: Span
) -> Row:
    """The instant at which the signal is furthest beyond its tolerance, or differs most."""
    one, other = a.signals.series[name], b.signals.series[name]
    if tolerance.text == IGNORE:
        return Row("", name, None, None, tolerance.text, IGNORED)
    at_s = b.time_s(other)
    within = (at_s >= span[0]) & (at_s <= span[1])
    at_s, second = at_s[within], other.values[within].astype(float)
    if not len(at_s):
        return Row("", name, None, None, tolerance.text, OUT, "no row of it is in the span that both have")
    first_row, last_row = _windows(a.time_s(one), at_s, max(a.unsure_s, b.unsure_s))
    first = _nearest(one.values.astype(float), first_row, last_row, second, one.is_discrete)
    with np.errstate(invalid="ignore"):
        distance = np.where(np.isnan(first) & np.isnan(second), 0.0, np.abs(second - first))
    distance = np.where(np.isnan(distance), np.inf, distance)
    worst = int(distance.argmax())
    scale = max(_scale(one.values), NEAR_ZERO * scales.get(one.unit, 0.0))
    is_out = not distance[worst] <= (0.0 if one.is_discrete else tolerance.limit(scale))
    values = [None if np.isnan(value) else float(value) for value in (first[worst], second[worst])]
    texts = ["no value" if value is None else f"{value:.6g}" for value in values]
    reason = f"{texts[1]} instead of {texts[0]} at {at_s[worst]:.6g} s: tolerance {tolerance.text}" if is_out else ""
    return Row("", name, *values, tolerance.text, OUT if is_out else SAME, reason)


def _scale(values: np.ndarray) -> float:
    finite = values[np.isfinite(values)] if values.dtype.kind == "f" else values
    return float(np.abs(finite.astype(float)).max()) if len(finite) else 0.0


def _span(a: Recording, b: Recording, names: list[str], wish: Wish) -> Span:
    """What both have of the signals, within the wish. [s]"""
    times = [recording.time_s(recording.signals.series[name]) for recording in (a, b) for name in names]
    begin, end = max(time_s[0] for time_s in times), min(time_s[-1] for time_s in times)
    if end <= begin:
        raise UserError(f"{a.path} and {b.path} have no time about the trigger in common.")
    span = max(begin, wish.begin_s), min(end, wish.end_s)
    if span[1] <= span[0]:
        raise UserError(f"--from and --to leave nothing of the common time, from {begin:.6g} s to {end:.6g} s.")
    return float(span[0]), float(span[1])


def _fault_rows(a: Recording, b: Recording, span: Span, tolerance: Tolerance) -> list[Row]:
    unsure = max(a.unsure_s, b.unsure_s) + max(a.faults_unsure_s, b.faults_unsure_s)
    begin, end = span[0] - unsure, span[1] + unsure
    summaries = [{"faults": [fault for fault in r.faults if begin <= fault["t_s"] <= end]} for r in (a, b)]
    if not tolerance.relative and tolerance.text != IGNORE:
        tolerance = replace(tolerance, text=f"{tolerance.amount + unsure:.3g}", amount=tolerance.amount + unsure)
    return fault_rows_of("", *summaries, tolerance)


def compare(paths: tuple[Path, Path], wish: Wish, tolerances: Tolerances) -> list[Row]:
    """A row for the faults, for the time of each, and for each signal that both have.

    The instant of a trigger lies between a row and the one before: with u_A and u_B between two rows, the one recording
    is off the other by −u_B … u_A. So a value of B agrees with any that A passes within max(u_A, u_B) of it, and that
    is added to the tolerance of a fault's time. A share is of the largest magnitude of the signal in A, and of a
    hundredth of that of its unit at least. UserError: they cannot be aligned.
    """
    a, b = (load(path, wish.trigger) for path in paths)
    chosen = [_chosen(recording, wish.signals) for recording in (a, b)]
    names = [name for name in chosen[0] if name in chosen[1]]
    if not names:
        raise UserError(f"{a.path} and {b.path} have no signal in common to compare.")
    for name in tolerances.given:
        if name not in chosen[0] and name != FAULT_TIME:
            raise UserError(f'no signal "{name}" is compared, for which a tolerance is given; --signal names signals.')
    span = _span(a, b, names, wish)
    scales: dict[str, float] = {}
    for signal in chosen[0].values():
        scales[signal.unit] = max(scales.get(signal.unit, 0.0), _scale(signal.values))
    rows = [Row("", "trigger_s", a.zero_s, b.zero_s, "", IGNORED)]
    rows += [Row("", name, t_s, t_s, "", IGNORED) for name, t_s in zip(ENDS, span, strict=True)]
    rows += _fault_rows(a, b, span, tolerances.of(FAULT_TIME))
    for name in dict.fromkeys([*chosen[0], *chosen[1]]):
        if name in names:
            rows.append(_signal_row(name, a, b, tolerances.of(name), scales, span))
        else:
            which = "first" if name in chosen[0] else "second"
            rows.append(Row("", name, None, None, "", OUT, f"only the {which} recording has this signal"))
    return [replace(row, scenario=f"{a.path} / {b.path}, aligned at: {wish.trigger}") for row in rows]
