"""A recording that is played back and recorded again is the same."""

import threading
import time
from pathlib import Path

import can
import numpy as np
import pytest
from made_recording import assert_same_values, made, reread, whole, write
from sextant_py import bus as can_bus
from sextant_py import playback, record, telemetry_types
from sextant_py.contract import Contract
from sextant_py.errors import UserError
from sextant_py.recording import topics
from sextant_py.recording.can_frames import CAN, CanReader, frame_of
from sextant_py.recording.copying import copy
from sextant_py.recording.live import LiveDrive
from sextant_py.recording.losses import Losses
from sextant_py.recording.model import MAIN
from sextant_py.recording.timeline import begin_ns, items

SEED = 29
PATIENCE_S = 60.0
NAMES = (MAIN, "drive_state", "statistics", topics.WAVEFORM)


def numbered(seed: int):
    """A made recording whose sequence numbers and enumerations are possible ones."""
    source = made(seed, telemetry=400, periods=4000)
    for name in NAMES[:-1]:
        rows = whole(source, name)
        rows["sequence"], rows["drive_id"] = np.arange(len(rows)), 3
        for field in ("state", "wait", "policy", "lockout", "real_time_scheduling", "memory_locked"):
            if field in rows.dtype.names:
                rows[field] %= 2
        source._blocks[name] = rows
    source._blocks["drive_state"] = source._blocks["drive_state"][:1]  # a late reader is told the last one only
    source._blocks["statistics"] = source._blocks["statistics"][:1]
    return source


def play_and_record(words: list[str], domain: int, path: Path, rows: dict[str, int], can: CanReader | None = None):
    """Plays in a thread and records until there are so many rows."""
    failures: list[BaseException] = []

    def play() -> None:
        try:
            playback.main([*words, "--domain", str(domain), "--wait", str(PATIENCE_S)])
        except BaseException as error:
            failures.append(error)

    thread = threading.Thread(target=play)
    with record.Recorder(path, LiveDrive(domain, None, True, can), {}) as recorder:
        thread.start()
        end_s = time.monotonic() + PATIENCE_S
        found: dict[str, int] = {}
        while time.monotonic() < end_s and any(found.get(name, 0) < count for name, count in rows.items()):
            recorder.poll()
            found = {name: losses.rows for name, losses in recorder.losses.of.items()}
            time.sleep(0.005)
        thread.join(PATIENCE_S)
    assert not failures
    return recorder


@pytest.mark.parametrize("suffix", [".mcap", ".h5"])
def test_what_is_played_and_recorded_again_is_the_same(tmp_path: Path, domain: int, suffix: str) -> None:
    source = numbered(SEED)
    write(source, tmp_path / f"run{suffix}")
    rows = {name: source.rows(name) for name in NAMES}
    play_and_record([str(tmp_path / f"run{suffix}")], domain, tmp_path / "again.mcap", rows)
    again = reread(tmp_path / "again.mcap")
    for name in NAMES:
        assert_same_values(whole(again, name), whole(source, name))


def test_frames_are_sent_again_in_their_order_and_time(tmp_path: Path, domain: int, bus_address: str) -> None:
    source = numbered(SEED)
    contract = Contract()
    frames = source._blocks[CAN]
    status = contract.encode("MCU_Motion", {"Speed": 120.5, "FluxMagnitude": 0.9, "Direction": 1}, counter=4)
    frames[7]["id"], frames[7]["data"] = status.arbitration_id, bytes(status.data).hex().encode()
    frames[8]["id"], frames[8]["is_extended"] = 0x1ABCDE0, 1
    frames[9]["length"], frames[9]["data"] = 3, b"01ff7e"
    write(source, tmp_path / "run.mcap")
    begin_s = time.monotonic()
    words = [str(tmp_path / "run.mcap"), "--can", bus_address]
    recorder = play_and_record(words, domain, tmp_path / "again.mcap", {CAN: len(frames)}, CanReader(bus_address, 0))
    again = reread(tmp_path / "again.mcap")
    found = whole(again, CAN)
    for name in set(found.dtype.names) - {"t_ns"}:
        assert np.array_equal(found[name], frames[name]), name
    # How late a frame comes depends on the machine, but all of them take their time.
    assert np.all(np.diff(found["t_ns"]) >= 0)
    assert time.monotonic() - begin_s >= (frames["t_ns"][-1] - frames["t_ns"][0]) / 1e9
    assert begin_s * 1e9 <= found["t_ns"][0] <= time.monotonic_ns()
    motion = whole(again, "can/MCU_Motion")
    assert (motion["Speed"][-1], motion["FluxMagnitude"][-1], motion["Counter"][-1]) == (120.5, 0.9, 4)
    units = {column.name: column.unit for column in again.groups["can/MCU_Motion"].columns}
    dbc = {signal.name: signal.unit or "1" for signal in contract.message("MCU_Motion").signals}
    assert units == {"t_ns": "ns", **dbc}
    assert recorder.losses.of[CAN].rows == len(frames)


@pytest.mark.parametrize("first", [0, 5_000])
def test_another_id_another_speed_and_a_second_pass(tmp_path: Path, domain: int, first: int) -> None:
    """In a second pass times and numbers go on, so that nobody takes them for a loss or a restart."""
    source = numbered(SEED)
    source._blocks[MAIN]["sequence"] += first
    write(source, tmp_path / "run.mcap")
    player = playback.Player(reread(tmp_path / "run.mcap"), domain, 9, None)
    seen: list[tuple[int, int, int]] = []

    class Writer:
        def write(self, sample: object) -> None:
            seen.append((sample.drive_id, sample.sequence, sample.t_ns))

    player._writers[MAIN] = Writer()
    begin_s = time.monotonic()
    player.play(1000.0, 0, playback.Progress())
    player.play(1000.0, 1, playback.Progress())
    assert time.monotonic() - begin_s < PATIENCE_S
    assert {drive for drive, _, _ in seen} == {9}
    assert [number for _, number, _ in seen] == list(range(first, first + 800))
    assert np.all(np.diff([t_ns for _, _, t_ns in seen]) > 0)


def test_items_come_in_the_order_of_their_times_and_batches_whole(tmp_path: Path) -> None:
    source = made(SEED, telemetry=3000, periods=9000)
    found = list(items(source, [*NAMES, CAN]))
    assert np.all(np.diff([item.t_ns for item in found]) >= 0)
    batches = [item.rows for item in found if item.group == topics.WAVEFORM]
    assert {len(batch) for batch in batches} == {40}
    assert np.concatenate(batches).tobytes() == whole(source, topics.WAVEFORM).tobytes()
    assert begin_ns(source, [MAIN, CAN]) == 5_000_000_000


def test_a_state_that_the_contract_does_not_name_is_refused() -> None:
    row = np.zeros(1, topics.group_of(MAIN).dtype)[0]
    row["state"] = 255
    with pytest.raises(UserError, match="the recording has state 255, which DriveStateKind of the telemetry contract"):
        topics.sample_of(MAIN, row, telemetry_types.struct("DriveTelemetry"))


def test_a_frame_survives_as_it_is() -> None:
    source = made(SEED)
    for row in whole(source, CAN)[:20]:
        frame = frame_of(row)
        assert (frame.arbitration_id, bytes(frame.data).hex().encode()) == (row["id"], row["data"])


@pytest.mark.parametrize(
    ("words", "objection"),
    [
        (["none.mcap"], "none.mcap does not exist"),
        (["run.mcap", "--speed", "0"], "--speed must be a number above 0"),
        (["run.mcap", "--can", "socketcan"], '"socketcan" is not the address of a CAN bus'),
        (
            ["telemetry.mcap", "--can", "udp_multicast:239.74.163.2"],
            "holds no CAN frames; scripts/record --can records",
        ),
        (["can.mcap"], "can.mcap holds no telemetry; it has can"),
        (["run.mcap", "--wait", "nan"], "--wait must be a number from 0"),
        (["run.mcap", "--domain", "231"], "--domain 231 is not a DDS domain"),
        (["cut.mcap"], "cut.mcap is truncated: .*; rows that are left: none; nothing can be played"),
        (["empty.csv"], "empty.csv has no rows of telemetry; nothing can be played"),
    ],
)
def test_bad_input_gets_a_sentence(tmp_path: Path, words: list[str], objection: str) -> None:
    source = made(SEED)
    write(source, tmp_path / "run.mcap")
    (tmp_path / "cut.mcap").write_bytes((tmp_path / "run.mcap").read_bytes()[:30_000])
    (tmp_path / "empty.csv").write_text("t_ns,sequence\n", encoding="utf-8")
    for name in (MAIN, CAN):
        copy(source, tmp_path / f"{name}.mcap", [name], lambda share: None)
    with pytest.raises(UserError, match=objection):
        playback.main([str(tmp_path / words[0]), *words[1:]])


def test_a_bus_that_dies_is_opened_again_and_the_gap_is_kept(tmp_path: Path, bus_address: str, domain: int) -> None:
    reader = CanReader(bus_address, 0)
    sender = can_bus.open_bus(can_bus.parse(bus_address))
    path = tmp_path / "run.mcap"
    with record.Recorder(path, LiveDrive(domain, None, False, reader), {"program": "record"}) as recorder:
        for identifier in (0x321, 0x322):
            before, end_s = recorder.losses.of.get(CAN, Losses()).rows, time.monotonic() + PATIENCE_S
            while recorder.losses.of.get(CAN, Losses()).rows == before and time.monotonic() < end_s:
                sender.send(can.Message(arbitration_id=identifier, data=b"\x01", is_extended_id=False))
                time.sleep(0.01)
                recorder.poll()
            if identifier == 0x321:
                reader._bus.shutdown()
                while not reader.gaps and time.monotonic() < end_s:
                    time.sleep(0.01)
                recorder.poll()
    sender.shutdown()
    found = reread(path)
    assert set(whole(found, CAN)["id"].tolist()) == {0x321, 0x322}
    (gap,) = found.metadata["can_gaps"]
    assert found.metadata["begin_ns"] < gap["begin_ns"] < gap["end_ns"] < found.metadata["end_ns"]
    assert gap["reason"]
