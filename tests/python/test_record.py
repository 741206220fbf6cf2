"""Recordings of the telemetry, and the comparison of commanded and delivered torque made of them."""

import csv
import json
import os
import re
import subprocess
import sys
import threading
import time
from pathlib import Path

import h5py
import numpy as np
import pytest
from cyclonedds.pub import DataWriter
from cyclonedds.topic import Topic
from sextant_py import dds, demo_report, record, telemetry_types
from sextant_py.errors import UserError

COUNT = 400
SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"


def publish(domain: int, go: threading.Event, done: threading.Event) -> None:
    """Once asked, COUNT samples of drive 1, one a millisecond, with samples of drive 2 in between."""
    kind = telemetry_types.struct("DriveTelemetry")
    node = dds.Node(domain)
    writer = DataWriter(node.participant, Topic(node.participant, dds.TELEMETRY, kind), dds.streaming_qos(1))
    sample = telemetry_types.sample
    while not go.is_set():
        writer.write(sample(kind, drive_id=2))
        time.sleep(0.01)
    state = telemetry_types.DriveStateKind.TORQUE
    for index in range(COUNT):
        values = {"sequence": index, "t_ns": index * 1_000_000, "torque_mean_nm": index / 8, "state": state}
        writer.write(sample(kind, drive_id=1, **values))
        time.sleep(0.001)
    done.wait(120)


@pytest.mark.parametrize("suffix", [".h5", ".csv"])
def test_every_sample_of_one_drive_is_recorded(tmp_path: Path, domain: int, suffix: str) -> None:
    path = tmp_path / f"recording{suffix}"
    go, done = threading.Event(), threading.Event()
    thread = threading.Thread(target=publish, args=(domain, go, done))
    thread.start()
    try:
        with record.Recorder(path, domain, drive_id=1) as recorder:
            end_s = time.monotonic() + 120
            while recorder.count < COUNT and time.monotonic() < end_s:
                recorder.poll()
                if recorder.telemetry.stream.samples:
                    go.set()
                time.sleep(0.01)
            assert recorder.count == COUNT
            assert recorder.lost() == 0
    finally:
        go.set()
        done.set()
        thread.join()
    if suffix == ".h5":
        with h5py.File(path) as file:
            assert set(file) == set(dds.contract_fields("DriveTelemetry"))
            assert file["t_ns"].dtype == np.int64
            assert file["torque_mean_nm"].attrs["unit"] == "N·m"
            assert np.array_equal(file["torque_mean_nm"], np.arange(COUNT) / 8)
            assert np.all(file["state"][()] == telemetry_types.DriveStateKind.TORQUE.value)
    else:
        with path.open() as file:
            rows = list(csv.DictReader(file))
        assert [float(row["torque_mean_nm"]) for row in rows] == [index / 8 for index in range(COUNT)]
        assert tuple(rows[0]) == dds.contract_fields("DriveTelemetry")


FILL_A_DISK = """
import resource, sys
from pathlib import Path
from types import SimpleNamespace
from sextant_py import record
from sextant_py.errors import run

class Samples:
    def __init__(self, *_): self.drives, self.next = {}, 0
    def poll(self):
        self.next += 1000
        class Sample(SimpleNamespace):
            __annotations__ = {"drive_id": int, "t_ns": int, "torque_mean_nm": float}
        return [Sample(drive_id=1, t_ns=k, torque_mean_nm=k / 8) for k in range(self.next - 1000, self.next)]

def fill(arguments):
    record.Telemetry = Samples
    resource.setrlimit(resource.RLIMIT_FSIZE, (int(arguments[1]), resource.RLIM_INFINITY))
    with record.Recorder(Path(arguments[0])) as recorder:
        for _ in range(1000):
            recorder.poll()

run("record", fill)
"""


@pytest.mark.parametrize("suffix", [".h5", ".csv"])
@pytest.mark.parametrize("room", [100, 1_000_000])
def test_a_full_disk_ends_a_recording_with_a_sentence_and_keeps_what_is_there(
    tmp_path: Path, suffix: str, room: int
) -> None:
    path = tmp_path / f"recording{suffix}"
    command = [sys.executable, "-c", FILL_A_DISK, str(path), str(room)]
    environment = {**os.environ, "PYTHONPATH": str(SCRIPTS)}
    ended = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=300)
    assert ended.returncode == 1, ended.stderr
    assert ended.stderr.startswith(f"record: the recording {path} cannot be written: File too large")
    assert ended.stderr.count("\n") == 1
    kept = re.search(r"first (\d+) samples are kept", ended.stderr)
    if kept is None:
        assert room == 100
        return
    if suffix == ".h5":
        with h5py.File(path) as file:
            times = file["t_ns"][()]
    else:
        with path.open() as file:
            times = np.array([int(row["t_ns"]) for row in csv.DictReader(file)])
    assert np.array_equal(times, np.arange(int(kept[1])))


def write_run(folder: Path) -> tuple[Path, Path]:
    """A step from 0 to 20 N·m received at 1.000 s, delivered after 3 ms with 0.5 N·m too little and 4 N·m of ripple."""
    t_ns = np.arange(0, 3_000_000_000, 1_000_000)
    requested = np.where(t_ns >= 1_000_000_000, 20.0, 0.0)
    mean = np.where(t_ns >= 1_003_000_000, 19.5, 0.0)
    signals = dict.fromkeys(dds.contract_fields("DriveTelemetry"), np.zeros(len(t_ns)))
    signals |= {
        "t_ns": t_ns,
        "torque_requested_nm": requested,
        "torque_reference_nm": requested,
        "torque_mean_nm": mean,
        "torque_min_nm": mean - 2,
        "torque_max_nm": mean + 2,
        "flux_mean_wb": np.full(len(t_ns), 1.1),
        "power_w": np.where(t_ns < 2_000_000_000, 1000.0, -500.0),
        "command_received_ns": np.where(t_ns >= 1_000_000_000, 1_000_000_000, 0),
    }
    with h5py.File(folder / "recording.h5", "w") as file:
        for name, values in signals.items():
            file[name] = values
    sent = [{"t_ns": t, "torque_nm": 20.0 if t >= 10**9 else 0.0, "enable": True} for t in range(0, 3 * 10**9, 10**7)]
    log = {"period_ms": 10.0, "missed_periods": 0, "commands": sent}
    (folder / "commands.json").write_text(json.dumps(log))
    return folder / "commands.json", folder / "recording.h5"


def test_report_of_a_known_run(tmp_path: Path) -> None:
    commands, recording = write_run(tmp_path)
    statistics = {"periods_missed": 4, "periods": 120000, "overruns": 2}
    table = dict(
        demo_report.rows(demo_report.load_commands(commands), demo_report.load_recording(recording), statistics)
    )
    assert table["response time"] == "3.0 ms from reception to 95 % of a step of +20 N·m"
    assert table["torque ripple within 1 ms"] == "4.00 N·m median, 4.00 N·m largest"
    assert table["torque commanded"] == "+0.0 … +20.0 N·m"
    assert table["torque delivered (1 ms mean)"] == "+0.0 … +19.5 N·m"
    assert table["missed control periods"] == "4 of 120000, 2 late wake-ups"
    assert table["stator flux"].startswith("1.1000 Wb mean")
    assert table["energy at the DC link"] == "2.00 kJ taken, 0.50 kJ returned"
    # 1988 of 2991 samples are 0.5 N·m low, three are 20 N·m low
    assert table["tracking error"].startswith("-0.352 N·m mean, ")


def test_report_without_enable_is_refused(tmp_path: Path) -> None:
    commands, recording = write_run(tmp_path)
    log = json.loads(commands.read_text())
    log["commands"] = [{**command, "enable": False} for command in log["commands"]]
    commands.write_text(json.dumps(log))
    with pytest.raises(UserError, match="no command was sent with enable"):
        demo_report.rows(demo_report.load_commands(commands), demo_report.load_recording(recording), None)
