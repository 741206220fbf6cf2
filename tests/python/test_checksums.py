"""Damage of recordings as HDF5 and CSV: a byte that is flipped or removed is refused or changes nothing; a file that is
missing is named."""

import shutil
import subprocess
from pathlib import Path

import h5py
import numpy as np
import pytest
from made_recording import assert_same, made, reread, write
from sextant_py import convert
from sextant_py.errors import UserError
from sextant_py.paths import ROOT
from sextant_py.recording.model import MAIN

SEED = 29
FLIPS = 24  # of each file


def flipped(file: Path, place: int, bits: int) -> None:
    data = bytearray(file.read_bytes())
    data[place] ^= bits
    file.write_bytes(data)


def shortened(file: Path, place: int) -> None:
    data = file.read_bytes()
    file.write_bytes(data[:place] + data[place + 1 :])


def sentence_of(path: Path, output: Path) -> str | None:
    """What convert and playback refuse the recording with; None: they read it."""
    try:
        assert convert.main([str(path), str(output)]) == 0
    except UserError as error:
        assert "\n" not in str(error)
        return str(error)
    return None


@pytest.mark.parametrize("suffix", [".h5", ".csv"])
def test_a_flipped_byte_is_refused_or_changes_nothing(tmp_path: Path, suffix: str) -> None:
    source, whole = made(SEED), tmp_path / "whole"
    write(source, whole / f"run{suffix}")
    random = np.random.default_rng(SEED)
    files = sorted(whole.iterdir())
    if suffix == ".csv":
        listed = ["sha256sum", "--check", "--strict", "--quiet", "run.csv.sha256"]
        assert subprocess.run(listed, cwd=whole, check=True, capture_output=True).stdout == b""
        assert len(files) == len(source.groups) + 2
    refused = 0
    for file in files:
        for _ in range(FLIPS // len(files) + 1):
            place, bits = int(random.integers(file.stat().st_size)), int(random.integers(1, 256))
            copy = tmp_path / "copy"
            shutil.copytree(whole, copy)
            flipped(copy / file.name, place, bits)
            why = sentence_of(copy / f"run{suffix}", tmp_path / "out.mcap")
            if why is None:
                print(f"byte {place} of {file.name} ^ {bits}: no effect")
                assert_same(reread(tmp_path / "out.mcap"), source)
            refused += why is not None
            shutil.rmtree(copy)
    assert refused > FLIPS / 2


def test_a_character_that_was_removed_from_a_csv_recording_is_refused_or_changes_nothing(tmp_path: Path) -> None:
    """At seeded places of each file, of which some have a sign: without it the row has as many values as before."""
    source, whole = made(SEED), tmp_path / "whole"
    write(source, whole / "run.csv")
    random, refused = np.random.default_rng(SEED), 0
    files = sorted(whole.iterdir())
    for file in files:
        data = np.frombuffer(file.read_bytes(), np.uint8)
        signs = np.flatnonzero(data == ord("-"))
        places = [*random.integers(len(data), size=3), *random.permutation(signs)[:2], len(data) - 1]
        for place in map(int, places):
            copy = tmp_path / "copy"
            shutil.copytree(whole, copy)
            shortened(copy / file.name, place)
            why = sentence_of(copy / "run.csv", tmp_path / "out.mcap")
            if why is None:
                print(f"byte {place} of {file.name} removed: no effect")
                assert_same(reread(tmp_path / "out.mcap"), source)
            refused += why is not None
            shutil.rmtree(copy)
    assert refused > 3 * len(files)


def test_a_csv_file_that_lost_its_end_is_truncated_and_not_damaged(tmp_path: Path) -> None:
    """Whatever the length that is left, and a value that another file lacks a sign of is refused all the same."""
    source, path, random = made(SEED), tmp_path / "run.csv", np.random.default_rng(SEED)
    write(source, path)
    data = path.read_bytes()
    header = data.index(b"\n") + 1
    for size in (header, len(data) - 1, *map(int, random.integers(header, len(data), size=6))):
        path.write_bytes(data[:size])
        assert "run.csv is truncated: " in (sentence_of(path, tmp_path / "out.mcap") or "")
    other = tmp_path / "run.waveform.csv"
    shortened(other, other.read_bytes().index(b",-") + 1)
    assert "run.waveform.csv is damaged or was changed" in (sentence_of(path, tmp_path / "out.mcap") or "")


def test_a_file_that_is_missing_of_a_csv_recording_is_named(tmp_path: Path) -> None:
    """Each one alone, and a group's file together with the description that names the group."""
    source, whole = made(SEED), tmp_path / "whole"
    write(source, whole / "run.csv")
    places = [[file.name] for file in whole.iterdir() if file.suffix != ".sha256"]
    places += [[name, "run.csv.json"] for (name,) in places if name.endswith(".csv")]
    for lost in places:
        copy = tmp_path / "copy"
        shutil.copytree(whole, copy)
        for name in lost:
            (copy / name).unlink()
        why = sentence_of(copy / "run.csv", tmp_path / "out.mcap") or ""
        assert f"{copy / lost[-1]} does not exist" in why
        shutil.rmtree(copy)


def test_a_listed_file_that_no_group_has_is_named(tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    write(made(SEED), path)
    with (tmp_path / "run.csv.sha256").open("a", encoding="utf-8") as file:
        file.write(f"{'0' * 64}  run.another.csv\n")
    assert "run.csv.sha256 lists run.another.csv, " in (sentence_of(path, tmp_path / "out.mcap") or "")


def test_an_empty_list_verifies_nothing_and_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    write(made(SEED), path)
    (tmp_path / "run.csv.sha256").write_bytes(b"")
    assert "run.csv.sha256 has no checksum of run.csv.json" in (sentence_of(path, tmp_path / "out.mcap") or "")


def test_every_chunk_of_values_is_verified(tmp_path: Path) -> None:
    path, random = tmp_path / "run.h5", np.random.default_rng(SEED)
    write(made(SEED, periods=20_000), path)
    before = path.read_bytes()
    with h5py.File(path) as file:
        names = [f"waveform/{name}" for name in ("torque_nm", "t_ns", "state")] + ["torque_mean_nm", "can/data"]
        chunks = [
            file[name].id.get_chunk_info(index) for name in names for index in range(file[name].id.get_num_chunks())
        ]
    for chunk in chunks:
        path.write_bytes(before)
        flipped(path, chunk.byte_offset + int(random.integers(chunk.size)), int(random.integers(1, 256)))
        assert "run.h5 is damaged" in (sentence_of(path, tmp_path / "out.mcap") or "")


def test_a_chunk_at_the_place_of_another_is_noticed(tmp_path: Path) -> None:
    """The index of the chunks has no checksum: their offsets are the keys of a B-tree."""
    path = tmp_path / "run.h5"
    write(made(SEED, periods=20_000), path)
    data, keys = path.read_bytes(), []
    place = data.find(b"TREE")
    while place >= 0:
        if data[place + 4] == 1 and data[place + 6] > 1:  # of chunks, more than one
            keys.append(place + 24 + 24 + 8 + 8)  # the offset of the second one
        place = data.find(b"TREE", place + 1)
    assert len(keys) > 5
    for key in keys[::5]:
        assert int.from_bytes(data[key : key + 8], "little") == 4096
        for changed in (key + 1, key - 4):  # offset and mask of filters
            path.write_bytes(data)
            flipped(path, changed, 1)
            assert "run.h5 is damaged" in (sentence_of(path, tmp_path / "out.mcap") or "")


@pytest.mark.parametrize("suffix", [".h5", ".csv"])
def test_a_file_without_checksums_is_read_with_a_note(
    tmp_path: Path, suffix: str, capsys: pytest.CaptureFixture
) -> None:
    path, note = (
        tmp_path / f"run{suffix}",
        f"run{suffix} has no checksums, so that damage of its values is not noticed\n",
    )
    write(made(SEED), path)
    assert convert.main([str(path), str(tmp_path / "out.mcap")]) == 0
    assert capsys.readouterr().err == ""
    if suffix == ".csv":
        (tmp_path / "run.csv.sha256").unlink()
    else:
        with h5py.File(path, "w") as file:
            file["t_ns"], file["torque_mean_nm"] = np.arange(10), np.zeros(10)
    assert convert.main([str(path), str(tmp_path / "out.mcap")]) == 0
    assert capsys.readouterr().err == f"convert: {tmp_path}/{note}"


def test_programs_refuse_damage_with_one_sentence(tmp_path: Path) -> None:
    """The programs themselves; playback before it publishes anything."""
    write(made(SEED), tmp_path / "run.csv")
    flipped(tmp_path / "run.csv", 5000, 1)
    for words in (["convert", "run.csv", "out.h5"], ["playback", "run.csv"]):
        command = [ROOT / "scripts" / words[0], *words[1:]]
        ended = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=300)
        assert (ended.returncode, ended.stdout, ended.stderr.count("\n")) == (2, "", 1)
        assert "run.csv is damaged or was changed: its SHA-256 is not that in run.csv.sha256" in ended.stderr


def test_no_checksums_of_an_earlier_recording_stay(tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    write(made(SEED), path)
    flipped(path, 300, 1)
    write(made(SEED + 1), path)
    assert_same(reread(path), made(SEED + 1))
    assert reread(path).rows(MAIN)
