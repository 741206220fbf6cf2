"""Files of other programs in every format of a recording: each is read whole, or told from a damaged one."""

import bz2
import gzip
import io
import json
import lzma
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pyarrow
import pytest
from asammdf import MDF, Signal
from mcap.writer import CompressionType, Writer
from pyarrow import parquet
from sextant_py import compare, convert, expect, playback, plot
from sextant_py.errors import UserError
from sextant_py.paths import ROOT
from sextant_py.recording import formats, topics
from sextant_py.recording.model import MAIN
from sextant_py.report import program as report
from sextant_py.telemetry_contract import signals

N = 60
T = np.arange(N) / 100
TORQUE = np.where(T > 0.2, 10.0, 0.0)
NOT_OF_SEXTANT = "was not written by Sextant"
GROUP = {
    "name": MAIN,
    "text": "",
    "time_of": "",
    "signals": [["t_ns", "<i8", "ns", ""], ["torque_nm", "<f4", "N·m", ""]],
}


def drained(path: Path) -> dict[str, np.ndarray]:
    """Every row of every group."""
    source = formats.open_source(path)
    found = {}
    for name, group in source.groups.items():
        found[name] = np.concatenate([np.empty(0, group.dtype), *source.blocks(name)])
        assert len(found[name]) == source.rows(name)
    return found


def table(**columns: np.ndarray) -> Callable[[h5py.File], None]:
    def fill(file: h5py.File) -> None:
        for name, values in {"t_s": T, "torque_nm": TORQUE, **columns}.items():
            file[name] = values

    return fill


def hdf5(path: Path, *fills: Callable[[h5py.File], object]) -> Path:
    with h5py.File(path, "w") as file:
        for fill in fills:
            fill(file)
    return path


def csv(heading: str = "t_s,torque_nm", *, more: str = "", tail: str = "") -> bytes:
    rows = "".join(f"{t},{torque}{more}\n" for t, torque in zip(T, TORQUE, strict=True))
    return f"{heading}\n{rows}{tail}".encode()


# ---- read whole


def test_an_hdf5_group_called_telemetry_is_read(tmp_path: Path) -> None:
    path = hdf5(tmp_path / "a.h5", lambda file: table()(file.create_group(MAIN)))
    found = drained(path)
    assert list(found) == [MAIN]
    np.testing.assert_array_equal(found[MAIN]["torque_nm"], TORQUE)


def test_signals_of_the_root_and_of_a_group_called_telemetry_are_kept_apart(tmp_path: Path) -> None:
    path = hdf5(tmp_path / "a.h5", table(), lambda file: table(speed=2 * T)(file.create_group(MAIN)))
    assert convert.main([str(path), str(tmp_path / "b.mcap")]) == 0
    found = drained(tmp_path / "b.mcap")
    assert list(found) == [MAIN, f"{MAIN}_2"]
    np.testing.assert_array_equal(found[f"{MAIN}_2"]["speed"], 2 * T)


def test_a_group_called_telemetry_may_share_the_times_of_the_root(tmp_path: Path) -> None:
    path = hdf5(tmp_path / "a.h5", table(), lambda file: file.create_group(MAIN).create_dataset("x", data=3 * T))
    found = drained(path)
    np.testing.assert_array_equal(found[f"{MAIN}_2"]["x"], 3 * T)
    np.testing.assert_array_equal(found[f"{MAIN}_2"]["t_s"], T)


def test_an_hdf5_group_that_holds_itself_is_read_once(tmp_path: Path) -> None:
    def loop(file: h5py.File) -> None:
        file.create_group("g")["back"] = file["/"]

    assert list(drained(hdf5(tmp_path / "a.h5", table(), loop))) == [MAIN]


def attributes(file: h5py.File) -> None:
    """As MATLAB and LabVIEW leave them."""
    file.attrs["list"] = np.array([1.0, 2.0])
    file.attrs["empty"] = h5py.Empty("f4")
    file.attrs["latin"] = b"\xb0C"
    file.attrs["begin_ns"] = "soon"
    file["torque_nm"].attrs["unit"] = np.array([b"N m"])
    file["torque_nm"].attrs["description"] = "Größe".encode("latin-1")


@pytest.mark.parametrize("suffix", formats.SUFFIXES)
def test_attributes_of_other_programs_are_carried_to_every_format(tmp_path: Path, suffix: str) -> None:
    path = hdf5(tmp_path / "a.h5", table(), attributes)
    assert convert.main([str(path), str(tmp_path / f"b{suffix}")]) == 0
    source = formats.open_source(tmp_path / f"b{suffix}")
    column = source.groups[MAIN].columns[1]
    assert (column.name, column.unit, column.text) == ("torque_nm", "N m", "Größe")
    assert source.metadata["attributes"]["list"] == [1, 2]
    assert source.metadata["attributes"]["latin"] == "°C"


def test_what_has_no_time_axis_is_named(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    path = hdf5(tmp_path / "a.h5", table(plane=np.zeros((N, 2)), gain=3.0))
    assert convert.main([str(path), str(tmp_path / "b.csv")]) == 0
    assert "what has no time axis is left out: /gain, /plane" in capsys.readouterr().err


def test_signals_of_unlike_lengths_do_not_lose_values_without_a_word(tmp_path: Path) -> None:
    path = hdf5(tmp_path / "a.h5", lambda file: file.update({"t_s": T, "torque_nm": TORQUE[:20]}))
    with pytest.raises(UserError, match="more values than others beside them: /t_s; rows that are left: 20"):
        convert.main([str(path), str(tmp_path / "b.csv")])


@pytest.mark.parametrize(
    ("text", "column", "values"),
    [
        (b"# made by a scope\n\n" + csv(), "torque_nm", TORQUE),
        (b"\n\n" + csv(), "torque_nm", TORQUE),
        (csv("t_s,torque_nm,on", more=",true", tail="2,1,false\n"), "on", [*[1] * N, 0]),
        (csv(tail="2,nan\n3,NaN\n4,\n"), "torque_nm", [*TORQUE, np.nan, np.nan, np.nan]),
    ],
    ids=["comment", "empty lines", "true and false", "values that are none"],
)
def test_a_csv_file_is_read_whole(tmp_path: Path, text: bytes, column: str, values: list) -> None:
    (tmp_path / "a.csv").write_bytes(text)
    np.testing.assert_array_equal(drained(tmp_path / "a.csv")[MAIN][column], values)


# ---- refused, without a wrong accusation


def mcap(path: Path, encoding: str = "cdr", group: object = None, metadata: dict | None = None) -> None:
    stream = io.BytesIO()
    writer = Writer(stream, compression=CompressionType.NONE)
    writer.start()
    about = {} if group is None else {"sextant_group": json.dumps(group)}
    channel = writer.register_channel("/x", encoding, writer.register_schema("x", "jsonschema", b"{}"), metadata=about)
    for k in range(20):
        writer.add_message(channel, k, b'{"torque_nm": 1}', k)
    if metadata is not None:
        writer.add_metadata("sextant_recording", metadata)
    writer.finish()
    path.write_bytes(stream.getvalue())


def arrow(path: Path, metadata: dict | None = None, **columns: np.ndarray) -> None:
    parquet.write_table(pyarrow.table({"t_s": T, **columns}).replace_schema_metadata(metadata), path)


def mdf(path: Path, attachment: bytes | None = None, version: str = "4.10") -> None:
    file = MDF(version=version)
    file.append([Signal(TORQUE, T, name="torque_nm")], acq_name=MAIN)
    if attachment is not None:
        options = {"mime": "application/json", "compression": True, "embedded": True}
        file.attach(attachment, "sextant_recording.json", **options)
    file.save(path.with_suffix(".mdf"), overwrite=True).replace(path)


def broken_link(file: h5py.File) -> None:
    file["lost"] = h5py.SoftLink("/none")


def outer_link(file: h5py.File) -> None:
    file["lost"] = h5py.ExternalLink("none.h5", "/x")


def of_recording(text: str) -> Callable[[h5py.File], None]:
    return lambda file: file.attrs.update({"recording": text})


ANOTHER = {"recording": {}, "groups": [{**GROUP, "signals": [["t_ns", "<i8", "", ""], ["other", "<f8", "", ""]]}]}
REFUSED: dict[str, tuple[Callable[[Path], object], str]] = {
    "list.h5": (lambda path: hdf5(path, table(), of_recording("[]")), NOT_OF_SEXTANT),
    "shape.h5": (lambda path: hdf5(path, table(), of_recording('{"attributes": 5}')), NOT_OF_SEXTANT),
    "rows.h5": (lambda path: hdf5(path, table(), of_recording('{"rows": {"a": "b"}}')), NOT_OF_SEXTANT),
    "soft.h5": (lambda path: hdf5(path, table(), broken_link), "it has the link /lost to what is not there"),
    "outer.h5": (lambda path: hdf5(path, table(), outer_link), "it has the link /lost to what is not there"),
    "complex.h5": (lambda path: hdf5(path, table(c=T + 1j)), "the signal /c has the type complex128"),
    "none.h5": (lambda path: hdf5(path, lambda file: file.update({"x": T})), "no signals with a time axis"),
    "latin_heading.csv": (
        lambda path: path.write_bytes("t_s,Größe\n0,1\n".encode("latin-1")), "line 1: this is no text in UTF-8",
    ),
    "latin_cell.csv": (
        lambda path: path.write_bytes(csv("t_s,torque_nm,note", more=",a", tail="2,3,µ\n").decode().encode("latin-1")),
        f"line {N + 2}: this is no text in UTF-8",
    ),
    "utf16.csv": (lambda path: path.write_bytes(csv().decode().encode("utf-16")), "line 1: this is no text in UTF-8"),
    "empty.csv": (lambda path: path.write_bytes(b""), "it has no heading"),
    "comments.csv": (lambda path: path.write_bytes(b"# a\n# b\n"), "it has no heading"),
    "twice.csv": (lambda path: path.write_bytes(b"\n" + csv("t_s,t_s")), ":2: the column t_s occurs twice"),
    "units.csv": (
        lambda path: path.write_bytes(csv("t_s,torque_nm\ns,Nm")), 'row 1 of the column t_s has "s", which is no',
    ),
    "text.csv": (
        lambda path: path.write_bytes(csv(tail="2,off\n")), f'row {N + 1} of the column torque_nm has "off", which is',
    ),
    "date.csv": (
        lambda path: path.write_bytes(b"t_s,torque_nm\n2026-01-01 00:00:01,1\n"), "t_s has dates or times of day",
    ),
    "quote.csv": (lambda path: path.write_bytes(csv('"t_s,torque_nm')), ":1: a quote of the heading is not closed"),
    "time.csv": (lambda path: path.write_bytes(csv("time,torque_nm")), "the group telemetry has no time axis"),
    "json.mcap": (lambda path: mcap(path, "json"), "has no channel of a Sextant recording"),
    "encoding.mcap": (lambda path: mcap(path, "json", GROUP), NOT_OF_SEXTANT),
    "group.mcap": (lambda path: mcap(path, group={"a": 1}), NOT_OF_SEXTANT),
    "kind.mcap": (lambda path: mcap(path, group={**GROUP, "signals": [["t_ns", "<q9", "", ""]]}), NOT_OF_SEXTANT),
    "metadata.mcap": (lambda path: mcap(path, metadata={"a": "b"}), NOT_OF_SEXTANT),
    "shape.mcap": (lambda path: mcap(path, metadata={"json": "[]"}), NOT_OF_SEXTANT),
    "magic.mcap": (lambda path: path.write_bytes(b"\x89MCAP0\r\n"), "is truncated, and nothing of it is readable"),
    "plain.parquet": (lambda path: arrow(path), "holds no group of a Sextant recording"),
    "group.parquet": (lambda path: arrow(path, {"sextant_group": "{}"}), NOT_OF_SEXTANT),
    "columns.parquet": (
        lambda path: arrow(path, {"sextant_group": json.dumps(GROUP)}, torque_nm=TORQUE), NOT_OF_SEXTANT,
    ),
    "plain.mf4": (mdf, "it has no attachment sextant_recording.json"),
    "shape.mf4": (lambda path: mdf(path, b"{}"), NOT_OF_SEXTANT),
    "columns.mf4": (lambda path: mdf(path, json.dumps(ANOTHER).encode()), NOT_OF_SEXTANT),
    "old.mf4": (lambda path: mdf(path, version="3.30"), "is MDF 3.30, and MDF 4 is read"),
    **{f"folder{suffix}": (lambda path: path.mkdir(), "cannot be read: Is a directory") for suffix in formats.SUFFIXES},
    **{
        f"packed{suffix}": (lambda path: path.write_bytes(gzip.compress(csv())), "is compressed: unpack it with gzip")
        for suffix in formats.SUFFIXES
    },
    "packed_xz.csv": (lambda path: path.write_bytes(lzma.compress(csv())), "is compressed: unpack it with xz -d"),
    "packed_bz2.csv": (lambda path: path.write_bytes(bz2.compress(csv())), "is compressed: unpack it with bzip2 -d"),
    "folder_beside.csv": (
        lambda path: (path.write_bytes(csv()), path.with_name(path.name + ".json").mkdir()),
        "folder_beside.csv.json: Is a directory",
    ),
    "beside.csv": (
        lambda path: (path.write_bytes(csv()), path.with_name(path.name + ".json").write_text('{"a": 1}')),
        "beside.csv.json does not describe a recording as Sextant does",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_read_is_not_called_damaged(tmp_path: Path, name: str) -> None:
    make, words = REFUSED[name]
    make(tmp_path / name)
    with pytest.raises(UserError, match=words) as refusal:
        drained(tmp_path / name)
    text = str(refusal.value)
    assert text.startswith(str(tmp_path / name))
    assert "damage" not in text
    assert "\n" not in text


HUGE = (np.nan, np.inf, -np.inf, 1e300)


@pytest.mark.parametrize("value", HUGE)
def test_a_time_that_is_none_is_named_by_its_row(tmp_path: Path, value: float) -> None:
    (tmp_path / "a.csv").write_bytes(csv(tail=f"{value},0\n"))
    hdf5(tmp_path / "a.h5", lambda file: file.update({"t_s": [*T, value], "torque_nm": [*TORQUE, 0]}))
    for file in ("a.csv", "a.h5"):
        with pytest.raises(UserError, match=rf"{file}, row {N + 1} of telemetry: t_s is .*: expected a number from"):
            drained(tmp_path / file)


def test_nanoseconds_beyond_64_bits_are_refused_and_the_last_that_fit_are_not(tmp_path: Path) -> None:
    for first, is_good in ((2**63 - N, True), (2**63 - N + 1, False)):
        times = np.arange(N, dtype=np.uint64) + np.uint64(first)
        path = hdf5(tmp_path / f"{first}.h5", lambda file, times=times: file.update({"t_ns": times, "x": T}))
        if is_good:
            assert drained(path)[MAIN]["t_ns"].tolist() == times.tolist()
        else:
            with pytest.raises(UserError, match=rf"row {N} of telemetry: t_ns is"):
                drained(path)


SCENARIO = ROOT / "configs" / "scenarios" / "constant_torque.toml"
COMMANDS: dict[str, Callable[[Path, Path], int]] = {
    "convert": lambda path, out: convert.main([str(path), str(out / "b.h5")]),
    "plot": lambda path, out: plot.main([str(path), "-o", str(out / "a.png")]),
    "playback": lambda path, _: playback.main([str(path)]),
    "compare": lambda path, _: compare.main([str(path), str(path), "--align", "rise torque_nm 5"]),
    "report": lambda path, out: report.main([str(path), "--out", str(out / "a.html")]),
    "expect": lambda path, _: expect.main([str(SCENARIO), str(path)]),
}


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("name", ["latin_heading.csv", "shape.h5", "encoding.mcap", "group.parquet", "shape.mf4"])
def test_every_command_refuses_alike(tmp_path: Path, name: str, command: str) -> None:
    make, words = REFUSED[name]
    make(tmp_path / name)
    with pytest.raises(UserError, match=words):
        COMMANDS[command](tmp_path / name, tmp_path)


# ---- playback of numbers that the contract does not have


def test_whole_numbers_may_stand_in_floating_point() -> None:
    known = {signal.name: signal for signal in signals("DriveTelemetry")}
    assert topics.member(known["t_ns"], 1070000000.0000001) == 1_070_000_000
    assert isinstance(topics.member(known["drive_id"], 3.0), int)
    for name, value in (("drive_id", -1), ("drive_id", 1.5), ("t_ns", 2**63), ("drive_id", float("nan"))):
        with pytest.raises(UserError, match=f"the recording has {name} .*, where the telemetry contract has a whole"):
            topics.member(known[name], value)
    with pytest.raises(UserError, match="the recording has a text as t_ns"):
        topics.member(known["t_ns"], b"soon")
