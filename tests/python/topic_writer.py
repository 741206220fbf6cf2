"""A writer of one DDS topic, as a drive has them."""

from background import Background
from cyclonedds.core import Qos
from cyclonedds.pub import DataWriter
from cyclonedds.topic import Topic
from sextant_py import dds, telemetry_types


class Writer(Background):
    """Writes one topic over and over until it is closed."""

    def __init__(self, domain: int, topic: str, kind: type, qos: Qos, **values: object) -> None:
        self._node = dds.Node(domain)
        self._writer = DataWriter(self._node.participant, Topic(self._node.participant, topic, kind), qos)
        self._kind, self._values = kind, values
        super().__init__()

    def _run(self) -> None:
        sequence = 0
        while not self._stop.wait(0.005):
            sequence += 1
            self._writer.write(telemetry_types.sample(self._kind, **{**self._values, "sequence": sequence}))
