"""Traces and recordings as signals and as DataFrames, against the values that were written."""

from pathlib import Path

import h5py
import numpy as np
import pytest
import sextant
from sextant_py import record, signal_file
from sextant_py.errors import UserError
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
        file["other_length"] = [1.0, 2.0]


def test_a_frame_has_time_values_and_units(tmp_path: Path) -> None:
    write_hdf5(tmp_path / "trace.h5")
    frame = sextant.read(tmp_path / "trace.h5")
    assert (frame.index.name, frame.index[0], frame.index[-1]) == ("t_s", 0.0, pytest.approx(0.1))
    assert set(frame.columns) == {"t_ns", "torque_mean_nm", "plant/torque_nm"}
    np.testing.assert_array_equal(frame["plant/torque_nm"], 2 * TORQUE)
    assert frame.attrs["units"]["torque_mean_nm"] == "N·m"
    assert frame.attrs["descriptions"]["torque_mean_nm"] == "estimated torque"
    assert frame.loc[0.02:0.03, "t_ns"].tolist() == TIME_NS[20:31].tolist()


def test_a_recording_in_csv_has_the_units_of_the_contract(tmp_path: Path) -> None:
    sink = record.CsvSink(tmp_path / "recording.csv", ["t_ns", "state", "torque_mean_nm"])
    sink.append([[int(t_ns), 2, float(torque)] for t_ns, torque in zip(TIME_NS, TORQUE, strict=True)])
    sink.close()
    frame = sextant.read(str(tmp_path / "recording.csv"))
    np.testing.assert_array_equal(frame["torque_mean_nm"], TORQUE)
    known = {signal.name: signal for signal in signals("DriveTelemetry")}
    assert frame.attrs["units"]["torque_mean_nm"] == known["torque_mean_nm"].unit == "N·m"
    assert frame.attrs["descriptions"]["state"] == known["state"].text


def test_a_recording_that_was_cut_off_keeps_its_complete_lines(tmp_path: Path) -> None:
    (tmp_path / "cut.csv").write_text("t_ns,torque_mean_nm\n0,1.5\n1000000,2.25\n2000000,3.1")
    with pytest.warns(UserWarning, match="the last line is not complete and is left out"):
        found = signal_file.load(tmp_path / "cut.csv")
    assert found.values["torque_mean_nm"].tolist() == [1.5, 2.25]


def test_bad_files_are_refused_in_a_sentence(tmp_path: Path) -> None:
    write_hdf5(tmp_path / "whole.h5")
    whole = (tmp_path / "whole.h5").read_bytes()
    (tmp_path / "cut.h5").write_bytes(whole[: len(whole) // 2])
    (tmp_path / "text.csv").write_text("")
    for name, words in (
        ("cut.h5", "is damaged or still being written"),
        ("text.csv", "is not a table of comma-separated values"),
        ("none.csv", "does not exist"),
        ("none.xyz", r'the ending ".xyz"; known are .h5, '),
    ):
        with pytest.raises(UserError, match=words) as refusal:
            sextant.read(tmp_path / name)
        assert "\n" not in str(refusal.value)
