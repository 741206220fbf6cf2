"""Table and pictures of a sweep, from records made up here."""

import itertools
import math
from pathlib import Path

import numpy as np
import pyarrow.csv
import pyarrow.parquet
import pytest
from matplotlib import pyplot as plt
from matplotlib.backends.backend_agg import RendererAgg
from matplotlib.text import Text
from sextant_py import sweep_file, sweep_plot, sweep_table
from sextant_py.sweep_store import SweepStore

GRID = """scenario = "scenario.toml"
[set]
duration_s = 0.5
[grid]
control.dtc.torque_band_upper_nm = [1.5, 0.5, 1.0]
control.dtc.comparator_reading = ["relay", "memoryless"]
drive.actuation_delay_periods = [0, 1]
[plot]
metrics = ["torque_ripple_pp_nm"]
"""
RANDOM = """scenario = "scenario.toml"
[random]
samples = 8
seed = 3
[random.ranges]
machine.r_s_ohm = { from = 0.2, to = 0.6 }
machine.r_r_ohm = { from = 0.1, to = 10, scale = "log" }
[plot]
metrics = ["torque_ripple_pp_nm"]
"""
UNITS = {"torque_ripple_pp_nm": "N·m", "machine.r_r_ohm": "ohm"}
METRIC = "torque_ripple_pp_nm"


def stored(directory: Path, text: str) -> tuple[sweep_file.Sweep, SweepStore]:
    """The ripple of point k is k; point 1 failed, point 2 missed an expectation, point 3 has no value."""
    (directory / "scenario.toml").touch()
    (directory / "sweep.toml").write_text(text, encoding="utf-8")
    sweep = sweep_file.load(directory / "sweep.toml")
    store = SweepStore(directory / "out", sweep, "", "")
    store.open()
    for k in reversed(range(len(sweep.points))):
        status = {1: "failed", 2: "expect_failed"}.get(k, "ok")
        metrics = {METRIC: None if k == 3 else float(k)}
        store.add({"point": k, "status": status, "reason": 'a, "b"' if k == 1 else "", "metrics": metrics})
    return sweep, store


def test_the_table_has_a_row_for_each_point(tmp_path: Path) -> None:
    sweep, store = stored(tmp_path, GRID)
    files = sweep_table.write(sweep_table.build(sweep, store, [METRIC, "duration_s"]), tmp_path, csv=True)
    assert [file.name for file in files] == ["table.parquet", "table.csv"]
    table = pyarrow.parquet.read_table(files[0])
    assert table.column_names == ["point", *sweep.varied, METRIC, "duration_s", "status", "reason"]
    assert table["point"].to_pylist() == list(range(12))
    assert table["control.dtc.torque_band_upper_nm"].to_pylist() == [1.5] * 4 + [0.5] * 4 + [1.0] * 4
    assert table["drive.actuation_delay_periods"].to_pylist() == [0, 1] * 6
    assert table[METRIC].to_pylist() == [0, 1, 2, None, *range(4, 12)]
    assert table["duration_s"].null_count == 12
    assert table["status"].to_pylist() == ["ok", "failed", "expect_failed", *["ok"] * 9]
    assert table.schema.metadata[b"sextant.set"] == b"duration_s = 0.5"
    same = pyarrow.csv.read_csv(files[1]).to_pydict()
    assert same["reason"] == table["reason"].to_pylist()
    assert same["control.dtc.comparator_reading"] == table["control.dtc.comparator_reading"].to_pylist()


@pytest.mark.parametrize(
    ("values", "kind", "expected"),
    [
        ([1, 2], "int64", [1, 2]),
        ([1, 2.5], "double", [1.0, 2.5]),
        ([True, False], "bool", [True, False]),
        ([True, 1], "string", ["true", "1"]),
        ([[[0, 5]], [[0, 6.5]]], "string", ["[[0, 5]]", "[[0, 6.5]]"]),
        (["a", "b"], "string", ["a", "b"]),
        ([2**70, 1], "double", [2.0**70, 1.0]),
    ],
)
def test_columns_of_keys(values: list, kind: str, expected: list) -> None:
    column = sweep_table.column(values)
    assert str(column.type) == kind
    assert column.to_pylist() == expected


def test_a_heat_map_shows_the_mean_of_each_cell(tmp_path: Path) -> None:
    sweep, store = stored(tmp_path, GRID)
    figure = sweep_plot.draw(sweep, store, METRIC, UNITS)
    cells = figure.axes[0].images[0].get_array()
    # Columns are the bands in rising order: points 4…7, 8…11, 0…3; rows the readings. The delay is averaged over.
    expected = [[4.5, 8.5, 0.0], [6.5, 10.5, 2.0]]
    np.testing.assert_allclose(cells.filled(np.nan), expected)
    texts = [text.get_text() for text in figure.axes[0].texts]
    assert texts == ["4.5", "8.5", "0", "6.5", "10.5", "2*"]
    assert "mean over drive.actuation_delay_periods" in figure.get_suptitle()
    assert [label.get_text() for label in figure.axes[0].get_yticklabels()] == ["relay", "memoryless"]
    plt.close(figure)


def test_cells_have_no_exponents_where_a_number_is_as_short() -> None:
    _, axes = plt.subplots(figsize=(6, 3))
    cells = np.array([[10151.0, 9990.0, 0.08603]])
    axes.imshow(cells, aspect="auto")
    sweep_plot.write_cells(axes, cells, np.zeros(cells.shape, dtype=bool))
    assert [text.get_text() for text in axes.texts] == ["10150", "9990", "0.08603"]
    plt.close(axes.figure)


def test_one_key_of_a_grid_is_a_line(tmp_path: Path) -> None:
    sweep, store = stored(tmp_path, GRID + 'keys = ["control.dtc.torque_band_upper_nm"]\n')
    figure = sweep_plot.draw(sweep, store, METRIC, UNITS)
    line = figure.axes[0].lines[0]
    np.testing.assert_allclose(line.get_xdata(), [0.5, 1.0, 1.5])
    np.testing.assert_allclose(line.get_ydata(), [5.5, 9.5, 1.0])
    assert figure.axes[0].get_ylabel() == "torque_ripple_pp_nm [N·m]"
    counts = [len(points.get_offsets()) for points in figure.axes[0].collections]
    assert counts == [9, 1, 2]  # good, with a missed expectation, failed or without a value
    plt.close(figure)


def test_two_keys_of_a_random_sample_are_coloured_points(tmp_path: Path) -> None:
    sweep, store = stored(tmp_path, RANDOM)
    figure = sweep_plot.draw(sweep, store, METRIC, UNITS)
    axes = figure.axes[0]
    np.testing.assert_allclose(axes.collections[0].get_array(), [0, 2, 4, 5, 6, 7])
    assert (axes.get_xscale(), axes.get_yscale()) == ("linear", "log")
    assert axes.get_ylabel() == "machine.r_r_ohm [ohm]"
    assert "seed 3" in figure.get_suptitle()
    plt.close(figure)


def test_more_keys_of_a_random_sample_have_a_panel_each(tmp_path: Path) -> None:
    text = RANDOM.replace("[plot]", 'plant.integrator = ["cvode", "fixed"]\n[plot]')
    sweep, store = stored(tmp_path, text)
    figure = sweep_plot.draw(sweep, store, METRIC, UNITS)
    shown = [axes.get_xlabel() for axes in figure.axes if axes.get_visible()]
    assert shown == ["machine.r_s_ohm", "machine.r_r_ohm [ohm]", "plant.integrator"]
    plt.close(figure)


@pytest.mark.parametrize("text", [GRID, RANDOM])
def test_pictures_are_written(tmp_path: Path, text: str) -> None:
    sweep, store = stored(tmp_path, text)
    (picture,) = sweep_plot.write(sweep, store, tmp_path, UNITS)
    assert picture == tmp_path / f"{METRIC}.png"
    assert picture.read_bytes().startswith(b"\x89PNG\r\n\x1a\n")


def test_a_sweep_without_a_single_value_is_drawn(tmp_path: Path) -> None:
    sweep, store = stored(tmp_path, GRID)
    for record in store.records.values():
        record["status"] = "failed"
    figure = sweep_plot.draw(sweep, store, METRIC, UNITS)
    figure.savefig(tmp_path / "empty.png")
    assert {text.get_text() for text in figure.axes[0].texts} == {"×"}
    plt.close(figure)


BANDS = """scenario = "scenario.toml"
[grid]
control.dtc.torque_band_upper_nm = { from = 0.1, to = 1.23456, count = 12 }
control.dtc.flux_band_wb = { from = 0.001, to = 0.0123, count = 10 }
[plot]
metrics = ["torque_ripple_pp_nm"]
"""
NAMES = """scenario = "scenario.toml"
[grid]
control.flux_estimator = ["hybrid", "voltage_model", "compensated_voltage_model", "sensorless_observer", "observer"]
control.controller = ["dtc", "duty_ratio", "predictive", "pwm_dtc", "feedback_linearisation", "foc", "deadbeat"]
[plot]
metrics = ["torque_ripple_pp_nm"]
"""
SAMPLE = """scenario = "scenario.toml"
[random]
samples = 12
seed = 3
[random.ranges]
control.flux_estimator = ["hybrid", "voltage_model", "compensated_voltage_model", "sensorless_observer", "observer"]
control.controller = ["dtc", "duty_ratio", "predictive", "pwm_dtc", "feedback_linearisation", "foc", "deadbeat"]
[plot]
metrics = ["torque_ripple_pp_nm"]
"""
FINE = BANDS.replace("count = 12", "count = 40").replace("count = 10", "count = 3").replace("1.23456", "123456.0")


def outline(label: Text, renderer: RendererAgg) -> np.ndarray:
    """The corners of a text, turned as it is."""
    turned = label.get_rotation()
    label.set_rotation(0)
    box = label.get_window_extent(renderer)
    label.set_rotation(turned)
    x, y = label.get_transform().transform(label.get_position())
    corners = np.array([[box.x0, box.y0], [box.x1, box.y0], [box.x1, box.y1], [box.x0, box.y1]]) - (x, y)
    angle = math.radians(turned)
    return corners @ np.array([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]]) + (x, y)


def are_apart(one: np.ndarray, other: np.ndarray) -> bool:
    """Two convex outlines, by a line between them along one of their sides."""
    for corners in (one, other):
        for side in np.roll(corners, -1, axis=0) - corners:
            across = np.array([-side[1], side[0]])
            a, b = one @ across, other @ across
            if a.max() <= b.min() or b.max() <= a.min():
                return True
    return False


@pytest.mark.parametrize("text", [GRID, BANDS, NAMES, SAMPLE, FINE], ids=["few", "bands", "names", "sample", "fine"])
@pytest.mark.parametrize("scale", [1.0, 1.2345e-3, -98765.4])
def test_texts_do_not_run_into_each_other(tmp_path: Path, text: str, scale: float) -> None:
    sweep, store = stored(tmp_path, text)
    for point, record in store.records.items():
        record["metrics"][METRIC] = scale * math.exp(point / 40)
    figure = sweep_plot.draw(sweep, store, METRIC, UNITS)
    figure.canvas.draw()
    renderer, axes = figure.canvas.get_renderer(), figure.axes[0]
    for texts in (axes.get_xticklabels(), axes.get_yticklabels(), axes.texts):
        outlines = [outline(label, renderer) for label in texts if label.get_text()]
        assert all(itertools.starmap(are_apart, itertools.combinations(outlines, 2)))
    plt.close(figure)


COUPLED = """scenario = "scenario.toml"
[grid]
control.controller = ["dtc", "foc"]
[[coupled]]
machine.r_s_ohm = [0.4, 0.5, 0.5]
machine.r_r_ohm = [3, 2, 1]
[plot]
metrics = ["torque_ripple_pp_nm"]
"""


def test_coupled_keys_are_one_axis_of_a_map(tmp_path: Path) -> None:
    """Of the two the resistance of the rotor tells the rows apart."""
    sweep, store = stored(tmp_path, COUPLED)
    figure = sweep_plot.draw(sweep, store, METRIC, UNITS)
    axes = figure.axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("control.controller", "machine.r_r_ohm [ohm]")
    assert [text.get_text() for text in axes.texts] == ["2*", "5", "×", "4", "0", "×"]
    assert "mean over" not in figure.get_suptitle()
    plt.close(figure)


def test_a_key_that_does_not_tell_its_rows_apart_is_averaged_over_the_others(tmp_path: Path) -> None:
    sweep, store = stored(tmp_path, COUPLED + 'keys = ["control.controller", "machine.r_s_ohm"]\n')
    figure = sweep_plot.draw(sweep, store, METRIC, UNITS)
    assert [text.get_text() for text in figure.axes[0].texts] == ["0", "×", "2*", "4.5"]
    assert figure.get_suptitle().endswith("\nmean over machine.r_r_ohm")
    plt.close(figure)


def test_two_keys_that_move_together_are_coloured_points(tmp_path: Path) -> None:
    sweep, store = stored(tmp_path, COUPLED + 'keys = ["machine.r_s_ohm", "machine.r_r_ohm"]\n')
    figure = sweep_plot.draw(sweep, store, METRIC, UNITS)
    assert not figure.axes[0].images
    drawn = figure.axes[0].collections[0].get_offsets()
    np.testing.assert_allclose(drawn, [(0.4, 3), (0.5, 1), (0.5, 2), (0.5, 1)])
    plt.close(figure)


def test_the_points_of_a_list_are_coloured_points(tmp_path: Path) -> None:
    (tmp_path / "points.csv").write_text("a.b,a.c,a.d\n1,2,5\n3,4,5\n5,1,5\n7,3,5\n9,9,5\n")
    sweep, store = stored(tmp_path, 'scenario = "scenario.toml"\npoints = "points.csv"\n[plot]\nmetrics = ["x"]\n')
    figure = sweep_plot.draw(sweep, store, METRIC, UNITS)
    np.testing.assert_allclose(figure.axes[0].collections[0].get_offsets(), [(1, 2), (5, 1), (9, 9)])
    assert "list of 5 points" in figure.get_suptitle()
    plt.close(figure)
