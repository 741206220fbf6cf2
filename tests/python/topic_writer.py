"""A writer of one DDS topic, as a drive has them."""

import threading

from cyclonedds.core import Qos
from cyclonedds.pub import DataWriter
from cyclonedds.topic import Topic
from sextant_py import dds, telemetry_types


class Writer:
    """Writes one topic over and over until it is closed."""

    def __init__(self, domain: int, topic: str, kind: type, qos: Qos, **values: object) -> None:
        self._node = dds.Node(domain)
        self._writer = DataWriter(self._node.participant, Topic(self._node.participant, topic, kind), qos)
        self._kind, self._values = kind, values
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run)

    def __enter__(self) -> "Writer":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stop.set()
        self._thread.join()

    def _run(self) -> None:
        sequence = 0
        while not self._stop.wait(0.005):
            sequence += 1
            self._writer.write(telemetry_types.sample(self._kind, **{**self._values, "sequence": sequence}))
