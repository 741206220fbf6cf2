"""What happened at which time: faults, magnetising, late wake-ups and the trigger, drawn into every panel."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import UserError
from ..recorded_faults import latched_faults
from ..recording.model import MAIN
from ..recording.topics import STATE, WAVEFORM
from ..telemetry_contract import enumerators
from .series import SeriesFile

STATISTICS = "statistics"
FAULT, MAGNETISING, LATE, TRIGGER = "fault", "magnetising", "late", "trigger"  # kinds of a mark
COLOURS = {FAULT: "#d62728", MAGNETISING: "#2ca02c", LATE: "#9467bd", TRIGGER: "#7f7f7f"}
NEAR = 0.02  # of the span: marks that are closer share a text
MOST_WORDS = 3  # of a text
MOST_LATE = 6  # marks of late wake-ups and gaps that have a text each


@dataclass(frozen=True)
class Mark:
    """An instant, or a span up to end_s, with its text."""

    kind: str
    begin_s: float
    end_s: float | None
    text: str


def _values(file: SeriesFile, group: str, *names: str) -> tuple[np.ndarray, ...] | None:
    """Times [s] and signals of a group; None where the file has them not, or not within the span."""
    found = {series.column.name: series for series in file.series.values() if series.rows.group.name == group}
    if not all(name in found for name in names):
        return None
    try:
        return (found[names[0]].time_s, *(found[name].values for name in names))
    except UserError:  # no sample in the span
        return None


def _states(file: SeriesFile) -> tuple[np.ndarray, np.ndarray] | None:
    """Times [s] and states: those of each row where there are rows, otherwise the changes."""
    for group in (MAIN, WAVEFORM, STATE):
        if found := _values(file, group, "state"):
            return found[0], found[1]
    return None


def _entries(values: np.ndarray, value: int) -> tuple[np.ndarray, np.ndarray]:
    """The first rows of the runs of a value, and the first rows behind them, which may lie behind the last row."""
    inside = np.concatenate(([False], values == value, [False])).astype(np.int8)
    edges = np.diff(inside)
    return np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)


def _magnetising(file: SeriesFile) -> list[Mark]:
    if (found := _states(file)) is None:
        return []
    time_s, state = found
    begins, ends = _entries(state, enumerators("DriveStateKind").index("MAGNETISING"))
    last = len(time_s) - 1
    return [
        Mark(MAGNETISING, float(time_s[begin]), float(time_s[min(end, last)]), "magnetising")
        for begin, end in zip(begins, ends, strict=True)
    ]


def _faults(file: SeriesFile) -> list[Mark]:
    """Those that latch, by their names; without the changes of the drive's state the entries of FAULT."""
    if (found := _values(file, STATE, "faults_latched", "first_fault")) and (latched := latched_faults(*found)):
        return [Mark(FAULT, fault.t_s, None, fault.name) for fault in latched]
    if (states := _states(file)) is None:
        return []
    begins, _ = _entries(states[1], enumerators("DriveStateKind").index("FAULT"))
    return [Mark(FAULT, float(states[0][begin]), None, "FAULT") for begin in begins if begin > 0]


def _late_wake_ups(file: SeriesFile) -> list[Mark]:
    """The intervals of the statistics that count overruns."""
    if (found := _values(file, STATISTICS, "overruns")) is None:
        return []
    time_s, overruns = found[0], found[1].astype(np.int64)
    return [
        Mark(LATE, float(time_s[at]), float(time_s[at + 1]), f"late wake-ups: {count}")
        for at, count in enumerate(np.diff(overruns))
        if count > 0
    ]


def _gaps(file: SeriesFile) -> list[Mark]:
    """Control periods of the waveform without a row."""
    if (found := _values(file, WAVEFORM, "period_ns")) is None:
        return []
    time_s, period_s = found[0], found[1][1:] * 1e-9
    missing = np.rint((np.diff(time_s) - period_s) / np.where(period_s > 0, period_s, np.inf)).astype(int)
    return [
        Mark(LATE, float(time_s[at]), float(time_s[at + 1]), f"periods without a row: {missing[at]}")
        for at in np.flatnonzero(missing > 0)
    ]


def of(files: list[SeriesFile]) -> list[Mark]:
    """The marks of the files by their time; of several files with the file's label."""
    found = []
    for file in files:
        marks = [*_magnetising(file), *_faults(file), *_late_wake_ups(file), *_gaps(file)]
        if file.trigger is not None:
            marks.append(Mark(TRIGGER, 0.0, None, f"trigger: {file.trigger}"))
        end = f", {file.label}" if len(files) > 1 else ""
        found += [Mark(mark.kind, mark.begin_s, mark.end_s, mark.text + end) for mark in marks]
    return sorted(found, key=lambda mark: mark.begin_s)


def within(marks: Sequence[Mark], begin_s: float, end_s: float) -> list[Mark]:
    """The marks of a span; those that reach out of it are cut there."""
    found = []
    for mark in marks:
        if mark.begin_s > end_s or (mark.begin_s if mark.end_s is None else mark.end_s) < begin_s:
            continue
        until = None if mark.end_s is None else min(mark.end_s, end_s)
        found.append(Mark(mark.kind, max(mark.begin_s, begin_s), until, mark.text))
    return found


def _with_late_named_once(marks: Sequence[Mark]) -> list[Mark]:
    """Where late wake-ups and gaps are many, the first of them stands for all."""
    late = [mark for mark in marks if mark.kind == LATE]
    if len(late) <= MOST_LATE:
        return list(marks)
    first = Mark(LATE, late[0].begin_s, late[0].end_s, f"late wake-ups or gaps at {len(late)} times")
    return [first if mark is late[0] else mark for mark in marks if mark.kind != LATE or mark is late[0]]


def texts(marks: Sequence[Mark], span_s: float, near: float = NEAR) -> list[tuple[Mark, str]]:
    """The texts that have room, each with the first of the marks that it is of; near: share of the span."""
    grouped: list[tuple[Mark, list[str]]] = []
    for mark in _with_late_named_once(marks):
        if grouped and mark.begin_s - grouped[-1][0].begin_s < near * span_s:
            grouped[-1][1].append(mark.text)
        else:
            grouped.append((mark, [mark.text]))
    found = []
    for mark, parts in grouped:
        words = list(dict.fromkeys(parts))
        more = f" + {len(words) - MOST_WORDS} more" if len(words) > MOST_WORDS else ""
        found.append((mark, ", ".join(words[:MOST_WORDS]) + more))
    return found
