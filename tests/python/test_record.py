"""Recordings of the telemetry, and the comparison of commanded and delivered torque made of them."""

import json
import os
import re
import signal
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
from made_recording import reread, whole
from sextant_py import dds, demo_report, record, telemetry_types
from sextant_py.errors import UserError
from sextant_py.recording import formats, topics
from sextant_py.recording.live import LiveDrive
from sextant_py.recording.model import MAIN
from sextant_py.telemetry_contract import signals
from topic_writer import Writer

FILLED = (".h5", ".csv", ".mcap", ".mf4")
COUNT = 400
BATCHES, PERIODS = 30, 40
SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"


def writer_of(node: dds.Node, topic: str) -> tuple[DataWriter, type]:
    kind = telemetry_types.struct(topic.partition("/")[2])
    latched = topic in (dds.STATE, dds.STATISTICS)
    quality = dds.latched_qos() if latched else dds.streaming_qos(1)
    return DataWriter(node.participant, Topic(node.participant, topic, kind), quality), kind


def batch(kind: type, number: int) -> object:
    """A batch of drive 1: torque and switching state count the periods, of which the fifth batch lacks two."""
    first = number * PERIODS
    offsets = [25_000 * index for index in range(PERIODS) if number != 5 or index not in (7, 8)]
    members = {signal.name: signal for signal in signals("DriveWaveform")}
    values = {name: [0] * len(offsets) for name, member in members.items() if member.type.startswith("sequence")}
    values["offset_ns"] = offsets
    values["torque_nm"] = [(first + offset // 25_000) / 8 for offset in offsets]
    values["switch_state"] = [(first + offset // 25_000) % 64 for offset in offsets]
    times = {"t_ns": first * 25_000, "period_ns": 25_000, "sequence": number, "dropped": 2 if number >= 5 else 0}
    return telemetry_types.sample(kind, drive_id=1, **times, **values)


def publish(domain: int, waveform: bool, done: threading.Event) -> None:
    """Once there are readers: COUNT samples of drive 1, those of drive 2 in between, and all batches but the tenth."""
    node = dds.Node(domain)
    writer, kind = writer_of(node, dds.TELEMETRY)
    batches, batch_kind = writer_of(node, topics.TOPICS[topics.WAVEFORM])
    states, state_kind = writer_of(node, dds.STATE)
    sample = telemetry_types.sample
    state = telemetry_types.DriveStateKind.TORQUE
    states.write(sample(state_kind, drive_id=1, sequence=3, t_ns=5, state=state, reason="as requested, “µ”"))
    awaited = (writer, states, batches) if waveform else (writer, states)
    while not done.is_set() and not all(one.get_matched_subscriptions() for one in awaited):
        time.sleep(0.01)
    for index in range(COUNT):
        values = {"sequence": index, "t_ns": index * 1_000_000, "torque_mean_nm": index / 8, "state": state}
        writer.write(sample(kind, drive_id=2, sequence=7 * index))
        writer.write(sample(kind, drive_id=1, **values))
        if index < BATCHES and index != 10:
            batches.write(batch(batch_kind, index))
        time.sleep(0.001)
    done.wait(120)


def record_all(path: Path, domain: int, waveform: bool) -> record.Recorder:
    """The recorder, after it has taken everything that publish() sends."""
    done = threading.Event()
    thread = threading.Thread(target=publish, args=(domain, waveform, done))
    thread.start()
    try:
        with record.Recorder(path, LiveDrive(domain, 1, waveform, None), {"program": "test"}) as recorder:
            end_s = time.monotonic() + 120
            while recorder.count < COUNT and time.monotonic() < end_s:
                recorder.poll()
                time.sleep(0.01)
            assert recorder.count == COUNT
        recorder.convert(lambda share: None)
        return recorder
    finally:
        done.set()
        thread.join()


@pytest.mark.parametrize("suffix", formats.SUFFIXES)
def test_every_sample_of_one_drive_is_recorded(tmp_path: Path, domain: int, suffix: str) -> None:
    path = tmp_path / f"recording{suffix}"
    recorder = record_all(path, domain, waveform=False)
    assert recorder.losses.sentence(MAIN) == "0 lost on the way"
    beside = {".json", ".sha256"} if suffix == ".csv" else {".json"}
    assert {found.suffix for found in tmp_path.glob("*")} <= {suffix} | beside, "nothing is left beside the recording"
    found = reread(path)
    rows = whole(found, MAIN)
    assert set(rows.dtype.names) == set(dds.contract_fields("DriveTelemetry"))
    units = {column.name: column.unit for column in found.groups[MAIN].columns}
    assert units == {signal.name: signal.unit for signal in signals("DriveTelemetry")}
    assert rows["t_ns"].dtype == np.int64
    assert np.array_equal(rows["torque_mean_nm"], np.arange(COUNT) / 8)
    assert np.all(rows["state"] == telemetry_types.DriveStateKind.TORQUE.value)
    assert whole(found, "drive_state")["reason"].tolist() == ["as requested, “µ”".encode()]
    assert found.metadata["losses"][MAIN]["rows"] == COUNT
    wall_ns = found.metadata["begin_ns"] + found.metadata["wall_minus_monotonic_begin_ns"]
    assert abs(time.time_ns() - wall_ns) < 300e9


def test_every_control_period_is_recorded_and_what_is_missing_is_counted(tmp_path: Path, domain: int) -> None:
    recorder = record_all(tmp_path / "recording.mcap", domain, waveform=True)
    rows = whole(reread(tmp_path / "recording.mcap"), topics.WAVEFORM)
    number = rows["t_ns"] // 25_000
    gone = {10 * PERIODS + index for index in range(PERIODS)} | {5 * PERIODS + 7, 5 * PERIODS + 8}
    assert number.tolist() == [index for index in range(BATCHES * PERIODS) if index not in gone]
    assert np.array_equal(rows["torque_nm"], (number / 8).astype(np.float32))
    assert np.array_equal(rows["switch_state"], number % 64)
    assert np.array_equal(rows["sequence"], number // PERIODS)
    losses = recorder.losses.of[topics.WAVEFORM]
    assert (losses.lost, losses.dropped, losses.periods_missing, losses.restarts) == (1, 2, len(gone), 0)
    assert reread(tmp_path / "recording.mcap").metadata["losses"][topics.WAVEFORM] == losses.described()
    assert recorder.losses.sentence(topics.WAVEFORM) == (
        "1 batches lost on the way, 2 control periods dropped within the drive, 42 control periods without a row"
    )


FILL_A_DISK = """
import resource, sys
from pathlib import Path
import numpy as np
from sextant_py import record
from sextant_py.errors import run
from sextant_py.recording import formats
from sextant_py.recording.model import MAIN
from sextant_py.recording.topics import group_of

class Rows:
    drive_id, next = 1, 0
    def poll(self):
        group = group_of(MAIN)
        block = np.zeros(1000, group.dtype)
        block["t_ns"] = block["sequence"] = np.arange(self.next, self.next + 1000)
        self.next += 1000
        return [(group, block)]
    def gaps(self):
        return []
    def close(self):
        pass

def fill(arguments):
    resource.setrlimit(resource.RLIMIT_FSIZE, (int(arguments[1]), resource.RLIM_INFINITY))
    with record.Recorder(Path(arguments[0]), Rows(), {"program": "record"}) as recorder:
        for _ in range(3000):
            recorder.poll()

run("record", fill)
"""


@pytest.mark.parametrize(
    ("suffix", "room"),
    [*((suffix, 3_000_000) for suffix in (".h5", ".csv", ".mcap", ".mf4")), (".h5", 100), (".mcap", 100)],
)
def test_a_full_disk_ends_a_recording_with_a_sentence_and_keeps_what_is_there(
    tmp_path: Path, suffix: str, room: int
) -> None:
    path = tmp_path / f"recording{suffix}"
    command = [sys.executable, "-c", FILL_A_DISK, str(path), str(room)]
    environment = {**os.environ, "PYTHONPATH": str(SCRIPTS), "PYTHONDONTWRITEBYTECODE": "1"}
    ended = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=300)
    assert ended.returncode == 1, ended.stderr
    assert ended.stderr.startswith(f"record: the recording {path} cannot be written: File too large")
    assert ended.stderr.count("\n") == 1
    kept = re.search(r"first (\d+) samples are kept", ended.stderr)
    if kept is None:
        assert room == 100
        return
    in_part = suffix in formats.AT_THE_END
    assert in_part == (f" in {path}.part.mcap." in ended.stderr)
    times = whole(reread(path.with_name(f"{path.name}.part.mcap") if in_part else path), MAIN)["t_ns"]
    assert len(times) > 3000
    assert np.array_equal(times, np.arange(int(kept[1])))


def test_a_killed_recorder_leaves_a_readable_file(tmp_path: Path) -> None:
    for suffix in (".h5", ".csv", ".mcap"):
        path = tmp_path / f"recording{suffix}"
        script = FILL_A_DISK.replace("recorder.poll()", "recorder.poll(); import time; time.sleep(0.002)")
        environment = {**os.environ, "PYTHONPATH": str(SCRIPTS), "PYTHONDONTWRITEBYTECODE": "1"}
        command = [sys.executable, "-c", script, str(path), str(10**12)]
        process = subprocess.Popen(command, env=environment)
        end_s = time.monotonic() + 120
        while time.monotonic() < end_s and not (path.exists() and path.stat().st_size > 5_000_000):
            time.sleep(0.01)
        process.kill()
        process.wait()
        times = whole(reread(path), MAIN)["t_ns"]
        assert len(times) > 3000
        assert np.array_equal(times, np.arange(len(times)))
        cut = reread(path).cut
        assert f"; rows that are left: {len(times)} of telemetry" in cut
        if suffix != ".mcap":
            # The end may have come in the middle of a line.
            torn = f"{path} is truncated: rows that are lost: the one of its last line"
            assert cut.startswith((f"{path} was not closed, so what came last may be missing", torn))


def test_an_mcap_that_ends_between_two_records_lacks_its_end(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    with record.Recorder(path, Made(), {"program": "record"}) as recorder:
        recorder.poll()
        recorder._sink.flush()
        size = path.stat().st_size
    assert reread(path).cut is None
    with path.open("r+b") as file:
        file.truncate(size)
    assert reread(path).cut == f"{path} is truncated: it lacks its end; rows that are left: 3 of telemetry"


class Made:
    """Three rows."""

    drive_id = 1

    def poll(self) -> list:
        group = topics.group_of(MAIN)
        return [(group, np.zeros(3, group.dtype))]

    def gaps(self) -> list:
        return []

    def close(self) -> None:
        pass


def test_a_recording_that_an_earlier_run_kept_is_not_replaced(tmp_path: Path, domain: int) -> None:
    kept = tmp_path / "run.mf4.part.mcap"
    kept.write_bytes(b"kept")
    with pytest.raises(UserError, match=r"run\.mf4\.part\.mcap is there, of an earlier run; convert it"):
        record.main([str(tmp_path / "run.mf4"), "--duration", "0.2", "--domain", str(domain)])
    assert kept.read_bytes() == b"kept"


@pytest.mark.parametrize("words", [["--domain", "{domain}"], ["--domain", "{domain}", "--waveform"]])
def test_silence_is_explained(tmp_path: Path, domain: int, words: list[str]) -> None:
    words = [word.format(domain=domain) for word in words]
    with pytest.raises(UserError, match=f"no other DDS participant was discovered .domain {domain}, "):
        record.main([str(tmp_path / "run.mcap"), "--duration", "0.2", *words])
    assert not (tmp_path / "run.mcap").exists()


def test_silence_is_explained_while_it_lasts(
    tmp_path: Path, domain: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    explained = record.reason

    def explain_and_end(recorder: record.Recorder) -> str:
        os.kill(os.getpid(), signal.SIGTERM)
        return explained(recorder)

    monkeypatch.setattr(record, "PATIENCE_S", 0.1)
    monkeypatch.setattr(record, "reason", explain_and_end)
    with pytest.raises(UserError):
        record.main([str(tmp_path / "run.mcap"), "--duration", "600", "--domain", str(domain)])
    said = capsys.readouterr().err
    assert said.startswith("record: no sample for 0.1 s: no other DDS participant was discovered")
    assert said.count("\n") == 1


def test_an_id_that_no_drive_has_is_told_those_that_there_are(tmp_path: Path, domain: int) -> None:
    kind = telemetry_types.struct("DriveTelemetry")
    with Writer(domain, dds.TELEMETRY, kind, dds.streaming_qos(1), drive_id=1):
        live, end_s = LiveDrive(domain, 9, False, None), time.monotonic() + 60
        while not live._received and time.monotonic() < end_s:
            assert live.poll() == []
            time.sleep(0.01)
        assert live.problems() == [f"no sample of drive 9 arrived in domain {domain}; drives there: 1."]


@pytest.mark.parametrize("seconds", ["0", "-1", "nan", "soon"])
def test_a_duration_that_is_none_is_refused(tmp_path: Path, seconds: str, capsys: pytest.CaptureFixture) -> None:
    with pytest.raises(SystemExit):
        record.main([str(tmp_path / "run.h5"), "--duration", seconds])
    assert f'--duration: expected a time above 0 s, got "{seconds}"' in capsys.readouterr().err


@pytest.mark.parametrize("number", [-1, 231])
def test_a_domain_that_dds_does_not_have_is_refused(tmp_path: Path, number: int) -> None:
    with pytest.raises(UserError, match=f"--domain {number} is not a DDS domain .0 to 230."):
        record.main([str(tmp_path / "run.h5"), "--domain", str(number)])


def test_a_suffix_that_no_format_has_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"a recording ends in \.h5, \.csv, .* and \"\.txt\" is none of them"):
        record.main([str(tmp_path / "run.txt")])


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
    assert not any("ripple" in name for name in table), "telemetry knows the sampling instants only"
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
