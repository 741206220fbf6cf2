"""Reading the drive's telemetry: types are discovered from the network, and silence is explained."""

import os
import time
from collections import deque
from dataclasses import dataclass, field
from typing import Any

from .errors import UserError
from .paths import IDL, LOOPBACK
from .telemetry_contract import signals


def loopback_configuration() -> str:
    """The text of configs/cyclonedds_loopback.xml: Cyclone DDS splits a file's name at commas and decodes no %20."""
    try:
        return LOOPBACK.read_text(encoding="utf-8").strip()
    except OSError:
        return f"file://{LOOPBACK}"  # about which Cyclone DDS says what is wrong


# Cyclone DDS reads its configuration once, when the first domain is made.
os.environ.setdefault("CYCLONEDDS_URI", loopback_configuration())

from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsParticipant, BuiltinTopicDcpsPublication, DcpsEndpoint
from cyclonedds.core import DDSException, InstanceState, Listener, Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.dynamic import get_types_for_typeid
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

TELEMETRY = "sextant/DriveTelemetry"
STATE = "sextant/DriveState"
STATISTICS = "sextant/RealTimeStatistics"
WAVEFORM = "sextant/DriveWaveform"
CHANGES = 64  # samples of DriveState that wait for a reader
LARGEST_DOMAIN = 230  # whose ports are within those of UDP

# The identifiers of the DDS specification, 2.3.3 (PSM for C++), and of DDS-XTypes.
_POLICIES = {
    2: "DURABILITY",
    3: "PRESENTATION",
    4: "DEADLINE",
    5: "LATENCY_BUDGET",
    6: "OWNERSHIP",
    8: "LIVELINESS",
    10: "PARTITION",
    11: "RELIABILITY",
    12: "DESTINATION_ORDER",
    23: "DATA_REPRESENTATION",
    24: "TYPE_CONSISTENCY_ENFORCEMENT",
}


def configured_by() -> str:
    """Which configuration of Cyclone DDS is in force, for messages."""
    uri = os.environ["CYCLONEDDS_URI"]
    is_loopback = uri.strip() == loopback_configuration()
    return str(LOOPBACK.relative_to(LOOPBACK.parents[1])) if is_loopback else f"CYCLONEDDS_URI={uri}"


def streaming_qos(depth: int) -> Qos:
    """For DriveTelemetry: the newest samples, none repeated."""
    return Qos(Policy.Reliability.BestEffort, Policy.Durability.Volatile, Policy.History.KeepLast(depth))


def latched_qos(depth: int = 1) -> Qos:
    """For topics that tell a late joiner how things stand. depth: samples that a reader keeps until they are read."""
    reliable = Policy.Reliability.Reliable(duration(milliseconds=100))
    return Qos(reliable, Policy.Durability.TransientLocal, Policy.History.KeepLast(depth))


def contract_fields(struct: str) -> tuple[str, ...]:
    """The fields of a struct of configs/interfaces/telemetry.idl, in order."""
    return tuple(signal.name for signal in signals(struct))


def check_domain(domain: int) -> None:
    if not 0 <= domain <= LARGEST_DOMAIN:
        raise UserError(f"--domain {domain} is not a DDS domain (0 to {LARGEST_DOMAIN}).")


class Node:
    """A participant of a domain that knows who else is there and what they write."""

    def __init__(self, domain: int = 0) -> None:
        check_domain(domain)
        self.domain = domain
        try:
            self.participant = DomainParticipant(domain)
        except DDSException:  # which has no reason; the library prints it
            raise UserError(
                f"DDS cannot start in domain {domain} with {configured_by()}: Cyclone DDS has printed the reason above."
            ) from None
        self._participants = BuiltinDataReader(self.participant, BuiltinTopicDcpsParticipant)
        self._publications = BuiltinDataReader(self.participant, BuiltinTopicDcpsPublication)
        self._others: set[Any] = set()
        self._writers: dict[Any, DcpsEndpoint] = {}

    def poll(self) -> None:
        for sample in self._participants.take(N=100):
            alive = sample.sample_info.instance_state == InstanceState.Alive
            if alive and sample.key != self.participant.guid:
                self._others.add(sample.key)
            else:
                self._others.discard(sample.key)
        for sample in self._publications.take(N=500):
            if sample.sample_info.instance_state == InstanceState.Alive:
                self._writers[sample.key] = sample
            else:
                self._writers.pop(sample.key, None)

    def participant_count(self) -> int:
        """Participants besides this one."""
        return len(self._others)

    def writers(self, topic: str) -> list[DcpsEndpoint]:
        return [writer for writer in self._writers.values() if writer.topic_name == topic]


class Subscription:
    """One topic, read with the type that its writer announces, or with the contract's: where the writer announces none,
    and where its version of the contract is an earlier one, whose missing fields are read as zero."""

    def __init__(self, node: Node, topic: str, qos: Qos) -> None:
        self.topic = topic
        self.type: type | None = None
        self.samples = 0
        self._node = node
        self._qos = qos
        self._reader: DataReader | None = None
        self._refused: dict[Any, str] = {}
        self._incompatible: str | None = None

    def poll(self, limit: int = 1000) -> list[Any]:
        """The samples that have come since the last call."""
        if self._reader is None:
            self._connect()
        if self._reader is None:
            return []
        samples = [sample for sample in self._reader.take(N=limit) if sample.sample_info.valid_data]
        self.samples += len(samples)
        return samples

    def close(self) -> None:
        """Ends the reader, which its writers learn. Cyclone DDS keeps a reader that is only found by the collector of
        cyclic garbage, and a listener makes it one."""
        self._reader = None

    def _connect(self) -> None:
        for writer in self._node.writers(self.topic):
            if writer.key in self._refused:
                continue
            found = self._discover_type(writer)
            if found is None:
                continue
            listener = Listener()
            listener.set_on_requested_incompatible_qos(self._on_incompatible_qos)
            participant = self._node.participant
            self.type = found
            self._reader = DataReader(participant, Topic(participant, self.topic, found), self._qos, listener)
            return

    def _discover_type(self, writer: DcpsEndpoint) -> type | None:
        if writer.type_id is None:
            return self._contract_type(writer)
        try:
            found, _ = get_types_for_typeid(self._node.participant, writer.type_id, duration(seconds=1))
        except DDSException:
            return None
        name, announced = self.topic.partition("/")[2], tuple(found.__annotations__)
        contract = contract_fields(name)
        missing = [field for field in contract if field not in announced]
        if missing and contract[: len(announced)] == announced:
            return self._type_of_contract(name)
        if missing:
            self._refused[writer.key] = (
                f"its type {writer.type_name} lacks {', '.join(missing[:4])}{' …' if len(missing) > 4 else ''}"
                f" of {IDL.relative_to(IDL.parents[2])}"
            )
            return None
        return found

    def _contract_type(self, writer: DcpsEndpoint) -> type | None:
        """The type of the contract, for a writer that tells the name of its type alone."""
        name = self.topic.partition("/")[2]
        if writer.type_name == f"sextant::{name}":
            return self._type_of_contract(name)
        self._refused[writer.key] = f"its type {writer.type_name} comes without a description"
        return None

    @staticmethod
    def _type_of_contract(name: str) -> type:
        from . import telemetry_types

        return telemetry_types.struct(name)

    def _on_incompatible_qos(self, _reader: DataReader, status: Any) -> None:
        self._incompatible = _POLICIES.get(status.last_policy_id, f"number {status.last_policy_id}")

    def diagnosis(self) -> str | None:
        """Why no sample has arrived, in one sentence; None once one has."""
        if self.samples:
            return None
        node, writers = self._node, self._node.writers(self.topic)
        where = f"domain {node.domain}, {configured_by()}"
        if not node.participant_count():
            return (
                f"no other DDS participant was discovered ({where}): is the drive running, with the same"
                " configuration, and does that name an interface that is up?"
            )
        if not writers:
            return f"{node.participant_count()} DDS participant(s) discovered, but none writes {self.topic} ({where})."
        if self._reader is None:
            reasons = [self._refused[writer.key] for writer in writers if writer.key in self._refused]
            if reasons:
                return f"type mismatch: {self.topic} is written, but {reasons[0]}."
            return f"{self.topic} is written, but its type has not been sent yet."
        if self._incompatible:
            return f"incompatible QoS: the writer of {self.topic} does not offer the {self._incompatible} asked for."
        return (
            f"{self.topic} is written, but no sample has arrived: the drive publishes nothing or the network drops it."
        )


@dataclass
class Drive:
    drive_id: int
    telemetry: Any = None
    state: Any = None
    statistics: Any = None
    received: int = 0
    lost: int = 0
    received_s: float = field(default_factory=time.monotonic)
    changes: deque = field(default_factory=lambda: deque(maxlen=CHANGES))  # samples of DriveState, to be taken out

    def take_telemetry(self, sample: Any) -> None:
        if self.telemetry is not None and sample.sequence > self.telemetry.sequence:
            self.lost += sample.sequence - self.telemetry.sequence - 1
        self.telemetry = sample
        self.received += 1
        self.received_s = time.monotonic()


class Telemetry:
    """The three topics of all drives in a domain."""

    def __init__(self, domain: int = 0, depth: int = 1) -> None:
        self.node = Node(domain)
        self.stream = Subscription(self.node, TELEMETRY, streaming_qos(depth))
        self.states = Subscription(self.node, STATE, latched_qos(CHANGES))
        self.statistics = Subscription(self.node, STATISTICS, latched_qos())
        self.drives: dict[int, Drive] = {}

    def _drive(self, sample: Any) -> Drive:
        return self.drives.setdefault(sample.drive_id, Drive(sample.drive_id))

    def poll(self) -> list[Any]:
        """Takes in what has come; returns the new samples of DriveTelemetry."""
        self.node.poll()
        samples = self.stream.poll()
        for sample in samples:
            self._drive(sample).take_telemetry(sample)
        for sample in self.states.poll():
            drive = self._drive(sample)
            drive.state = sample
            drive.changes.append(sample)
        for sample in self.statistics.poll():
            self._drive(sample).statistics = sample
        return samples

    def problems(self) -> list[str]:
        """Why topics have no samples; nobody and nothing discovered is one problem, not three."""
        found = [self.stream.diagnosis(), self.states.diagnosis(), self.statistics.diagnosis()]
        if not self.node.participant_count():
            return [found[0]] if found[0] else []
        return [problem for problem in found if problem]
