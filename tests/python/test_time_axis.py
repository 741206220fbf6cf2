"""The time of a trace's rows: a run with a torque step against the same without it, as frames, files and pictures."""

from collections.abc import Iterator
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas
import pytest
import sextant
from asammdf import MDF
from matplotlib.figure import Figure
from programs import program
from sextant_py import convert
from sextant_py.paths import ROOT
from sextant_py.plots import html, layouts, overview, panels, png, series, sheets

SCENARIO = ROOT / "configs" / "scenarios" / "constant_torque.toml"
PERIOD_S, END_S = 100e-6, 0.13
BEFORE_NM, AFTER_NM = 10.0, 20.0
# One control period, 1 ms, and an odd interval [us]; the step on the grid of the rows of 1 ms, and off every grid [s].
CASES = [("sampled", 100, 0.1), ("sampled", 1000, 0.1), ("sampled", 700, 0.10037)]
CASES += [("event_exact", 100, 0.10037), ("event_exact", 1000, 0.1), ("event_exact", 333.3, 0.10037)]
FEW = 37  # points of a picture, so that each stands for several rows
TORQUES = [f"{group}torque_{kind}_nm" for group in ("", "plant/") for kind in ("mean", "min", "max")]
TORQUES += ["plant/torque_nm"]

Pair = tuple[Path, Path, float, float]  # with the step and without it; step and interval [s]


def settings(mode: str, interval_us: float, points: list[list[float]]) -> dict:
    return {
        "mode": mode,
        "duration_s": END_S,
        "drive.period_us": PERIOD_S * 1e6,
        "profile.torque_nm.shape": "steps",
        "profile.torque_nm.points": points,
        "trace.interval_us": interval_us,
        "trace.signals": ["standard", "comparators"],
        "metrics.window_from_s": 0.0,
        "plant.integrator": "fixed",
    }


@pytest.fixture(scope="module", params=CASES, ids=str)
def runs(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Pair]:
    mode, interval_us, step_s = request.param
    folder = tmp_path_factory.mktemp("runs")
    text = SCENARIO.read_text(encoding="utf-8").replace(
        'shape = "constant"\nvalue = 15', 'shape = "steps"\npoints = []'
    )
    scenario = folder / "step.toml"
    text = text.replace('"../machines/', f'"{ROOT}/configs/machines/').split("[expect]")[0]
    scenario.write_text(text, encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SEXTANT_BIN", str(program("sextant-mil").parent))
        for name, after in (("step", AFTER_NM), ("without", BEFORE_NM)):
            points = [[0, BEFORE_NM], [step_s, after]]
            run = sextant.run(scenario, settings(mode, interval_us, points), out=folder / name)
            assert run.verdict == "nothing_expected", run.said
    yield folder / "step" / "trace.h5", folder / "without" / "trace.h5", step_s, interval_us * 1e-6


def differing(one: pandas.DataFrame, other: pandas.DataFrame, columns: list[str]) -> np.ndarray:
    """Times of the rows that differ in one of the columns. [s]"""
    np.testing.assert_array_equal(one.index, other.index)
    return np.array(one.index[(one[columns] != other[columns]).any(axis=1)])


def test_no_row_before_the_command_has_torque_of_after_it(runs: Pair) -> None:
    step, without, step_s, interval_s = runs
    one, other = sextant.read(step), sextant.read(without)
    commanded, responded = (differing(one, other, names) for names in (["torque_reference_nm"], TORQUES))
    rounding = 1e-12
    assert step_s - rounding <= commanded[0] <= step_s + max(interval_s, PERIOD_S) + rounding
    assert commanded[0] <= responded[0]
    assert step_s < responded[0] <= step_s + interval_s + 3 * PERIOD_S
    # What the file has itself, without the index.
    assert one["t_ns"].loc[responded[0]] > round(step_s * 1e9)
    np.testing.assert_allclose(one.index, one["t_ns"] * 1e-9, rtol=0, atol=1e-12)


def drawn(figure: Figure) -> list[np.ndarray]:
    """The corners of all lines and bands of a picture."""
    found = []
    for axes in figure.axes:
        found += [np.asarray(line.get_xydata(), float) for line in axes.lines]
        found += [path.vertices for band in axes.collections for path in band.get_paths()]
    return found


def same_until(step_s: float, one: list[np.ndarray], other: list[np.ndarray]) -> bool:
    """Whether two pictures differ; what they have up to the step is the same."""
    assert len(one) == len(other) > 0
    for a, b in zip(one, other, strict=True):
        before = [points[points[:, 0] <= step_s + 1e-9] for points in (a, b)]
        np.testing.assert_array_equal(before[0], before[1])
        assert len(before[0]) > 3
    return all(np.array_equal(a, b, equal_nan=True) for a, b in zip(one, other, strict=True))


@pytest.fixture
def figures(monkeypatch: pytest.MonkeyPatch) -> list:
    """What is drawn in the test, with few points, instead of files."""
    kept: list = []
    for module, name in ((sheets, "MAX_POINTS"), (png, "MOST_POINTS")):
        monkeypatch.setattr(module, name, FEW)
    monkeypatch.setattr(html, "MOST_POINTS", FEW)
    for module in (png, html):
        monkeypatch.setattr(module, "save", lambda figure, *_: kept.append(figure))
    return kept


WANTED = ["torque", "plant/torque", "sector", "control/torque_comparator"]


def draw(kind: str, file: Path) -> None:
    found = series.load([file], None, None)
    if kind == "overview":
        png.draw(overview.arrange(found[0]), "", file)
    elif kind == "figure":
        layouts.draw(found, "9", file)
    else:
        (png if kind == "panels" else html).draw(panels.arrange(found, WANTED), "", file)


@pytest.mark.parametrize("kind", ["overview", "figure", "panels", "page"])
def test_no_picture_draws_a_response_before_its_command(runs: Pair, figures: list, kind: str) -> None:
    for file in runs[:2]:
        draw(kind, file)
    plt.close("all")
    if kind == "page":
        # Steps are drawn by some of their rows, each at its own time.
        with_steps, without = ([line for line in page.data if line.line.shape != "hv"] for page in figures)
        steps = [line for line in figures[0].data if line.line.shape == "hv"]
        rows = sextant.read(runs[1])
        for line, name in zip(steps, WANTED[2:], strict=True):
            before = np.asarray(line.x) <= runs[2] + 1e-9
            places = np.searchsorted(rows.index, np.asarray(line.x)[before] - 1e-9)
            np.testing.assert_array_equal(np.asarray(line.customdata)[before], rows[name].iloc[places])
        one, other = ([np.column_stack((line.x, line.y)) for line in lines] for lines in (with_steps, without))
    else:
        one, other = map(drawn, figures)
    assert not same_until(runs[2], one, other)


@pytest.mark.parametrize("runs", [CASES[1]], indirect=True)
@pytest.mark.parametrize("suffix", [".h5", ".csv", ".parquet", ".mcap", ".mf4"])
def test_every_format_keeps_the_time(runs: Pair, tmp_path: Path, suffix: str) -> None:
    copy = tmp_path / f"copy{suffix}"
    assert convert.main([str(runs[0]), str(copy)]) == 0
    one, other = sextant.read(runs[0]), sextant.read(copy)
    np.testing.assert_allclose(other.index, one.index, rtol=0, atol=1e-9)
    if suffix == ".mf4":
        with MDF(copy) as file:
            np.testing.assert_allclose(file.get("t_ns", group=0).timestamps, one["t_ns"] * 1e-9, rtol=0, atol=1e-9)
