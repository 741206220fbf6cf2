"""Files of sweeps: the points they make, and what a bad one is told."""

import math
import re
from pathlib import Path

import numpy as np
import pytest
from sextant_py import sweep_file
from sextant_py.errors import UserError
from sextant_py.paths import ROOT

GRID = """scenario = "scenario.toml"
[grid]
"control.dtc.torque_band_upper_nm" = [0.5, 0.918]
machine.r_r_ohm = { from = 0.4, to = 1.6, count = 3, scale = "log" }
"""
RANDOM = """scenario = "scenario.toml"
[set]
duration_s = 0.5
[random]
samples = 200
seed = 7
[random.ranges]
machine.r_s_ohm = { from = 0.2, to = 0.6 }
machine.x_m_ohm = { from = 1.0, to = 100.0, scale = "log" }
plant.integrator = ["cvode", "fixed"]
"""

PAGE = (ROOT / "docs" / "sweeps.md").read_text(encoding="utf-8")
TOML_OF_PAGE = re.findall(r"^```toml\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)
(CSV_OF_PAGE,) = re.findall(r"^```csv\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)


def parse(directory: Path, text: str) -> sweep_file.Sweep:
    (directory / "scenario.toml").touch()
    file = directory / "sweep.toml"
    file.write_text(text, encoding="utf-8")
    return sweep_file.load(file)


def test_grid_is_every_combination(tmp_path: Path) -> None:
    sweep = parse(tmp_path, GRID)
    assert sweep.varied == ["control.dtc.torque_band_upper_nm", "machine.r_r_ohm"]
    bands = [point["control.dtc.torque_band_upper_nm"] for point in sweep.points]
    assert bands == [0.5, 0.5, 0.5, 0.918, 0.918, 0.918]
    resistances = [point["machine.r_r_ohm"] for point in sweep.points]
    assert resistances[:3] == resistances[3:]
    assert (resistances[0], resistances[2]) == (0.4, 1.6)
    assert resistances[1] == pytest.approx(0.8)  # the geometric mean
    assert sweep.log_keys == {"machine.r_r_ohm"}
    assert (sweep.name, sweep.seed, sweep.kind) == ("sweep", None, "grid")


def test_linear_ranges_have_equal_steps(tmp_path: Path) -> None:
    sweep = parse(tmp_path, 'scenario = "scenario.toml"\n[grid]\na.b = { from = 1, to = 3, count = 5 }\n')
    assert [point["a.b"] for point in sweep.points] == pytest.approx([1, 1.5, 2, 2.5, 3])


def test_random_points_lie_in_their_ranges(tmp_path: Path) -> None:
    sweep = parse(tmp_path, RANDOM)
    assert len(sweep.points) == 200
    assert all(0.2 <= point["machine.r_s_ohm"] <= 0.6 for point in sweep.points)
    assert {point["plant.integrator"] for point in sweep.points} == {"cvode", "fixed"}
    # Uniform in its logarithm: half of them are below 10, give or take four standard deviations.
    below = sum(point["machine.x_m_ohm"] < 10 for point in sweep.points)
    assert abs(below - 100) < 4 * math.sqrt(200 * 0.25)
    assert sweep.fixed == {"duration_s": 0.5}


def test_a_seed_gives_the_same_points_and_more_samples_only_add(tmp_path: Path) -> None:
    sweep = parse(tmp_path, RANDOM)
    longer = parse(tmp_path, RANDOM.replace("samples = 200", "samples = 300"))
    assert longer.points[:200] == sweep.points
    assert parse(tmp_path, RANDOM.replace("seed = 7", "seed = 8")).points != sweep.points


def with_method(method: str, samples: int) -> str:
    return edited(RANDOM, "samples = 200", f'samples = {samples}\nmethod = "{method}"')


def test_a_latin_hypercube_has_one_point_in_each_share_of_a_range(tmp_path: Path) -> None:
    sweep = parse(tmp_path, with_method("latin_hypercube", 50))
    linear = sorted(int(50 * (point["machine.r_s_ohm"] - 0.2) / 0.4) for point in sweep.points)
    logarithmic = sorted(int(50 * math.log10(point["machine.x_m_ohm"]) / 2) for point in sweep.points)
    assert linear == logarithmic == list(range(50))
    assert [point["plant.integrator"] for point in sweep.points].count("cvode") == 25
    assert sweep.kind == "Latin hypercube sample"


def test_a_sobol_sample_is_even_in_two_dimensions_and_more_samples_only_add(tmp_path: Path) -> None:
    """Of 64 points of a (t, 2, 2)-net of base 2, each of 8 × 8 equal cells has exactly one."""
    text = with_method("sobol", 64).replace('plant.integrator = ["cvode", "fixed"]\n', "")
    points = parse(tmp_path, text).points
    cells = {
        (int(8 * (point["machine.r_s_ohm"] - 0.2) / 0.4), int(4 * math.log10(point["machine.x_m_ohm"])))
        for point in points
    }
    assert len(cells) == 64
    assert parse(tmp_path, edited(text, "samples = 64", "samples = 128")).points[:64] == points
    assert parse(tmp_path, edited(text, "seed = 7", "seed = 8")).points != points


def test_values_as_toml_writes_them() -> None:
    values = [True, 3, 0.1, 1e-7, 'a "b"', [[0, 5.0], [0.5, 10]], Path("of/my machine.toml")]
    assert [sweep_file.toml_value(value) for value in values] == [
        "true",
        "3",
        "0.1",
        "1e-07",
        '"a \\"b\\""',
        "[[0, 5.0], [0.5, 10]]",
        '"of/my machine.toml"',
    ]


def test_numbers_of_numpy_are_numbers() -> None:
    assert sweep_file.toml_value((np.float64(0.25), np.int64(3), np.bool_(True))) == "[0.25, 3, true]"


def test_lines_of_keys() -> None:
    text = GRID + '[plot] # what is drawn\nmetrics = ["x"]\n[random.ranges]\n"a" . b = 1\n'
    keys = ["scenario", "grid", "grid.control.dtc.torque_band_upper_nm", "plot.metrics", "random.ranges.a.b"]
    assert [sweep_file.line_of(text, key) for key in keys] == [1, 2, 3, 6, 8]
    assert sweep_file.line_of(text, "grid.machine.r_r_ohm.scale") == 4
    assert sweep_file.line_of(text, "nothing") is None


def edited(text: str, old: str, new: str) -> str:
    assert old in text
    return text.replace(old, new)


BAD = [
    ("[grid", "", "not valid TOML"),
    ('scenario = "scenario.toml"', "", "scenario: this key is missing"),
    ("scenario.toml", "none.toml", ":1: scenario: the scenario file"),
    ("[grid]", "[grit]", ":2: grit: unknown key; known here are coupled, description, grid,"),
    ("[grid]", "[random]\nseed = 1\n[grid]", "or [[coupled]] alone, got [grid] and [random]."),
    ("[0.5, 0.918]", "[]", ":3: grid.control.dtc.torque_band_upper_nm: expected at least one value"),
    ("[0.5, 0.918]", "[0.5, 0.5]", ":3: grid.control.dtc.torque_band_upper_nm: a value is there twice"),
    ("[0.5, 0.918]", "[0.5, nan]", "a list of them, got nan."),
    ("[0.5, 0.918]", f"[0.5, 1{'0' * 400}]", "a list of them, got 1000"),
    ("[0.5, 0.918]", "0.5", "expected a list of values or { from, to, count, scale }, got 0.5."),
    ("from = 0.4", "from = 1.7", ":4: grid.machine.r_r_ohm: expected from < to, got 1.7 and 1.6."),
    ("from = 0.4", "from = inf", ':4: grid.machine.r_r_ohm: expected a finite number for "from", got inf.'),
    ("from = 0.4, ", "", ':4: grid.machine.r_r_ohm: "from" is missing.'),
    ("from = 0.4", "from = 0", 'expected "from" above 0 on a log scale, got 0.'),
    ("count = 3", "count = 1", 'expected "count", a whole number from 2 to 1000000, got 1.'),
    ("count = 3", "count = 600000", "more than 1000000 points"),
    (', scale = "log"', ', scale = "square"', 'scale: expected "linear" or "log", got "square".'),
    (', scale = "log"', ", step = 2", ":4: grid.machine.r_r_ohm.step: unknown key"),
    ("[grid]", "[set]\nmachine.r_r_ohm = 1\n[grid]", ":3: set.machine.r_r_ohm: this key varies elsewhere"),
    ("[grid]", "time_limit_s = 0\n[grid]", ":2: time_limit_s: expected a number above 0, got 0."),
    ("[grid]", 'name = "../up"\n[grid]', ":2: name: expected letters, digits"),
    ("[grid]", '[plot]\nkeys = ["a"]\n[grid]', ':3: plot.keys: "a" does not vary in this sweep;'),
    ("[grid]", '[plot]\nmetrics = "a"\n[grid]', ":3: plot.metrics: expected a list of names"),
    ("[grid]", "[grid]\ncontrol.dtc.torque_band_upper_nm = [1]", "this key is there twice, with quotes and without."),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "words"), BAD)
def test_a_bad_file_is_refused_with_line_and_key(tmp_path: Path, old: str, new: str, words: str) -> None:
    with pytest.raises(UserError) as refusal:
        parse(tmp_path, edited(GRID, old, new))
    assert str(refusal.value).startswith(str(tmp_path / "sweep.toml"))
    assert words in str(refusal.value)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("seed = 7\n", "", ':4: random: "seed" is missing'),
        ("seed = 7", 'seed = 7\nmethod = "halton"', ":7: random.method: expected random, sobol, latin_hypercube, got"),
        ("seed = 7", 'seed = 7\nmethod = "sobol"', ":5: random.samples: a Sobol' sample needs a power of two"),
        ("seed = 7", "seed = -1", ":6: random.seed: expected a seed, a whole number from 0"),
        ("samples = 200", "samples = 0", ":5: random.samples: expected how many points"),
        ('x_m_ohm = { from = 1.0, to = 100.0, scale = "log" }', "x_m_ohm = { from = 1, to = 2, count = 3 }",
         ":9: random.ranges.machine.x_m_ohm.count: unknown key"),
        ("duration_s = 0.5", "duration_s = { from = 1, to = 2 }", ":3: set.duration_s: expected one value"),
    ],
)  # fmt: skip
def test_a_bad_random_sample_is_refused(tmp_path: Path, old: str, new: str, words: str) -> None:
    with pytest.raises(UserError) as refusal:
        parse(tmp_path, edited(RANDOM, old, new))
    assert words in str(refusal.value)


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="does not exist"):
        sweep_file.load(tmp_path / "none.toml")
    with pytest.raises(UserError, match="cannot be read: Is a directory"):
        sweep_file.load(tmp_path)
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe")
    with pytest.raises(UserError, match="is not UTF-8 text"):
        sweep_file.load(tmp_path / "binary.toml")


@pytest.mark.parametrize("file", sorted((ROOT / "configs" / "sweeps").glob("*.toml")), ids=lambda file: file.name)
def test_the_examples_are_good(file: Path) -> None:
    sweep = sweep_file.load(file)
    assert sweep.name == file.stem
    assert len(sweep.points) > 1
    assert sweep.plot.metrics


def test_the_band_example_is_table_6() -> None:
    sweep = sweep_file.load(ROOT / "configs" / "sweeps" / "hysteresis_band.toml")
    bands = {(p["control.dtc.torque_band_upper_nm"], p["control.dtc.torque_band_lower_nm"]) for p in sweep.points}
    values = (0.918, 0.6885, 0.459)  # 100 %, 75 % and 50 % of the paper's band
    assert bands == {(upper, lower) for upper in values for lower in values}


def test_the_page_shows_files_that_are_good(tmp_path: Path) -> None:
    grid, sample, coupled, listed = TOML_OF_PAGE
    (tmp_path / "scenarios").mkdir()
    (tmp_path / "scenarios" / "reversal.toml").touch()
    (tmp_path / "sweeps").mkdir()
    (tmp_path / "sweeps" / "points.csv").write_text(CSV_OF_PAGE, encoding="utf-8")
    head = grid[: grid.index("[grid]")]
    assert len(parse(tmp_path / "sweeps", grid).points) == 10
    assert len(parse(tmp_path / "sweeps", head + sample).points) == 200
    assert len(parse(tmp_path / "sweeps", head + coupled).points) == 6
    assert [point["control.controller"] for point in parse(tmp_path / "sweeps", listed + head).points] == [
        "dtc", "foc", "foc",
    ]  # fmt: skip


COUPLED = """[[coupled]]
machine.r_s_ohm = [0.4, 0.5, 0.5]
machine."x_m_ohm" = [1, 2, 3]
"""


def test_coupled_keys_are_one_axis_of_a_grid(tmp_path: Path) -> None:
    sweep = parse(tmp_path, GRID + COUPLED)
    assert len(sweep.points) == 18
    rows = [(point["machine.r_s_ohm"], point["machine.x_m_ohm"]) for point in sweep.points]
    assert rows == [(0.4, 1), (0.5, 2), (0.5, 3)] * 6
    assert sweep.kind == "grid"
    alone = parse(tmp_path, 'scenario = "scenario.toml"\n' + COUPLED)
    assert alone.points == [{"machine.r_s_ohm": r_s, "machine.x_m_ohm": x_m} for r_s, x_m in rows[:3]]
    assert alone.varied == ["machine.r_s_ohm", "machine.x_m_ohm"]


def test_coupled_ranges_have_the_same_share(tmp_path: Path) -> None:
    ranges = 'a.b = { from = 1, to = 3, count = 3 }\na.c = { from = 1, to = 100, count = 3, scale = "log" }\n'
    sweep = parse(tmp_path, f'scenario = "scenario.toml"\n[[coupled]]\n{ranges}')
    assert [(point["a.b"], point["a.c"]) for point in sweep.points] == [(1, 1), (2, pytest.approx(10)), (3, 100)]
    assert sweep.log_keys == {"a.c"}


@pytest.mark.parametrize("method", ["random", "sobol", "latin_hypercube"])
def test_coupled_keys_are_one_axis_of_a_sample(tmp_path: Path, method: str) -> None:
    more = 'machine.inertia_kg_m2 = { from = 0, to = 1 }\na.b = { from = 10, to = 30 }\na.c = ["x", "y"]\n'
    sweep = parse(tmp_path, with_method(method, 64) + "[[coupled]]\n" + more)
    for point in sweep.points:
        share = point["machine.inertia_kg_m2"]
        assert point["a.b"] == pytest.approx(10 + 20 * share)
        assert point["a.c"] == ("x" if share < 0.5 else "y")
    correlation = np.corrcoef([[p["machine.inertia_kg_m2"], p["machine.r_s_ohm"]] for p in sweep.points], rowvar=False)
    assert abs(correlation[0, 1]) < 0.5  # the other axes are drawn by themselves


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("[1, 2, 3]", "[1, 2]", ":7: coupled.machine.x_m_ohm: expected as many values as machine.r_s_ohm has, 3,"),
        ("[1, 2, 3]", "[1, 2, 2]", ":6: coupled.machine.r_s_ohm: the same values are there twice, in every key."),
        ('machine."x_m_ohm" = [1, 2, 3]\n', "", ":6: coupled.machine.r_s_ohm: expected two or more keys that move"),
        ("[1, 2, 3]", "[]", ":7: coupled.machine.x_m_ohm: expected at least one value"),
        ("[1, 2, 3]", "3", ":7: coupled.machine.x_m_ohm: expected a list of values or { from, to,"),
        ('"x_m_ohm"', "r_r_ohm", ":7: coupled.machine.r_r_ohm: this key varies elsewhere in this sweep as well."),
        ("[[coupled]]\n", "[coupled]\n[[coupled.rows]]\n", "coupled"),
        ("[[coupled]]", "[set]\nmachine.r_s_ohm = 1\n[[coupled]]", ":6: set.machine.r_s_ohm: this key varies"),
    ],
)  # fmt: skip
def test_bad_coupled_keys_are_refused(tmp_path: Path, old: str, new: str, words: str) -> None:
    with pytest.raises(UserError) as refusal:
        parse(tmp_path, GRID + edited(COUPLED, old, new))
    assert words in str(refusal.value)
    assert "\n" not in str(refusal.value)


LIST = 'scenario = "scenario.toml"\npoints = "points.csv"\n'
POINTS = """\ufeffplant.integrator,"machine.r_s_ohm", drive.period_us, plant.inverter.ideal,machine.name,load.points\r
# the first of them\r
cvode,.4,25,true,"a, b","[[0, 5], [1.5, 6]]"\r
\r
fixed, 5e-1 ,50,False,c d,[]  # the second"""


def listed(directory: Path, points: str, text: str = LIST) -> sweep_file.Sweep:
    (directory / "points.csv").write_text(points, encoding="utf-8", newline="")
    return parse(directory, text)


def test_a_list_has_a_point_in_each_row(tmp_path: Path) -> None:
    sweep = listed(tmp_path, POINTS)
    assert sweep.kind == "list"
    assert [list(point.values()) for point in sweep.points] == [
        ["cvode", 0.4, 25, True, "a, b", [[0, 5], [1.5, 6]]],
        ["fixed", 0.5, 50, False, "c d", []],
    ]
    assert sweep.varied == list(sweep.points[1])
    assert sweep.varied[1] == "machine.r_s_ohm"
    assert isinstance(sweep.points[0]["drive.period_us"], int)


@pytest.mark.parametrize(
    ("points", "words"),
    [
        ("", "has no point: expected a heading of keys and a row for each point."),
        ("a.b,a.c\n", "has no point"),
        ("a.b,a.c\n1\n", ":2: expected 2 values (a.b, a.c), found 1."),
        ("a.b,a.c\n1,\n", ":2: a.c: this cell is empty"),
        ("a.b,a.c\n1,nan\n", ":2: a.c: expected a finite number, got nan."),
        ("a.b,a.c\n1,-inf\n", ":2: a.c: expected a finite number, got -inf."),
        ("a.b,a.c\n1,[1\n", ":2: a.c: expected a list or a text as TOML writes it, got [1."),
        ("a.b,a.b\n1,2\n", ":1: the column a.b occurs twice."),
        ("a.b;a.c\n1;2\n", ":1: semicolons separate the columns: separate them by commas."),
        (",a.b\n1,2\n", ":1: a column has no name"),
        ("a.b\n1\n2\n1\n", ":4: the same point as in line 2: leave one out."),
    ],
)
def test_bad_lists_are_refused(tmp_path: Path, points: str, words: str) -> None:
    with pytest.raises(UserError) as refusal:
        listed(tmp_path, points)
    assert words in str(refusal.value)
    assert str(tmp_path / "points.csv") in str(refusal.value)


def test_a_list_stands_alone(tmp_path: Path) -> None:
    for text, words in (
        (LIST + "[grid]\na.b = [1]\n", "got [grid] and points."),
        (LIST + COUPLED, ":3: coupled: a list of points has every key"),
        (LIST + "[set]\nmachine.r_s_ohm = 1\n", ":4: set.machine.r_s_ohm: this key varies elsewhere"),
        (LIST.replace("points.csv", "none.csv"), "none.csv cannot be read: No such file or directory."),
        (LIST.replace('"points.csv"', "[1]"), ":2: points: expected a text, got [1]."),
        (LIST.replace("points.csv", "."), "cannot be read: Is a directory."),
        ('scenario = "scenario.toml"\n', "alone, got none of them."),
    ):
        with pytest.raises(UserError) as refusal:
            listed(tmp_path, POINTS, text)
        assert words in str(refusal.value)
    (tmp_path / "points.csv").write_bytes(b"a.b\n\xe9\n")
    with pytest.raises(UserError, match=r"points\.csv is not a text file in UTF-8"):
        parse(tmp_path, LIST)
