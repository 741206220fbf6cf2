"""Traces and recordings as signals and as DataFrames, against the values that were written."""

from pathlib import Path

import h5py
import numpy as np
import pytest
import sextant
from made_recording import write_cut
from sextant_py import signal_file
from sextant_py.errors import UserError
from sextant_py.recording.can_frames import FRAMES
from sextant_py.recording.formats import SUFFIXES, open_sink
from sextant_py.recording.topics import WAVEFORM, group_of
from sextant_py.telemetry_contract import signals

TIME_NS = 5_000_000_000 + 1_000_000 * np.arange(101)
TORQUE = np.sin(0.1 * np.arange(101))


def write_hdf5(path: Path) -> None:
    with h5py.File(path, "w") as file:
        file["t_ns"] = TIME_NS
        file["torque_mean_nm"] = TORQUE
        file["torque_mean_nm"].attrs["unit"] = np.bytes_("N·m".encode())
        file["torque_mean_nm"].attrs["description"] = "estimated torque"
        file["plant/torque_nm"] = 2 * TORQUE


def write_recording(path: Path) -> dict[str, np.ndarray]:
    """Telemetry each 1 ms and, 10 ms later, the waveform each 25 µs; returns the rows of both."""
    rows = {}
    for name, count, period_ns, begin_ns in (("telemetry", 101, 1_000_000, 0), (WAVEFORM, 800, 25_000, 10_000_000)):
        group = group_of(name)
        block = np.zeros(count, group.dtype)
        block["t_ns"] = TIME_NS[0] + begin_ns + period_ns * np.arange(count)
        block["torque_mean_nm" if name == "telemetry" else "torque_nm"] = np.sin(np.arange(count))
        block["state"] = 4
        rows[name] = block
    sink = open_sink(path, {})
    for name, block in rows.items():
        sink.add(group_of(name))
        sink.append(name, block)
    sink.close({"rows": {name: len(block) for name, block in rows.items()}})
    return rows


def test_a_frame_has_time_values_and_units(tmp_path: Path) -> None:
    write_hdf5(tmp_path / "trace.h5")
    frame = sextant.read(tmp_path / "trace.h5")
    assert (frame.index.name, frame.index[0], frame.index[-1]) == ("t_s", 0.0, pytest.approx(0.1))
    assert set(frame.columns) == {"t_ns", "torque_mean_nm", "plant/torque_nm"}
    np.testing.assert_array_equal(frame["plant/torque_nm"], 2 * TORQUE)
    assert frame.attrs["units"]["torque_mean_nm"] == "N·m"
    assert frame.attrs["descriptions"]["torque_mean_nm"] == "estimated torque"
    assert frame.loc[0.02:0.03, "t_ns"].tolist() == TIME_NS[20:31].tolist()


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_recordings_of_every_format(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"recording{suffix}"
    rows = write_recording(path)
    for group, torque in ((None, "torque_mean_nm"), (WAVEFORM, "torque_nm")):
        frame = sextant.read(path, group)
        expected = rows[group or "telemetry"]
        np.testing.assert_array_equal(frame[torque], expected[torque])
        np.testing.assert_array_equal(frame["t_ns"], expected["t_ns"])
        np.testing.assert_allclose(frame.index, (expected["t_ns"] - TIME_NS[0]) / 1e9, atol=1e-9)
        known = {signal.name: signal for signal in signals("DriveWaveform" if group else "DriveTelemetry")}
        assert frame.attrs["units"][torque] == known[torque].unit == "N·m"
        assert frame.attrs["descriptions"][torque] == known[torque].text
    with pytest.raises(UserError, match='has no group "nonsense"; it has telemetry, waveform'):
        sextant.read(path, "nonsense")


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_texts_are_columns_of_a_frame(tmp_path: Path, suffix: str) -> None:
    path, groups = tmp_path / f"recording{suffix}", {"drive_state": group_of("drive_state"), "can": FRAMES}
    sink = open_sink(path, {})
    for name, column in (("drive_state", "reason"), ("can", "data")):
        block = np.zeros(2, groups[name].dtype)
        block["t_ns"], block[column] = TIME_NS[:2], ["größer".encode(), b"01ff"]
        sink.add(groups[name])
        sink.append(name, block)
    sink.close({})
    assert sextant.read(path, "drive_state")["reason"].tolist() == ["größer", "01ff"]
    assert sextant.read(path, "can")["data"].tolist() == ["größer", "01ff"]


def test_a_recording_that_was_cut_off_keeps_its_complete_lines(tmp_path: Path) -> None:
    write_cut(tmp_path / "cut.csv")
    with pytest.warns(UserWarning, match="is truncated: rows that are lost: 1 of telemetry"):
        frame = sextant.read(tmp_path / "cut.csv")
    assert frame["torque_mean_nm"].tolist() == [1.5, 2.25]


def test_a_span_of_time(tmp_path: Path) -> None:
    write_hdf5(tmp_path / "trace.h5")
    found = signal_file.load(tmp_path / "trace.h5", 0.02, 0.03)
    np.testing.assert_array_equal(found.values["torque_mean_nm"], TORQUE[20:31])
    np.testing.assert_array_equal(found.values["plant/torque_nm"], 2 * TORQUE[20:31])
    with pytest.raises(UserError, match=r"no sample in that span; it runs from 0 s to 0\.1 s"):
        signal_file.load(tmp_path / "trace.h5", 3.0)


def test_bad_files_are_refused_in_a_sentence(tmp_path: Path) -> None:
    (tmp_path / "text.h5").write_text("no HDF5")
    (tmp_path / "text.csv").write_text("")
    (tmp_path / "empty.csv").write_text("t_ns,torque_mean_nm\n")
    for name, words in (
        ("text.h5", "is not an HDF5 file"),
        ("text.csv", "is not a CSV file of a recording"),
        ("empty.csv", "has no samples of telemetry"),
        ("none.csv", "does not exist"),
        ("none.xyz", 'a recording ends in .h5, .*, and ".xyz" is none of them'),
    ):
        with pytest.raises(UserError, match=words) as refusal:
            sextant.read(tmp_path / name)
        assert "\n" not in str(refusal.value)


def test_a_csv_file_without_a_description_has_units_and_decimals_of_the_contract(tmp_path: Path) -> None:
    """Also where the first block, of about a megabyte, has whole numbers alone."""
    path, count = tmp_path / "telemetry.csv", 100_000
    rows = [f"{k}000000,{4 if k < count else 6},0,{k}" for k in range(count)]
    path.write_text("\n".join(["t_ns,state,torque_mean_nm,mine", *rows, f"{count}000000,6,1.5,7"]) + "\n")
    signals = signal_file.load(path)
    assert (signals.units["torque_mean_nm"], signals.units["mine"]) == ("N·m", "")
    assert signals.values["torque_mean_nm"][-1] == 1.5
    assert signals.values["state"].dtype.kind == "i"
