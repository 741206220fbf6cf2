"""The faults of a trace or a recording, with the times at which they latched."""

from dataclasses import dataclass

import numpy as np

from .drive_view import fault_names
from .recording.topics import STATE
from .signal_file import GroupRows, SignalFile
from .telemetry_contract import enumerators

FAULT = "FAULT"  # the state, where a file has no names of faults
STATES = "DriveStateKind"


@dataclass(frozen=True)
class RecordedFault:
    """A fault that latched, by its name; FAULT where the file has the drive's state alone."""

    name: str
    t_s: float  # on the time axis of the file's signals


def latched_faults(time_s: np.ndarray, masks: np.ndarray, firsts: np.ndarray) -> list[RecordedFault]:
    """Each bit at the row in which it is set and was not before; of one row the first fault first, then by bit."""
    found, before = [], 0
    for t_s, latched, first in zip(time_s.tolist(), masks.tolist(), firsts.tolist(), strict=True):
        new = latched & ~before
        if first >= 0 and new >> first & 1:
            found += [RecordedFault(name, t_s) for name in fault_names(1 << first)]
            new &= ~(1 << first)
        found += [RecordedFault(name, t_s) for name in fault_names(new)]
        before = latched
    return found


def _entries(rows: GroupRows) -> list[RecordedFault]:
    """The entries into the state FAULT; the first row counts as one."""
    in_fault = rows.values("state") == enumerators(STATES).index(FAULT)
    entered = in_fault & ~np.concatenate(([False], in_fault[:-1]))
    return [RecordedFault(FAULT, t_s) for t_s in rows.time_s[entered].tolist()]


def faults_of(file: SignalFile) -> list[RecordedFault]:
    """In the order in which they latched. Names are in `drive_state`; the other groups have the drive's state."""
    filled = file.filled()
    if STATE in filled:
        rows = file.groups[STATE]
        return latched_faults(rows.time_s, rows.values("faults_latched"), rows.values("first_fault"))
    main = file.groups[file.main]
    return _entries(main) if "state" in (main.group.dtype.names or ()) else []
