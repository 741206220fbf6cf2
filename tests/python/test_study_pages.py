"""What the pages of the studies are made with."""

from pathlib import Path

import pytest
from sextant_py.errors import UserError
from studies.page import filled
from studies.picture import picture


def template(folder: Path, text: str) -> Path:
    file = folder / "page.md"
    file.write_text(text, encoding="utf-8")
    return file


def test_fields_take_the_place_of_their_names(tmp_path: Path) -> None:
    page = template(tmp_path, "{a} of {b_1}; {a}, $x^{2 y}$\n")
    assert filled(page, {"a": 3, "b_1": "{a} µs", "c": "unused"}) == "3 of {a} µs; 3, $x^{2 y}$\n"


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
