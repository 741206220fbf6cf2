"""Everything that a drive publishes over DDS, kept for evaluation."""

import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from cyclonedds.core import Policy, Qos
from cyclonedds.util import duration
from sextant_py import dds

POLL_S = 0.02
DEPTH = 5000
HELPING = 32
PATIENCE_S = 60.0  # a wait ends as soon as what it waits for is there


class Span:
    """Consecutive samples of DriveTelemetry; a field is an array over them."""

    def __init__(self, samples: list[Any]) -> None:
        self.samples = samples

    def __len__(self) -> int:
        return len(self.samples)

    def __getattr__(self, field: str) -> np.ndarray:
        return np.array([getattr(sample, field) for sample in self.samples])

    @property
    def states(self) -> list[str]:
        return [sample.state.name for sample in self.samples]

    def where(self, keep: np.ndarray) -> "Span":
        return Span([sample for sample, kept in zip(self.samples, keep, strict=True) if kept])


class TelemetryRecord:
    """Reads the three topics of one drive; samples pile up in the readers until somebody looks."""

    def __init__(self, domain: int, drive_id: int = 1) -> None:
        self._drive_id = drive_id
        self._node = dds.Node(domain)
        latched = Qos(
            Policy.Reliability.Reliable(duration(seconds=1)),
            Policy.Durability.TransientLocal,
            Policy.History.KeepLast(DEPTH),
        )
        self._stream = dds.Subscription(self._node, dds.TELEMETRY, dds.streaming_qos(DEPTH))
        self._states = dds.Subscription(self._node, dds.STATE, latched)
        self._statistics = dds.Subscription(self._node, dds.STATISTICS, latched)
        self.samples: list[Any] = []
        self.states: list[Any] = []
        self.statistics: list[Any] = []

    def poll(self) -> None:
        if not self._connected():
            self._node.poll()
        self.samples += self._mine(self._stream)
        self.states += self._mine(self._states)
        self.statistics += self._mine(self._statistics)

    def _mine(self, topic: dds.Subscription) -> list[Any]:
        """New samples of our drive. Taken in small helpings: room for many is expensive in a guest."""
        found: list[Any] = []
        while helping := topic.poll(HELPING):
            found += [sample for sample in helping if sample.drive_id == self._drive_id]
            if len(helping) < HELPING:
                break
        return found

    def _connected(self) -> bool:
        return all(topic.samples for topic in (self._stream, self._states, self._statistics))

    def wait(self, condition: Callable[["TelemetryRecord"], Any], what: str, timeout_s: float = PATIENCE_S) -> Any:
        """Polls until the condition holds; returns its value."""
        deadline = time.monotonic() + timeout_s
        while True:
            self.poll()
            if value := condition(self):
                return value
            if time.monotonic() > deadline:
                pytest.fail(f"waited {timeout_s:g} s for {what}; {self.last_words()}")
            time.sleep(POLL_S)

    def last_words(self) -> str:
        """What is known of the drive, for whoever waited in vain."""
        reasons = [topic.diagnosis() for topic in (self._stream, self._states, self._statistics)]
        if any(reasons):
            return "; ".join(reason for reason in reasons if reason)
        last, state = self.samples[-1], self.states[-1]
        return f"the drive is in {last.state.name} ({state.reason}), {last.torque_reference_nm:g} N·m admitted"

    def wait_until_heard(self) -> None:
        self.wait(lambda own: own.samples and own.states and own.statistics, "all three topics")

    def wait_for_state(self, *names: str) -> None:
        found = " or ".join(names)
        self.wait(lambda own: own.samples and own.samples[-1].state.name in names, f"state {found}")

    def run(self, seconds: float) -> Span:
        """The samples of the next so many seconds, on the drive's clock."""
        self.poll()
        if not self.samples:
            pytest.fail("no telemetry has been heard")
        first, begin_ns = len(self.samples), self.samples[-1].t_ns
        end_ns = begin_ns + round(seconds * 1e9)
        self.wait(lambda own: own.samples[-1].t_ns >= end_ns, f"{seconds:g} s of telemetry", seconds + PATIENCE_S)
        return Span(self.samples[first:])

    def everything(self) -> Span:
        self.poll()
        return Span(self.samples)

    def counted_commands(self) -> tuple[int, int]:
        """Commands accepted and rejected since start, by statistics published after this call."""
        self.poll()
        known = len(self.statistics)
        # The first to come may have been under way already.
        self.wait(lambda own: len(own.statistics) >= known + 2, "RealTimeStatistics")
        return self.statistics[-1].commands_received, self.statistics[-1].commands_rejected
