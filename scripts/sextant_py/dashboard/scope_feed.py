"""The scopes of the pages, one a page, on the waveform of a drive, which is read only while a page has its scope on."""

import threading
import time
from collections.abc import Callable, Hashable
from typing import Any

import numpy as np

from .. import dds
from ..errors import UserError
from ..recording import topics
from ..recording.live import WAVEFORM_DEPTH
from ..recording.losses import LossCounter, Losses
from ..scope.capture import Capture
from ..scope.scope import Scope, Settings
from .frames import CAPTURE, HEADER

POLL_S = 0.03
REPORT_S = 0.2
MOST_S = 1.0  # of a capture that a page draws
LOCUS_ROWS = 800  # of the newest rows, of which the page draws the flux
LOCUS_EVERY = 4
SPACING_S = 0.2  # between captures that a page is shown


def settings_of(message: dict[str, Any]) -> Settings:
    """The settings in a page's message. UserError: one sentence."""
    times = [message.get(name) for name in ("before_ms", "after_ms", "hold_off_ms")]
    if not all(isinstance(value, (int, float)) and not isinstance(value, bool) for value in times):
        raise UserError("before_ms, after_ms and hold_off_ms must be numbers.")
    before_s, after_s, hold_off_s = (value * 1e-3 for value in times)
    if before_s + after_s > MOST_S:
        raise UserError(f"the page's scope captures at most {MOST_S:g} s; scripts/scope captures more.")
    settings = Settings(str(message.get("trigger", "")), str(message.get("mode")), before_s, after_s, hold_off_s)
    settings.check()
    return settings


def columns() -> tuple[str, ...]:
    """The columns of a capture as the page gets it."""
    return topics.group_of(topics.WAVEFORM).dtype.names


def frame_of(number: int, capture: Capture) -> bytes:
    """The rows, laid out as those of telemetry; t_ns counts from the trigger."""
    rows = capture.rows
    table = np.stack([rows[name].astype("<f8") for name in columns()])
    table[columns().index("t_ns")] = rows["t_ns"].astype(np.int64) - capture.trigger_ns
    return HEADER.pack(CAPTURE, number, len(table), len(rows)) + table.tobytes()


class PageScope:
    def __init__(self, drive_id: int, settings: Settings) -> None:
        self.drive_id = drive_id
        self.scope = Scope(settings)
        self.losses = LossCounter()
        self._shown_s = 0.0

    def take(self, rows: np.ndarray) -> list[Capture]:
        """The captures to show: with frequent triggers not every one."""
        self.losses.take(topics.WAVEFORM, rows)
        shown = []
        for capture in self.scope.take(rows):
            if time.monotonic() - self._shown_s >= SPACING_S:
                self._shown_s = time.monotonic()
                shown.append(capture)
        return shown


class ScopeFeed:
    """Reads DriveWaveform in a thread of its own and calls `show` with what a page is to be shown, from there."""

    def __init__(self, domain: int, show: Callable[[Hashable, dict[str, Any], Capture | None], None]) -> None:
        self._domain = domain
        self._show = show
        self._lock = threading.Lock()
        self._scopes: dict[Hashable, PageScope] = {}
        self._changed = threading.Event()
        self._is_ended = False
        self._thread = threading.Thread(target=self._run, name="scope", daemon=True)

    def start(self) -> None:
        self._thread.start()

    def stop(self) -> None:
        self._is_ended = True
        self._changed.set()
        self._thread.join(5.0)

    def arm(self, page: Hashable, drive_id: int, settings: Settings) -> None:
        with self._lock:
            self._scopes[page] = PageScope(drive_id, settings)
        self._changed.set()

    def turn_off(self, page: Hashable) -> None:
        with self._lock:
            self._scopes.pop(page, None)

    def _run(self) -> None:
        while not self._is_ended:
            self._changed.wait()
            self._changed.clear()
            self._watch()

    def _watch(self) -> None:
        """Until no page has a scope on; then the drive stops publishing."""
        node = dds.Node(self._domain)
        reader = dds.Subscription(node, topics.TOPICS[topics.WAVEFORM], dds.streaming_qos(WAVEFORM_DEPTH))
        try:
            self._read(node, reader)
        finally:
            reader.close()

    def _read(self, node: dds.Node, reader: dds.Subscription) -> None:
        report_s = 0.0
        while not self._is_ended:
            with self._lock:
                scopes = dict(self._scopes)
            if not scopes:
                return
            node.poll()
            self._hand_out(reader.poll(WAVEFORM_DEPTH), scopes)
            if time.monotonic() >= report_s:
                report_s = time.monotonic() + REPORT_S
                for page, scope in scopes.items():
                    self._show(page, self._report(scope, reader), None)
            time.sleep(POLL_S)

    def _hand_out(self, batches: list[Any], scopes: dict[Hashable, PageScope]) -> None:
        group = topics.group_of(topics.WAVEFORM)
        for drive_id in {scope.drive_id for scope in scopes.values()}:
            own = [batch for batch in batches if batch.drive_id == drive_id and batch.offset_ns]
            if not own:
                continue
            rows = topics.rows_of(group, own)
            locus = self._locus(rows)
            for page, scope in scopes.items():
                if scope.drive_id == drive_id:
                    self._show(page, locus, None)
                    for capture in scope.take(rows):
                        self._show(page, self._described(capture, drive_id), capture)

    @staticmethod
    def _locus(rows: np.ndarray) -> dict[str, Any]:
        """The newest flux, and the switching state and sector at its end."""
        newest = rows[-LOCUS_ROWS:][::LOCUS_EVERY]
        flux = {name: np.nan_to_num(newest[f"flux_{name}_wb"]).round(5).tolist() for name in ("alpha", "beta")}
        return {
            "type": "locus",
            **flux,
            "switch_state": int(rows["switch_state"][-1]),
            "sector": int(rows["sector"][-1]),
        }

    @staticmethod
    def _described(capture: Capture, drive_id: int) -> dict[str, Any]:
        return {
            "type": "capture",
            "drive": drive_id,
            "trigger": capture.trigger,
            "rows": len(capture.rows),
            "missing": capture.periods_missing,
            "period_ns": int(capture.rows["period_ns"][-1]),
        }

    @staticmethod
    def _report(scope: PageScope, reader: dds.Subscription) -> dict[str, Any]:
        losses = scope.losses.of.get(topics.WAVEFORM, Losses())
        return {
            "type": "scope",
            "state": scope.scope.state,
            "trigger": scope.scope.settings.trigger,
            "captures": scope.scope.captures,
            "rows": losses.rows,
            "lost": losses.lost,
            "problem": None if losses.rows else reader.diagnosis(),
        }
