"""wrong_readers.py DOMAIN FIRST STEP HOLD_S: readers that declare topics wrongly, in a process of their own.

Takes each STEP-th of wrong_declarations from FIRST on, keeps the readers for HOLD_S, and prints how many there were.
The library of Python loops without end and takes all memory where a process has more than 32 types of one name.
"""

import resource
import sys
import time

from cyclonedds.core import DDSException
from cyclonedds.domain import DomainParticipant
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from sextant_py import dds
from wrong_declarations import every

MODULES = ("sextant", "reader", "monitor")
MEMORY_BYTES = 4 << 30


def main() -> None:
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY_BYTES, MEMORY_BYTES))
    domain, first, step = (int(word) for word in sys.argv[1:4])
    participant = DomainParticipant(domain)
    readers = []
    for index, declaration in enumerate(every()[first::step]):
        qos = dds.streaming_qos(1) if declaration.topic == dds.TELEMETRY else dds.latched_qos()
        try:
            topic = Topic(participant, declaration.topic, declaration.kind(MODULES[index % len(MODULES)]))
            readers.append(DataReader(participant, topic, qos))
        except (DDSException, TypeError) as error:
            print(f"not declared: {declaration.topic} {declaration.what}: {error}", file=sys.stderr)
    print(len(readers), flush=True)
    time.sleep(float(sys.argv[4]))


if __name__ == "__main__":
    main()
