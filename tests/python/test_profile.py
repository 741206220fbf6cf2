"""Torque profiles: interpolation, and what a bad file is told."""

from pathlib import Path

import pytest
from sextant_py import profile
from sextant_py.errors import UserError
from sextant_py.paths import ROOT


def written(folder: Path, name: str, text: str) -> Path:
    path = folder / name
    path.write_text(text)
    return path


def test_linear_with_a_step(tmp_path: Path) -> None:
    path = written(tmp_path, "p.csv", "# ramp, then a step\ntime_s,torque_nm\n0,0\n\n1,10\n1,-4 # down\n2,-4\n")
    torque = profile.load(path)
    assert torque.duration_s == 2.0
    assert torque.at(0.25) == (2.5, True)
    assert torque.at(0.999)[0] == pytest.approx(9.99)
    assert torque.at(1.0)[0] == -4.0
    assert torque.at(5.0)[0] == -4.0


def test_hold_and_enable_from_toml(tmp_path: Path) -> None:
    text = 'interpolation = "hold"\ntime_s = [0, 1, 2]\ntorque_nm = [1, 2.5, 0]\nenable = [false, true, false]\n'
    torque = profile.load(written(tmp_path, "p.toml", text))
    assert [torque.at(t) for t in (0.0, 0.99, 1.0, 1.99, 2.0)] == [
        (1.0, False),
        (1.0, False),
        (2.5, True),
        (2.5, True),
        (0.0, False),
    ]


def test_the_caller_may_choose_the_interpolation(tmp_path: Path) -> None:
    path = written(tmp_path, "p.csv", "time_s,torque_nm,enable\n0,0,1\n1,10,0\n")
    assert profile.load(path).at(0.5) == (5.0, True)
    assert profile.load(path, "hold").at(0.5) == (0.0, True)


@pytest.mark.parametrize(
    ("text", "line", "complaint"),
    [
        ("time,torque\n0,1\n1,1\n", 1, "heading"),
        ("time_s,torque_nm\n0,abc\n1,0\n", 2, 'torque_nm must be a finite number, not "abc"'),
        ("time_s,torque_nm\n0,nan\n1,0\n", 2, "torque_nm must be a finite number"),
        ("time_s,torque_nm\n0,inf\n1,0\n", 2, "torque_nm must be a finite number"),
        ("time_s,torque_nm\n0,0\n1\n", 3, "expected 2 values"),
        ("time_s,torque_nm\n0,0\n2,0\n1,0\n", 4, "goes back from 2 to 1"),
        ("time_s,torque_nm\n1,0\n2,0\n", 2, "first point"),
        ("time_s,torque_nm,enable\n0,0,maybe\n1,0,1\n", 2, 'enable must be 0 or 1, not "maybe"'),
    ],
)
def test_bad_csv_names_file_and_line(tmp_path: Path, text: str, line: int, complaint: str) -> None:
    path = written(tmp_path, "bad.csv", text)
    with pytest.raises(UserError) as caught:
        profile.load(path)
    assert str(caught.value).startswith(f"{path}:{line}: ")
    assert complaint in str(caught.value)


@pytest.mark.parametrize(
    ("text", "line", "complaint"),
    [
        ("time_s = [0, 1]\ntorque = [0, 1]\n", 2, 'unknown key "torque"'),
        ('interpolation = "cubic"\ntime_s = [0, 1]\ntorque_nm = [0, 1]\n', 1, "interpolation must be"),
        ("time_s = [0, 1]\ntorque_nm = 5\n", 2, "torque_nm must be a list"),
        ("time_s = [0, 1, 2]\ntorque_nm = [0, 1]\n", 1, "one length"),
        ("time_s = [0, 1]\n\ntorque_nm = [0, true]\n", 3, "torque_nm must be a finite number"),
        (f"time_s = [0, 1]\ntorque_nm = [0, 1{'0' * 400}]\n", 2, "torque_nm must be a finite number"),
        ("time_s = [0, 1]\ntorque_nm = [0, 1]\nenable = [1, 0]\n", 3, "true and false"),
    ],
)
def test_bad_toml_names_file_and_line(tmp_path: Path, text: str, line: int, complaint: str) -> None:
    path = written(tmp_path, "bad.toml", text)
    with pytest.raises(UserError) as caught:
        profile.load(path)
    assert str(caught.value).startswith(f"{path}:{line}: ")
    assert complaint in str(caught.value)


@pytest.mark.parametrize(
    ("name", "text", "complaint"),
    [
        ("empty.csv", "", "at least two points"),
        ("one.csv", "time_s,torque_nm\n0,1\n", "at least two points"),
        ("p.txt", "time_s,torque_nm\n0,1\n1,1\n", "must be a .csv or .toml"),
        ("bad.toml", "time_s = [", "is not TOML"),
    ],
)
def test_bad_files(tmp_path: Path, name: str, text: str, complaint: str) -> None:
    with pytest.raises(UserError, match=complaint):
        profile.load(written(tmp_path, name, text))


def test_missing_file(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="No such file"):
        profile.load(tmp_path / "none.csv")


@pytest.mark.parametrize("path", sorted((ROOT / "configs" / "profiles").iterdir()), ids=lambda path: path.name)
def test_shipped_profiles_load_and_end_without_torque(path: Path) -> None:
    torque = profile.load(path)
    assert torque.at(torque.duration_s)[0] == 0.0
