"""The examples of docs/examples that are programs of their own."""

import os
import subprocess
import sys
import threading

from cyclonedds.pub import DataWriter
from cyclonedds.topic import Topic
from sextant_py import dds, telemetry_types
from sextant_py.paths import ROOT

EXAMPLE = ROOT / "docs" / "examples" / "watch_telemetry.py"


def test_the_reader_of_telemetry_needs_nothing_but_cyclonedds(domain: int) -> None:
    kind = telemetry_types.struct("DriveTelemetry")
    node = dds.Node(domain)
    writer = DataWriter(node.participant, Topic(node.participant, dds.TELEMETRY, kind), dds.streaming_qos(1))
    sample = telemetry_types.sample(kind, drive_id=1, t_ns=1_500_000_000, torque_mean_nm=14.5, speed_rad_s=-30.0)
    done = threading.Event()

    def publish() -> None:
        while not done.wait(0.05):
            writer.write(sample)

    thread = threading.Thread(target=publish)
    thread.start()
    # The domain of a test is its own; the example has the drive's default.
    program = EXAMPLE.read_text(encoding="utf-8").replace("DomainParticipant(0)", f"DomainParticipant({domain})")
    environment = {"CYCLONEDDS_URI": os.environ["CYCLONEDDS_URI"], "PATH": os.environ["PATH"]}
    command = [sys.executable, "-c", program]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment) as reader:
        watchdog = threading.Timer(120, reader.kill)
        watchdog.start()
        try:
            assert reader.stdout.readline() == "1.500 s  +14.50 N·m  -30.0 rad/s\n"
        finally:
            watchdog.cancel()
            reader.kill()
            done.set()
            thread.join()
