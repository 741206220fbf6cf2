"""Recordings in every format: values, units and texts survive, and readers of other origin find the same."""

import csv
import dataclasses
import itertools
import json
import os
import re
import resource
import subprocess
import sys
from collections.abc import Iterator
from contextlib import suppress
from io import BytesIO
from pathlib import Path

import h5py
import mdfreader
import numpy as np
import pytest
import zstandard
from made_recording import EXTREMES, MadeSource, assert_same, assert_same_values, made, reread, whole, write
from mcap.data_stream import ReadDataStream
from mcap.reader import make_reader
from mcap.records import Chunk
from mcap.writer import CompressionType, IndexType, Writer
from mcap_ros2.decoder import DecoderFactory
from programs import program
from pyarrow import parquet
from sextant_py import convert
from sextant_py.errors import UserError
from sextant_py.paths import ROOT
from sextant_py.recording import formats, topics
from sextant_py.recording.can_frames import CAN
from sextant_py.recording.copying import copy
from sextant_py.recording.mcap_messages import HEADER_BYTES, field_name
from sextant_py.recording.mcap_sink import bytes_of
from sextant_py.recording.model import MAIN, merged
from sextant_py.recording.value_texts import value_texts

SEED = 13


@pytest.mark.parametrize("suffix", formats.SUFFIXES)
def test_every_value_survives(tmp_path: Path, suffix: str) -> None:
    source = made(SEED)
    write(source, tmp_path / f"run{suffix}")
    found = reread(tmp_path / f"run{suffix}")
    assert found.cut is None
    assert_same(found, source)
    kept = {key: found.metadata[key] for key in source.metadata}
    assert kept == source.metadata
    assert found.metadata["rows"] == {name: source.rows(name) for name in source.groups}


def test_a_chain_through_all_formats_changes_nothing(tmp_path: Path) -> None:
    source = made(SEED + 1)
    write(source, tmp_path / "run.mcap")
    chain = ["run.mcap", "run.mf4", "run.csv", "run.parquet", "run.h5", "again.mcap"]
    for before, after in itertools.pairwise(chain):
        assert convert.main([str(tmp_path / before), str(tmp_path / after)]) == 0
    assert_same(reread(tmp_path / "again.mcap"), source)


@pytest.mark.parametrize("suffix", formats.SUFFIXES)
def test_a_trace_of_mil_survives(tmp_path: Path, suffix: str) -> None:
    """With plant and control, which share the time axis of the record."""
    scenario = ROOT / "configs" / "scenarios" / "constant_torque.toml"
    settings = ["--set", 'trace.signals=["all"]', "--out", str(tmp_path / "out")]
    ran = subprocess.run([program("sextant-mil"), scenario, *settings], capture_output=True, text=True, timeout=240)
    trace = tmp_path / "out" / "trace.h5"
    assert trace.exists(), ran.stderr
    assert convert.main([str(trace), str(tmp_path / f"trace{suffix}")]) == 0
    assert_same(reread(tmp_path / f"trace{suffix}"), reread(trace))
    if suffix == ".h5":
        return
    assert convert.main([str(tmp_path / f"trace{suffix}"), str(tmp_path / "again.h5")]) == 0
    with h5py.File(trace) as before, h5py.File(tmp_path / "again.h5") as after:
        names: list[str] = []
        before.visit(names.append)
        found: list[str] = []
        after.visit(found.append)
        assert sorted(found) == sorted(names)
        for name in names:
            if isinstance(before[name], h5py.Dataset):
                assert before[name].dtype == after[name].dtype
                assert np.array_equal(before[name], after[name], equal_nan=True)
        assert after.attrs["control_period_ns"] == before.attrs["control_period_ns"]


def test_h5py_finds_the_layout_of_a_trace(tmp_path: Path) -> None:
    source = made(SEED)
    write(source, tmp_path / "run.h5")
    with h5py.File(tmp_path / "run.h5") as file:
        for name, group in source.groups.items():
            place = file if name == MAIN else file[name]
            for column in group.columns:
                data = place[column.name]
                assert np.array_equal(data[()], whole(source, name)[column.name])
                assert (data.attrs["unit"], data.attrs["description"]) == (column.unit, column.text)
        assert json.loads(file.attrs["recording"])["drive_id"] == 3


def test_a_ros_2_decoder_reads_the_messages(tmp_path: Path) -> None:
    source = made(SEED)
    write(source, tmp_path / "run.mcap")
    rows: dict[str, list] = {name: [] for name in source.groups}
    with (tmp_path / "run.mcap").open("rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        counts = reader.get_summary().statistics.channel_message_counts
        assert sum(counts.values()) == sum(source.rows(name) for name in source.groups)
        for schema, channel, message, decoded in reader.iter_decoded_messages():
            name = channel.topic.removeprefix("/")
            assert message.log_time == decoded.t_ns
            rows[name].append(decoded)
            if len(rows[name]) == 1:
                for column in source.groups[name].columns:
                    line = rf"^\S+ {field_name(column.name)}  # \[{re.escape(column.unit)}\] {re.escape(column.text)}$"
                    assert re.search(line, schema.data.decode(), re.MULTILINE), line
    for name, group in source.groups.items():
        expected = whole(source, name)
        for column in group.columns:
            found = [getattr(row, field_name(column.name)) for row in rows[name]]
            if column.is_text:
                assert found == [value.decode() for value in expected[column.name]]
            else:
                assert np.array_equal(np.array(found, column.kind), expected[column.name]), (name, column.name)


def test_messages_lie_in_the_order_of_their_times(tmp_path: Path) -> None:
    """Chunks that overlap by much would make players keep the whole file in memory."""
    source = made(SEED, telemetry=60_000, periods=40_000)
    write(source, tmp_path / "run.mcap")
    with (tmp_path / "run.mcap").open("rb") as file:
        chunks = make_reader(file).get_summary().chunk_indexes
    assert len(chunks) >= 2
    begins = [chunk.message_start_time for chunk in chunks]
    assert begins == sorted(begins)
    assert [int(group.times_ns(block)[0]) for group, block in merged(source)] == sorted(
        int(group.times_ns(block)[0]) for group, block in merged(source)
    )


def test_another_mdf_reader_finds_channels_units_and_masters(tmp_path: Path) -> None:
    source = made(SEED)
    write(source, tmp_path / "run.mf4")
    file = mdfreader.Mdf(str(tmp_path / "run.mf4"))
    masters = dict(file.masterChannelList)
    assert len(masters) == len(source.groups)
    by_count = {len(file.get_channel_data(master)): (master, names) for master, names in masters.items()}
    for name, group in source.groups.items():
        expected = whole(source, name)
        master, names = by_count[len(expected)]
        seconds = (expected["t_ns"] - 5_000_000_000) / 1e9
        assert np.allclose(file.get_channel_data(master), seconds, rtol=0, atol=1e-9)
        for column in group.columns:
            channel = next(one for one in names if re.fullmatch(rf"{column.name}(_\d+)*", one))
            values = file.get_channel_data(channel)
            if column.is_text:
                assert [str(value) for value in values] == [value.decode() for value in expected[column.name]]
            elif texts := value_texts(name, column.name):
                assert [str(value) for value in values] == [
                    texts.get(v, str(v)) for v in expected[column.name].tolist()
                ]
            else:
                assert np.array_equal(values, expected[column.name]), (name, column.name)
            assert file.get_channel_unit(channel) == column.unit


def test_csv_and_parquet_are_a_file_a_group(tmp_path: Path) -> None:
    source = made(SEED)
    write(source, tmp_path / "run.csv")
    write(source, tmp_path / "run.parquet")
    assert {path.name for path in tmp_path.glob("run*.csv")} == {
        "run.csv", *(f"run.{name}.csv" for name in source.groups if name != MAIN)
    }  # fmt: skip
    for name, group in source.groups.items():
        expected = whole(source, name)
        middle = "" if name == MAIN else f".{name}"
        with (tmp_path / f"run{middle}.csv").open(encoding="utf-8", newline="") as file:
            lines = list(csv.DictReader(file))
        table = parquet.read_table(tmp_path / f"run{middle}.parquet")
        for column in group.columns:
            field = table.schema.field(column.name)
            assert field.metadata == {b"unit": column.unit.encode(), b"description": column.text.encode()}
            texts, values = [line[column.name] for line in lines], table[column.name].to_pylist()
            if column.is_text:
                assert texts == values == [value.decode() for value in expected[column.name]]
            else:
                # Not in one step: numpy would take a text for a float, which a whole number of 64 bits does not fit in.
                number = float if np.dtype(column.kind).kind == "f" else int
                assert np.array_equal(np.array([number(text) for text in texts], column.kind), expected[column.name])
                assert np.array_equal(np.array(values, column.kind), expected[column.name])


def test_one_group_is_one_file(tmp_path: Path) -> None:
    source = made(SEED)
    write(source, tmp_path / "run.mcap")
    for suffix in (".csv", ".parquet"):
        output = tmp_path / f"periods{suffix}"
        assert convert.main([str(tmp_path / "run.mcap"), str(output), "--group", topics.WAVEFORM]) == 0
        found = reread(output)
        assert set(found.groups) == {topics.WAVEFORM}
        assert whole(found, topics.WAVEFORM).tobytes() == whole(source, topics.WAVEFORM).tobytes()
        assert len(list(tmp_path.glob(f"periods*{suffix}"))) == 1


def test_a_csv_file_of_other_origin_is_read(tmp_path: Path) -> None:
    """An empty column is of numbers that are none."""
    (tmp_path / "other.csv").write_text("t_s,speed_rad_s,count,none\n0,1.5,7,\n0.25,2.5,8,\n", encoding="utf-8")
    assert convert.main([str(tmp_path / "other.csv"), str(tmp_path / "other.mcap")]) == 0
    found = whole(reread(tmp_path / "other.mcap"), MAIN)
    assert found["speed_rad_s"].tolist() == [1.5, 2.5]
    assert found["count"].tolist() == [7, 8]
    assert np.isnan(found["none"]).all()


@pytest.mark.parametrize(
    ("text", "name", "values"),
    [
        ("t_s,a\n0,1\n0.1,2", "a", [1, 2]),
        ("t_s,a\r0,1\r0.1,2\r", "a", [1, 2]),
        ("\ufefft_s,a\r\n0,1\r\n0.1,2\r\n", "a", [1, 2]),
        ('"t_s","a"\n"0","1"\n"0.1","2"\n', "a", [1, 2]),
        (",t_s,a\n0,0,1\n1,0.1,2\n", "index", [0, 1]),
        ("t_s,a\n" + "0,1\n" * 1_200_000 + "1,2.5\n", "a", [*[1] * 1_200_000, 2.5]),
        ("t_s,a\n0,1\n1,\n", "a", [1, np.nan]),
    ],
    ids=["no final newline", "CR", "byte order mark", "quotes", "index of pandas", "late fraction", "empty cell"],
)
def test_every_row_of_a_csv_file_of_other_origin_is_read(
    tmp_path: Path, text: str, name: str, values: list[float]
) -> None:
    (tmp_path / "other.CSV").write_bytes(text.encode())
    source = reread(tmp_path / "other.CSV")
    assert source.cut is None
    assert source.rows(MAIN) == len(values)
    np.testing.assert_array_equal(whole(source, MAIN)[name], values)


@pytest.mark.parametrize("suffix", formats.SUFFIXES)
def test_numbers_of_the_other_byte_order_are_converted(tmp_path: Path, suffix: str) -> None:
    with h5py.File(tmp_path / "big.h5", "w") as file:
        file["t_s"] = np.array([0, 0.1, 0.2], ">f8")
        file["count"] = np.array([1, 2, 70_000], ">i4")
    assert convert.main([str(tmp_path / "big.h5"), str(tmp_path / f"out{suffix}")]) == 0
    found = whole(reread(tmp_path / f"out{suffix}"), MAIN)
    assert found["t_s"].tolist() == [0, 0.1, 0.2]
    assert found["count"].tolist() == [1, 2, 70_000]


def test_a_file_that_this_process_writes_is_not_called_no_hdf5_file(tmp_path: Path) -> None:
    write(made(SEED), tmp_path / "run.h5")
    with h5py.File(tmp_path / "run.h5", "a"), pytest.raises(UserError, match=r"run\.h5 cannot be read: .*open"):
        reread(tmp_path / "run.h5")


@pytest.mark.parametrize("suffix", formats.SUFFIXES)
@pytest.mark.parametrize("share", [0.1, 0.6, 0.9, 0.999])
def test_a_truncated_file_gives_what_is_before_its_cut(tmp_path: Path, suffix: str, share: float) -> None:
    source = made(SEED, periods=20_000)
    path = tmp_path / f"run{suffix}"
    write(source, path)
    size = int(path.stat().st_size * share)
    with path.open("r+b") as file:
        file.truncate(size)
    try:
        found = reread(path)
    except UserError as error:
        assert suffix in (".mf4", ".parquet", ".h5"), error
        assert suffix != ".h5" or share == 0.1
        assert str(error).startswith(f"{path} is ")
        assert "truncated" in str(error)
        return
    assert found.cut is not None
    assert found.cut.startswith(f"{path} is truncated: ")
    kept = {name: found.rows(name) for name in found.groups}
    assert kept[MAIN] < source.rows(MAIN) or kept[topics.WAVEFORM] < source.rows(topics.WAVEFORM) or share >= 0.9
    for name, count in kept.items():
        assert_same_values(whole(found, name), whole(source, name)[:count])
        assert (f" {count} of {name}" in found.cut.partition("left:")[2]) == (count > 0)


def test_a_truncated_recording_is_converted_and_told(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    source = made(SEED)
    path, output = tmp_path / "run.csv", tmp_path / "out.h5"
    write(source, path)
    with path.open("r+b") as file:
        file.truncate(path.stat().st_size // 2)
    with pytest.raises(UserError, match=r"rows that are lost: \d+ of telemetry; .* --truncated makes this a success"):
        convert.main([str(path), str(output)])
    kept = reread(output).rows(MAIN)
    assert 0 < kept < source.rows(MAIN)
    assert convert.main([str(path), str(output), "--truncated"]) == 0
    said = capsys.readouterr()
    assert f"{kept} of {kept} rows of telemetry" in said.out
    assert f"rows that are lost: {source.rows(MAIN) - kept} of telemetry" in said.err


@pytest.mark.parametrize("suffix", formats.SEVERAL)
def test_no_conversion_replaces_a_file_that_it_reads(tmp_path: Path, suffix: str) -> None:
    """One group of the recording to the name of that group's file, and a group's file to the recording's name."""
    source = made(SEED)
    write(source, tmp_path / f"run{suffix}")
    part = tmp_path / f"run.waveform{suffix}"
    with pytest.raises(UserError, match=f"would replace .*run.waveform{suffix}, which is to be read"):
        convert.main([str(tmp_path / f"run{suffix}"), str(part), "--group", topics.WAVEFORM])
    with pytest.raises(UserError):
        convert.main([str(part), str(tmp_path / f"run{suffix}")])
    assert_same(reread(tmp_path / f"run{suffix}"), source)


@pytest.mark.parametrize("suffix", formats.SEVERAL)
@pytest.mark.parametrize("through", ["copy", "sink"])
def test_no_group_of_an_earlier_recording_stays(tmp_path: Path, suffix: str, through: str) -> None:
    source, path = made(SEED), tmp_path / f"run{suffix}"
    write(source, path)
    write(source, tmp_path / f"run.b{suffix}")  # another recording, whose name begins the same
    if through == "copy":
        copy(source, path, [MAIN, CAN], lambda share: None)
    else:
        sink = formats.open_sink(path, {})
        for name in (MAIN, CAN):
            sink.add(source.groups[name])
            sink.append(name, whole(source, name))
        sink.close({})
    assert set(reread(path).groups) == {MAIN, CAN}
    assert not (tmp_path / f"run.waveform{suffix}").exists()
    assert_same(reread(tmp_path / f"run.b{suffix}"), source)


@pytest.mark.parametrize("suffix", [".mcap", ".mf4", ".parquet"])
def test_a_damaged_file_is_refused(tmp_path: Path, suffix: str, capsys: pytest.CaptureFixture) -> None:
    """Its checksums show it, and the output stays as it was."""
    path, output = tmp_path / f"run{suffix}", tmp_path / "out.h5"
    write(made(SEED), path)
    write(made(SEED + 1), output)
    whole_file, before = path.read_bytes(), output.read_bytes()
    for share in (0.1, 0.3, 0.5, 0.7):
        data, place = bytearray(whole_file), int(share * len(whole_file))
        data[place] ^= 0xFF
        path.write_bytes(data)
        with pytest.raises(UserError, match=f"run{suffix} is (truncated or )?damaged") as refusal:
            convert.main([str(path), str(output)])
        assert "\n" not in str(refusal.value)
        assert output.read_bytes() == before


def uncompressed(chunk: Chunk) -> Chunk:
    data = zstandard.ZstdDecompressor().decompress(chunk.data, chunk.uncompressed_size)
    return dataclasses.replace(chunk, compression="", data=data)


def test_a_damaged_chunk_is_named_by_its_place(tmp_path: Path) -> None:
    """One that is not compressed, so that its checksum alone shows it."""
    path = tmp_path / "run.mcap"
    write(made(SEED), path)
    data, place = path.read_bytes(), reread(path)._chunks[0]
    begin, end = place.offset - HEADER_BYTES, place.offset + place.length
    chunk = uncompressed(Chunk.read(ReadDataStream(BytesIO(data[place.offset : end]))))
    path.write_bytes(data[:begin] + bytes_of(chunk) + data[end:])
    assert_same(reread(path), made(SEED))
    record = bytearray(bytes_of(chunk))
    record[-1] ^= 1
    path.write_bytes(data[:begin] + record + data[end:])
    with pytest.raises(UserError, match=f"run.mcap is damaged at byte {begin}: .* does not match its checksum"):
        convert.main([str(path), str(tmp_path / "out.h5")])


def test_an_index_that_points_elsewhere_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    write(made(SEED), path)
    data, source = bytearray(path.read_bytes()), reread(path)
    for name in (MAIN, "drive_state"):
        place, _ = source._chunks[0].indexes[source._codecs[name].channel]
        damaged = bytearray(data)
        damaged[place + 8] ^= 4  # the offset of the first row
        path.write_bytes(damaged)
        with pytest.raises(UserError, match=f"is damaged at byte .*no row of {name} is where the index says"):
            convert.main([str(path), str(tmp_path / "out.h5")])


def rewritten(out: Path, sources: list[Path], **options: object) -> None:
    """The messages of recordings in the order of their times, by the library's own writer; each recording has channels
    of its own."""
    with out.open("wb") as stream:
        writer = Writer(stream, **options)
        writer.start(profile="")
        found = []
        for source in sources:
            channels: dict[int, int] = {}
            with source.open("rb") as file:
                for schema, channel, message in make_reader(file).iter_messages():
                    if channel.id not in channels:
                        number = writer.register_schema(schema.name, schema.encoding, schema.data)
                        channels[channel.id] = writer.register_channel(
                            channel.topic, channel.message_encoding, number, channel.metadata
                        )
                    found.append((message.log_time, channels[channel.id], message))
        for time, channel, message in sorted(found, key=lambda row: row[0]):
            writer.add_message(channel, time, message.data, message.publish_time, message.sequence)
        writer.finish()


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"use_chunking": False},
        {"use_chunking": False, "use_statistics": False},
        {"index_types": IndexType.NONE},
        {"index_types": IndexType.NONE, "compression": CompressionType.NONE, "chunk_size": 1000},
        {"repeat_channels": False, "repeat_schemas": False, "use_summary_offsets": False},
        {"index_types": IndexType.NONE, "repeat_channels": False, "use_statistics": False},
    ],
    ids=lambda options: ", ".join(f"{key} {value}" for key, value in options.items()) or "default",
)
def test_an_mcap_file_of_another_writer_is_read_whole(tmp_path: Path, options: dict) -> None:
    """With and without chunks, indexes, counts and a summary of its channels."""
    source = made(SEED)
    write(source, tmp_path / "run.mcap")
    rewritten(tmp_path / "other.mcap", [tmp_path / "run.mcap"], **options)
    found = reread(tmp_path / "other.mcap")
    assert {name: found.rows(name) for name in source.groups} == {name: source.rows(name) for name in source.groups}
    for name in source.groups:
        assert_same_values(whole(found, name), whole(source, name))


@pytest.mark.parametrize("options", [{}, {"use_chunking": False}, {"index_types": IndexType.NONE}], ids=str)
def test_channels_of_one_topic_are_one_group(tmp_path: Path, options: dict, capsys: pytest.CaptureFixture) -> None:
    """Two recordings in one file have a channel each of every topic: all of their rows, in the order of the file."""
    sources = [made(SEED), made(SEED + 1)]
    for number, source in enumerate(sources):
        write(source, tmp_path / f"run{number}.mcap")
    rewritten(tmp_path / "both.mcap", [tmp_path / "run0.mcap", tmp_path / "run1.mcap"], **options)
    assert convert.main([str(tmp_path / "both.mcap"), str(tmp_path / "both.h5")]) == 0
    count = sum(source.rows(MAIN) for source in sources)
    assert f"{count} of {count} rows of {MAIN}" in capsys.readouterr().out
    for name, group in sources[0].groups.items():
        rows = np.concatenate([whole(source, name) for source in sources])
        wanted = rows[np.argsort(np.maximum(group.times_ns(rows), 0), kind="stable")]
        assert_same_values(whole(reread(tmp_path / "both.h5"), name), wanted)


def test_unlike_groups_of_one_name_are_kept_apart(tmp_path: Path) -> None:
    source = made(SEED)
    write(source, tmp_path / "run.mcap")
    other = made(SEED + 1)
    other.groups[MAIN] = dataclasses.replace(other.groups[MAIN], text="of another version")
    write(other, tmp_path / "other.mcap")
    rewritten(tmp_path / "both.mcap", [tmp_path / "run.mcap", tmp_path / "other.mcap"])
    found = reread(tmp_path / "both.mcap")
    assert_same_values(whole(found, MAIN), whole(source, MAIN))
    assert_same_values(whole(found, f"{MAIN}_2"), whole(other, MAIN))


def test_messages_that_the_file_counts_and_lacks_are_damage(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    write(made(SEED), path)
    data, source = path.read_bytes(), reread(path)
    place = source._chunks[0]
    begin, end = place.offset - HEADER_BYTES, place.offset + place.length
    path.write_bytes(data[:begin] + data[end:])
    with pytest.raises(UserError, match=r"run.mcap is damaged: it counts \d+ messages of \w+, and \d+ are there"):
        reread(path)


def test_hdf5_is_read_while_it_is_written(tmp_path: Path) -> None:
    """By another process, of which HDF5's locks keep the file."""
    source, path = made(SEED), tmp_path / "run.h5"
    sink = formats.open_sink(path, {"program": "record"})
    sink.add(source.groups[MAIN])
    sink.append(MAIN, whole(source, MAIN))
    folders = f"{ROOT / 'scripts'}:{ROOT / 'tests' / 'python'}"
    command = [sys.executable, "-m", "sextant_py.convert", str(path), str(tmp_path / "out.csv"), "--truncated"]
    done = subprocess.run(command, env={**os.environ, "PYTHONPATH": folders}, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stderr == (
        f"convert: {path} was not closed, so what came last may be missing; rows that are left: 700 of telemetry\n"
    )
    sink.close({"program": "record", "rows": sink.kept})
    assert whole(reread(tmp_path / "out.csv"), MAIN).tobytes() == whole(source, MAIN).tobytes()
    assert reread(path).cut is None


def test_an_error_of_the_system_is_named(tmp_path: Path) -> None:
    (tmp_path / "run.h5").mkdir()
    with pytest.raises(UserError, match=r"run\.h5 cannot be read: Is a directory"):
        reread(tmp_path / "run.h5")


@pytest.mark.parametrize("suffix", formats.SUFFIXES)
def test_too_few_descriptors_are_no_damage(tmp_path: Path, suffix: str) -> None:
    write(made(SEED), tmp_path / f"run{suffix}")
    reread(tmp_path / f"run{suffix}")  # what is imported at the first use
    limits = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (200, limits[1]))
    taken = []
    try:
        with suppress(OSError):
            while True:
                taken.append(os.open(os.devnull, os.O_RDONLY))
        with pytest.raises(UserError, match="Too many open files") as refused:
            formats.open_source(tmp_path / f"run{suffix}")
    finally:
        for descriptor in taken:
            os.close(descriptor)
        resource.setrlimit(resource.RLIMIT_NOFILE, limits)
    assert not re.search("damage|truncated|no Parquet|not an HDF5", str(refused.value))


def test_an_error_while_reading_names_the_source(tmp_path: Path) -> None:
    class Unreadable(MadeSource):
        def blocks(self, name: str, rows: int = 300) -> Iterator[np.ndarray]:
            raise OSError(5, "Input/output error")
            yield

    source = made(SEED)
    broken = Unreadable(source._blocks, list(source.groups.values()))
    with pytest.raises(UserError, match=r"^made cannot be read: Input/output error"):
        write(broken, tmp_path / "run.csv")
    assert list(tmp_path.iterdir()) == []


FILL_A_DISK = """
import resource, sys
from pathlib import Path
from made_recording import made
from sextant_py.errors import run
from sextant_py.recording.copying import copy

def fill(arguments):
    source = made(13, telemetry=60_000, periods=40_000)
    resource.setrlimit(resource.RLIMIT_FSIZE, (int(arguments[1]), resource.RLIM_INFINITY))
    copy(source, Path(arguments[0]), None, lambda share: None)

run("convert", fill)
"""


@pytest.mark.parametrize("suffix", formats.SUFFIXES)
@pytest.mark.parametrize("room", [100, 6_000_000])
def test_a_full_disk_ends_a_conversion_with_a_sentence(tmp_path: Path, suffix: str, room: int) -> None:
    """And leaves the recording that it should replace."""
    path, before = tmp_path / f"run{suffix}", made(SEED)
    write(before, path)
    files = sorted(tmp_path.iterdir())
    folders = f"{ROOT / 'scripts'}:{ROOT / 'tests' / 'python'}"
    environment = {**os.environ, "PYTHONPATH": folders, "PYTHONDONTWRITEBYTECODE": "1"}  # it would be cut as well
    command = [sys.executable, "-c", FILL_A_DISK, str(path), str(room)]
    ended = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=300)
    assert ended.returncode == 1, ended.stderr
    assert ended.stderr.startswith(f"convert: {path} cannot be written"), ended.stderr
    assert ended.stderr.count("\n") == 1
    assert ended.stderr.endswith("; nothing of it is kept.\n")
    assert_same(reread(path), before)
    assert sorted(tmp_path.iterdir()) == files


@pytest.mark.parametrize(
    ("words", "objection"),
    [
        (["run.h5", "run.xlsx"], r'run.xlsx: a recording ends in \.h5, \.csv, .*, and "\.xlsx" is none of them'),
        (["none.h5", "run.csv"], "none.h5 does not exist"),
        (["run.h5", "run.h5"], "run.h5 would replace .*run.h5, which is to be read; the converted one needs another"),
        (["header.csv", "run.csv"], "header.csv has no rows of telemetry; .*run.csv is not written"),
        (["number.csv", "out.h5"], "number.csv, line 1500002: .*invalid value 'abc'; correct or remove that line"),
        (["cell.csv", "out.h5"], "cell.csv: the column sector of whole numbers has an empty cell"),
        (["twice.csv", "out.h5"], "twice.csv:1: the column a occurs twice"),
        (["semicolons.csv", "out.h5"], "semicolons.csv:1: semicolons separate the columns: separate them by commas"),
        (["unnamed.csv", "out.h5"], "unnamed.csv:1: column 2 has no name"),
        (["run.h5", "run.csv", "--group", "nonsense"], "run.h5 has no group nonsense; it has telemetry, "),
        (["text.h5", "run.csv"], "text.h5 is not an HDF5 file"),
        (["text.mcap", "run.csv"], "text.mcap is not an MCAP file"),
        (["text.mf4", "run.csv"], "text.mf4 is no MDF file"),
        (["text.parquet", "run.csv"], "text.parquet is no Parquet file"),
        (["text.csv", "run.h5"], "has no time axis; it needs a signal t_ns or t_s"),
    ],
)
def test_bad_input_gets_a_sentence(tmp_path: Path, words: list[str], objection: str) -> None:
    write(made(SEED), tmp_path / "run.h5")
    for suffix in formats.SUFFIXES:
        (tmp_path / f"text{suffix}").write_text("some,words\n1,2\n", encoding="utf-8")
    (tmp_path / "cell.csv").write_text("t_s,sector\n0,1\n1,\n", encoding="utf-8")
    (tmp_path / "twice.csv").write_text("t_s,a,a\n0,1,1\n", encoding="utf-8")
    (tmp_path / "semicolons.csv").write_text("t_s;a\n0;1\n", encoding="utf-8")
    (tmp_path / "unnamed.csv").write_text("t_s,,a\n0,1,1\n", encoding="utf-8")
    (tmp_path / "header.csv").write_text("t_s,speed_rad_s\n", encoding="utf-8")
    (tmp_path / "number.csv").write_text("t_s,speed\n" + "3,4\n" * 1_500_000 + "2,abc\n", encoding="utf-8")
    before = (tmp_path / "run.h5").read_bytes()
    with pytest.raises(UserError, match=objection):
        convert.main([str(tmp_path / words[0]), str(tmp_path / words[1]), *words[2:]])
    assert (tmp_path / "run.h5").read_bytes() == before


def test_the_extremes_are_extreme() -> None:
    """Otherwise the round trips show less than they seem to."""
    rows = whole(made(SEED), EXTREMES.name)
    assert rows["whole_u8"].max() == 2**64 - 1
    assert rows["whole_i8"].min() == -(2**63)
    assert np.isinf(rows["single"]).any()
    assert {"", "Größe µ"} <= {word.decode() for word in rows["words"]}
