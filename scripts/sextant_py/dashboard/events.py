"""What has happened to a drive: changes of its state and its faults, with their times."""

import time
from collections import deque
from typing import Any

from ..drive_view import fault_names

KEPT = 20


class Events:
    """The newest changes of one drive. A DriveState that repeats the one before is none."""

    def __init__(self) -> None:
        self._last: Any = None
        self._found: deque[dict] = deque(maxlen=KEPT)

    def take(self, state: Any, newest_ns: int | None, now_s: float | None = None) -> None:
        """A sample of DriveState. newest_ns: time of the newest telemetry, by which the time of day of an older change
        is known; now_s: the time of day [s since 1970]."""
        before, self._last = self._last, state
        if before is not None and _standing(before) == _standing(state):
            return
        age_s = max(newest_ns - state.t_ns, 0) * 1e-9 if newest_ns is not None else 0.0
        latched, active = (0, 0) if before is None else (before.faults_latched, before.faults_active)
        self._found.append(
            {
                "t_ns": state.t_ns,
                "time_s": (time.time() if now_s is None else now_s) - age_s,
                "from": before.state.name if before is not None and before.state != state.state else None,
                "state": state.state.name,
                "latched": fault_names(state.faults_latched & ~latched),
                "gone": fault_names(active & ~state.faults_active),
                "reset": bool(latched & ~state.faults_latched),
                "reason": state.reason,
            }
        )

    def described(self) -> list[dict]:
        """The newest last."""
        return list(self._found)


def _standing(state: Any) -> tuple:
    return state.state, state.faults_latched, state.faults_active
