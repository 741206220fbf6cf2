"""Pictures of a trace and of a recording, and what a bad file is told."""

from pathlib import Path

import h5py
import numpy as np
import pytest
from sextant_py import plot
from sextant_py.errors import UserError

PNG = b"\x89PNG\r\n\x1a\n"


def write_trace(path: Path, count: int, time_name: str) -> None:
    t_s = np.linspace(0, 1, count)
    with h5py.File(path, "w") as file:
        file["t_ns" if time_name == "t_ns" else "t_s"] = (
            (t_s * 1e9).astype(np.int64) + 7_000_000_000 if time_name == "t_ns" else t_s
        )
        for name, value in {
            "torque_requested_nm": 15 * np.sign(t_s - 0.5),
            "torque_reference_nm": 15 * np.sign(t_s - 0.5),
            "torque_mean_nm": 15 * np.tanh(20 * (t_s - 0.5)),
            "torque_min_nm": 15 * np.tanh(20 * (t_s - 0.5)) - 3,
            "torque_max_nm": 15 * np.tanh(20 * (t_s - 0.5)) + 3,
            "flux_mean_wb": np.full(count, 1.1),
            "speed_rad_s": 30 * t_s,
            "current_mean_a": np.full(count, 20.0),
        }.items():
            file[name] = value


@pytest.mark.parametrize(("count", "time_name"), [(500, "t_s"), (50_000, "t_ns")])
def test_picture_is_written(tmp_path: Path, count: int, time_name: str) -> None:
    write_trace(tmp_path / "trace.h5", count, time_name)
    assert plot.main([str(tmp_path / "trace.h5")]) == 0
    picture = (tmp_path / "trace.png").read_bytes()
    assert picture.startswith(PNG)
    assert len(picture) > 20_000


def test_nanoseconds_count_from_the_first_sample(tmp_path: Path) -> None:
    write_trace(tmp_path / "trace.h5", 101, "t_ns")
    signals = plot.load(tmp_path / "trace.h5", 0.25, 0.75)
    assert signals.time_s[0] == pytest.approx(0.25)
    assert signals.time_s[-1] == pytest.approx(0.75)
    assert len(signals.get("torque_mean_nm")) == len(signals.time_s) == 51


def test_blocks_keep_peaks_and_mean() -> None:
    values = np.zeros(10 * plot.MAX_POINTS + 3)
    values[12_345] = 50.0
    values[20_000] = -7.0
    assert plot.blocks(values, "max").max() == 50.0
    assert plot.blocks(values, "min").min() == -7.0
    assert len(plot.blocks(values, "mean")) <= plot.MAX_POINTS
    assert np.average(plot.blocks(values + 1.0, "mean")) == pytest.approx(1.0, abs=0.01)


def test_missing_signals_leave_an_empty_panel(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "few.h5", "w") as file:
        file["t_s"] = [0.0, 1.0]
    assert plot.main([str(tmp_path / "few.h5"), "-o", str(tmp_path / "out" / "few.png")]) == 0
    assert (tmp_path / "out" / "few.png").read_bytes().startswith(PNG)


def test_further_signals_have_panels_of_their_own(tmp_path: Path) -> None:
    write_trace(tmp_path / "trace.h5", 500, "t_ns")
    before = plot.load(tmp_path / "trace.h5")
    assert plot.further_panels(before) == []
    with h5py.File(tmp_path / "trace.h5", "a") as file:
        for leg in "abc":
            file[f"plant/switch_{leg}"] = np.ones(500, dtype=np.int8)
        file["plant/energy_link_j"] = np.linspace(0, 100, 500)
        file["control/torque_comparator"] = -np.ones(500, dtype=np.int8)
    panels = plot.further_panels(plot.load(tmp_path / "trace.h5"))
    assert [names for _, names in panels] == [
        ("plant/switch_a", "plant/switch_b", "plant/switch_c"),
        ("control/torque_comparator",),
        ("plant/energy_link_j",),
    ]
    assert plot.main([str(tmp_path / "trace.h5")]) == 0
    assert (tmp_path / "trace.png").read_bytes().startswith(PNG)


def test_channels_of_a_controller_are_drawn_by_unit(tmp_path: Path) -> None:
    write_trace(tmp_path / "trace.h5", 500, "t_ns")
    with h5py.File(tmp_path / "trace.h5", "a") as file:
        for name, unit in (("i_d_a", b"A"), ("i_q_a", b"A"), ("psi_r_wb", "Wb"), ("without_unit", None)):
            file[f"control/{name}"] = np.linspace(0, 1, 500)
            if unit is not None:
                file[f"control/{name}"].attrs["unit"] = unit
    panels = plot.further_panels(plot.load(tmp_path / "trace.h5"))
    assert [names for _, names in panels] == [
        ("control/i_d_a", "control/i_q_a"),
        ("control/psi_r_wb",),
        ("control/without_unit",),
    ]
    assert plot.main([str(tmp_path / "trace.h5")]) == 0


def test_bad_files(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="does not exist"):
        plot.load(tmp_path / "none.h5")
    (tmp_path / "text.h5").write_text("no HDF5")
    with pytest.raises(UserError, match="is not an HDF5 file"):
        plot.load(tmp_path / "text.h5")
    with h5py.File(tmp_path / "empty.h5", "w"):
        pass
    with pytest.raises(UserError, match="neither samples of t_s nor of t_ns"):
        plot.load(tmp_path / "empty.h5")
    write_trace(tmp_path / "trace.h5", 11, "t_s")
    with pytest.raises(UserError, match="no sample in that span"):
        plot.load(tmp_path / "trace.h5", 5.0)
