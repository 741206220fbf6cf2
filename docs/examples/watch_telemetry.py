"""Reads the telemetry of a drive with nothing but the package cyclonedds; docs/telemetry.md goes through it."""

import time

from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsPublication
from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.dynamic import get_types_for_typeid
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

TOPIC = "sextant/DriveTelemetry"
node = DomainParticipant(0)
publications = BuiltinDataReader(node, BuiltinTopicDcpsPublication)
writers = []
while not writers:  # until a drive publishes
    time.sleep(0.1)
    writers = [writer for writer in publications.take(N=100) if writer.topic_name == TOPIC]
kind, _ = get_types_for_typeid(node, writers[0].type_id, duration(seconds=10))
reader = DataReader(node, Topic(node, TOPIC, kind), Qos(Policy.Reliability.BestEffort, Policy.History.KeepLast(1)))
while True:
    for sample in reader.take(N=100):
        print(
            f"{sample.t_ns / 1e9:.3f} s  {sample.torque_mean_nm:+.2f} N·m  {sample.speed_rad_s:+.1f} rad/s", flush=True
        )
    time.sleep(0.1)
