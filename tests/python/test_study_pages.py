"""What the pages of the studies are made with."""

import math
from pathlib import Path

import pytest
from sextant_py.errors import UserError
from studies.command import chosen
from studies.page import filled, number
from studies.picture import picture
from studies.published import mean_and_due, published


def template(folder: Path, text: str) -> Path:
    file = folder / "page.md"
    file.write_text(text, encoding="utf-8")
    return file


def test_fields_take_the_place_of_their_names(tmp_path: Path) -> None:
    page = template(tmp_path, "{a} of {b_1}; {a}, $x^{2 y}$\n")
    assert filled(page, {"a": 3, "b_1": "{a} µs", "c": "unused"}) == "3 of {a} µs; 3, $x^{2 y}$\n"


def test_texts_of_numbers(tmp_path: Path) -> None:
    assert number(-0.459, ".2f") == "−0.46"
    assert number(0.459, "+.2f") == "+0.46"
    assert number(39730, "k2") == "39.73"
    assert number(math.nan, ".2f") == "–"
    page = template(tmp_path, "{a/1.5_x:.1f} and {a/1.5_x:k3}\n{a}\n")
    assert filled(page, {"a/1.5_x": 2.5, "a": "| x |"}) == "2.5 and 0.003\n| x |\n"


def test_an_unknown_name_is_named_with_the_known_ones() -> None:
    assert chosen("--methods", None, ["dtc", "foc"]) == ["dtc", "foc"]
    assert chosen("--methods", ["foc"], ["dtc", "foc"]) == ["foc"]
    with pytest.raises(UserError, match='--methods: there is no "pid"; they are dtc, foc'):
        chosen("--methods", ["foc", "pid"], ["dtc", "foc"])


@pytest.mark.parametrize(
    ("speed", "torque", "due"), [(50, 60, 60), (50, 120, 100), (-50, 120, 80), (50, -120, -80), (0, 90, 90)]
)
def test_torque_is_due_as_far_as_it_is_published_in_its_direction(speed: float, torque: float, due: float) -> None:
    metrics = {"torque_motoring_nm": 100.0, "torque_regenerating_nm": 80.0, "torque_bias_nm": -0.5}
    assert mean_and_due(metrics, speed, torque) == (torque - 0.5, due)
    off = metrics | {"torque_motoring_nm": None, "torque_regenerating_nm": None}
    assert published(off, speed, torque) is None and mean_and_due(off, speed, torque)[1] == 0


def test_a_name_that_nothing_makes_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"page\.md names \{speed\}"):
        filled(template(tmp_path, "at {speed} rad/s"), {"torque": 1})


def test_a_picture_is_written_at_the_end_and_closed(tmp_path: Path) -> None:
    import matplotlib.pyplot as plt

    before, grid = plt.get_fignums(), plt.rcParams["axes.grid"]
    with picture(tmp_path / "one.png", 2, 3, (3, 2), {"axes.grid": not grid}) as (_, panels):
        assert panels.shape == (2, 3) and plt.rcParams["axes.grid"] != grid
    assert (tmp_path / "one.png").read_bytes().startswith(b"\x89PNG")
    with pytest.raises(ValueError, match="drawn"), picture(tmp_path / "two.png", 1, 1, (1, 1)):
        raise ValueError("drawn")
    assert not (tmp_path / "two.png").exists()
    assert (plt.get_fignums(), plt.rcParams["axes.grid"]) == (before, grid)
