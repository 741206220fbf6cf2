"""What a drive publishes while it runs, as blocks of a recording."""

from typing import Any

import numpy as np

from .. import dds
from . import topics
from .can_frames import CanReader, Gap
from .model import MAIN, Group

STREAM_DEPTH = 5000  # samples that wait in a reader, of which none replaces another
WAVEFORM_DEPTH = 400  # batches of 10 ms
HELPING = 200  # samples a take: room for many is expensive


class LiveDrive:
    """The topics of one drive in a domain and, where asked for, the frames of a CAN bus."""

    def __init__(self, domain: int, drive_id: int | None, waveform: bool, can: CanReader | None) -> None:
        self.drive_id = drive_id  # None: the first one received
        self._received: set[int] = set()  # ids of drives
        self.node = dds.Node(domain)
        self._can = can
        quality = {MAIN: dds.streaming_qos(STREAM_DEPTH), topics.WAVEFORM: dds.streaming_qos(WAVEFORM_DEPTH)}
        every_change = dds.latched_qos(STREAM_DEPTH)
        names = [name for name in topics.TOPICS if waveform or name != topics.WAVEFORM]
        self._groups = {name: topics.group_of(name) for name in names}
        self.subscriptions = {
            name: dds.Subscription(self.node, topics.TOPICS[name], quality.get(name, every_change)) for name in names
        }

    def poll(self) -> list[tuple[Group, np.ndarray]]:
        """The rows that have come since the last call."""
        frames = self._can.poll() if self._can else []
        self.node.poll()
        found = []
        for name, subscription in self.subscriptions.items():
            if samples := self._mine(self._taken(subscription)):
                group = self._groups[name]
                found.append((group, topics.rows_of(group, samples)))
        return found + frames

    @staticmethod
    def _taken(subscription: dds.Subscription) -> list[Any]:
        samples = helping = subscription.poll(HELPING)
        while len(helping) == HELPING:
            helping = subscription.poll(HELPING)
            samples = samples + helping
        return samples

    def _mine(self, samples: list[Any]) -> list[Any]:
        self._received |= {sample.drive_id for sample in samples}
        if self.drive_id is None and samples:
            self.drive_id = samples[0].drive_id
        return [sample for sample in samples if sample.drive_id == self.drive_id]

    def gaps(self) -> list[Gap]:
        """Times in which the CAN bus could not be read."""
        return self._can.gaps if self._can else []

    def problems(self) -> list[str]:
        """Why topics have no samples; nobody discovered is one problem, not four, and so is a drive of another id."""
        if self._received and self.drive_id not in self._received:
            there = ", ".join(map(str, sorted(self._received)))
            return [f"no sample of drive {self.drive_id} arrived in domain {self.node.domain}; drives there: {there}."]
        found = [subscription.diagnosis() for subscription in self.subscriptions.values()]
        problems = [problem for problem in found if problem]
        return problems[:1] if not self.node.participant_count() else problems

    def close(self) -> None:
        if self._can:
            self._can.close()
