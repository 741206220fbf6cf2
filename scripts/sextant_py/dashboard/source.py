"""The drives of a DDS domain, polled by a thread of its own: frames and reports for the pages."""

import math
import threading
import time
from collections.abc import Callable
from typing import Any

from ..dds import TELEMETRY, Drive, Telemetry
from ..drive_view import TIMEOUT_S, fault_names
from ..monitor import PATIENCE_S, plain
from ..reports import FOLLOWING_STATES
from ..tracking import Tracking
from .events import Events
from .frames import TelemetryFrames

FRAMES_HZ = 30
REPORT_S = 0.2
DEPTH = 1000


def finite(value: Any) -> Any:
    """The value with None for every number that JSON cannot hold."""
    if isinstance(value, dict):
        return {key: finite(entry) for key, entry in value.items()}
    if isinstance(value, list):
        return [finite(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


class Source:
    """Calls `deliver` with each frame and `report` with the state of affairs, in the polling thread."""

    def __init__(self, domain: int, deliver: Callable[[int, bytes], None], report: Callable[[dict], None]) -> None:
        self._telemetry = Telemetry(domain, DEPTH)
        self._deliver, self._report = deliver, report
        self._frames = TelemetryFrames()
        self._tracking: dict[int, Tracking] = {}
        self._events: dict[int, Events] = {}
        self._began_s = time.monotonic()
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="telemetry", daemon=True)

    def start(self) -> None:
        self._thread.start()

    def stop(self) -> None:
        self._stop.set()
        self._thread.join(5.0)

    def _run(self) -> None:
        due_s, report_s, reported = time.monotonic(), 0.0, ()
        while not self._stop.wait(max(due_s - time.monotonic(), 0.0)):
            due_s = max(due_s + 1 / FRAMES_HZ, time.monotonic())
            self._pass_on(self._telemetry.poll())
            self._note_changes()
            latest = tuple((key, drive.state and drive.state.sequence) for key, drive in self._telemetry.drives.items())
            if latest != reported or time.monotonic() >= report_s:
                reported, report_s = latest, time.monotonic() + REPORT_S
                self._report(self.report())

    def _pass_on(self, samples: list[Any]) -> None:
        by_drive: dict[int, list[Any]] = {}
        for sample in samples:
            by_drive.setdefault(sample.drive_id, []).append(sample)
        for drive_id, found in by_drive.items():
            self._track(drive_id, found[-1])
            self._deliver(drive_id, self._frames.encode(drive_id, found))

    def _note_changes(self) -> None:
        for drive_id, drive in self._telemetry.drives.items():
            events = self._events.setdefault(drive_id, Events())
            newest_ns = drive.telemetry.t_ns if drive.telemetry is not None else None
            while drive.changes:
                events.take(drive.changes.popleft(), newest_ns)

    def _track(self, drive_id: int, sample: Any) -> None:
        tracking = self._tracking.setdefault(drive_id, Tracking())
        if sample.state.name in FOLLOWING_STATES:
            tracking.add(sample.t_ns / 1e9, sample.torque_requested_nm, sample.torque_mean_nm)
        else:
            tracking.pause()

    def report(self) -> dict:
        """The newest of each drive, and why topics have no samples."""
        # Discovery takes a moment; before that, a topic without samples is no problem.
        is_patient = time.monotonic() - self._began_s < PATIENCE_S
        return {
            "type": "status",
            "problems": [] if is_patient else self._telemetry.problems(),
            "drives": [self._report_of(drive) for _, drive in sorted(self._telemetry.drives.items())],
        }

    def _report_of(self, drive: Drive) -> dict:
        state = plain(drive.state)
        if state is not None:
            state["active"] = fault_names(drive.state.faults_active)
            state["latched"] = fault_names(drive.state.faults_latched)
        age_s = time.monotonic() - drive.received_s
        tracking = self._tracking.get(drive.drive_id)
        return finite(
            {
                "drive_id": drive.drive_id,
                "received": drive.received,
                "lost": drive.lost,
                "timed_out": self._timed_out(age_s) if drive.telemetry is not None else None,
                "state": state,
                "events": self._events[drive.drive_id].described() if drive.drive_id in self._events else [],
                "statistics": plain(drive.statistics),
                "deviation_nm": tracking.deviation_nm if tracking else 0.0,
            }
        )

    def _timed_out(self, age_s: float) -> dict | None:
        """For how long no telemetry has come, and whether the topic still has a writer."""
        if age_s < TIMEOUT_S:
            return None
        if self._telemetry.node.writers(TELEMETRY):
            reason = f"{TELEMETRY} still has a writer, but no sample arrives"
        elif self._telemetry.node.participant_count():
            reason = f"no DDS participant of domain {self._telemetry.node.domain} writes {TELEMETRY} any more"
        else:
            reason = f"no other DDS participant is left in domain {self._telemetry.node.domain}"
        return {"age_s": age_s, "reason": reason}
