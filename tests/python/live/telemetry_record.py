"""Everything that a drive publishes over DDS, kept for evaluation."""

import time
from collections.abc import Callable
from typing import Any

import numpy as np
from cyclonedds.core import Policy, Qos
from cyclonedds.util import duration
from failures import NotSeenError
from sextant_py import dds

POLL_S = 0.02
DEPTH = 5000
HELPING = 32


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

    def between(self, begin_ns: int, end_ns: int) -> "Span":
        """Samples whose interval ends in (begin_ns, end_ns]."""
        return self.where((self.t_ns > begin_ns) & (self.t_ns <= end_ns))

    def last(self, seconds: float) -> "Span":
        """The samples of the last so many seconds."""
        return self.where(self.t_ns > self.t_ns[-1] - seconds * 1e9)

    @property
    def interval_ns(self) -> float:
        """Time from one sample to the next."""
        return float(np.median(np.diff(self.t_ns)))

    def command_times_ns(self) -> np.ndarray:
        """Receive times of the commands that the drive acted on, each once."""
        return np.unique(self.command_received_ns)

    def stalls_ns(self) -> list[tuple[int, int]]:
        """Where the host kept the drive from running, or samples from arriving: begin and end of each such gap."""
        late = np.flatnonzero(np.diff(self.t_ns) > 1.5 * self.interval_ns)
        return [(int(self.t_ns[i]), int(self.t_ns[i + 1])) for i in late]

    def without_stalls(self, settling_ns: int) -> "Span":
        """Without the samples up to settling_ns after a gap: in it the last switching state went on acting."""
        keep = np.ones(len(self), dtype=bool)
        for _, end_ns in self.stalls_ns():
            keep &= (self.t_ns < end_ns) | (self.t_ns >= end_ns + settling_ns)
        return self.where(keep)


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

    def wait(self, condition: Callable[["TelemetryRecord"], Any], what: str, timeout_s: float = 10.0) -> Any:
        """Polls until the condition holds; returns its value."""
        deadline = time.monotonic() + timeout_s
        while True:
            self.poll()
            if value := condition(self):
                return value
            if time.monotonic() > deadline:
                raise NotSeenError(f"waited {timeout_s:g} s for {what}; {self._last_words()}")
            time.sleep(POLL_S)

    def _last_words(self) -> str:
        reasons = [topic.diagnosis() for topic in (self._stream, self._states, self._statistics)]
        if any(reasons):
            return "; ".join(reason for reason in reasons if reason)
        last, state = self.samples[-1], self.states[-1]
        return f"the drive is in {last.state.name} ({state.reason}), {last.torque_reference_nm:g} N·m admitted"

    def wait_until_heard(self) -> None:
        self.wait(lambda own: own.samples and own.states and own.statistics, "all three topics", 20.0)

    def wait_for_state(self, *names: str, timeout_s: float = 10.0) -> None:
        found = " or ".join(names)
        self.wait(lambda own: own.samples and own.samples[-1].state.name in names, f"state {found}", timeout_s)

    def run(self, seconds: float) -> Span:
        """The samples of the next so many seconds, on the drive's clock."""
        self.poll()
        if not self.samples:
            raise NotSeenError("no telemetry has been heard")
        first, begin_ns = len(self.samples), self.samples[-1].t_ns
        end_ns = begin_ns + round(seconds * 1e9)
        self.wait(lambda own: own.samples[-1].t_ns >= end_ns, f"{seconds:g} s of telemetry", seconds + 10.0)
        return Span(self.samples[first:])

    def everything(self) -> Span:
        self.poll()
        return Span(self.samples)

    def counted_commands(self) -> tuple[int, int]:
        """Commands accepted and rejected since start, by statistics published after this call."""
        self.poll()
        known = len(self.statistics)
        # The first to come may have been under way already.
        self.wait(lambda own: len(own.statistics) >= known + 2, "RealTimeStatistics", 5.0)
        return self.statistics[-1].commands_received, self.statistics[-1].commands_rejected
