"""A drive's waveform of which the instants are known."""

import time

import numpy as np
from background import Background
from cyclonedds.pub import DataWriter
from cyclonedds.topic import Topic
from sextant_py import dds, telemetry_types
from sextant_py.recording import topics

PERIOD_NS = 25_000
BATCH = 400
STEP_PERIODS = 4000  # the torque reference steps by STEP_NM each so many periods
STEP_NM = 8.0


class WaveformWriter(Background):
    """Writes batches of a drive with the id 7 in real time; `batches` are the numbers of those to leave out."""

    def __init__(self, domain: int, without: range = range(0)) -> None:
        self._node = dds.Node(domain)
        self._kind = telemetry_types.struct("DriveWaveform")
        topic = Topic(self._node.participant, topics.TOPICS[topics.WAVEFORM], self._kind)
        self._writer = DataWriter(self._node.participant, topic, dds.streaming_qos(1))
        self._without = without
        super().__init__()

    def readers(self) -> int:
        return len(self._writer.get_matched_subscriptions())

    def _batch(self, number: int) -> object:
        period = number * BATCH + np.arange(BATCH)
        torque = STEP_NM * (period // STEP_PERIODS % 2)
        zeros = {name: [0] * BATCH for name in self._kind.__annotations__ if name not in ("drive_id", "sequence")}
        values = {
            **zeros,
            "dropped": 0,
            "t_ns": number * BATCH * PERIOD_NS,
            "period_ns": PERIOD_NS,
            "offset_ns": (PERIOD_NS * np.arange(BATCH)).tolist(),
            "torque_reference_nm": torque.tolist(),
            "flux_alpha_wb": np.cos(1e-3 * period).tolist(),
            "flux_beta_wb": np.sin(1e-3 * period).tolist(),
            "switch_state": [6] * BATCH,
        }
        return telemetry_types.sample(self._kind, drive_id=7, sequence=number, **values)

    def _run(self) -> None:
        begin_s, number = time.monotonic(), 0
        while not self._stop.wait(0.002):
            while number < (time.monotonic() - begin_s) * 1e9 / (BATCH * PERIOD_NS):
                if number not in self._without:
                    self._writer.write(self._batch(number))
                number += 1
