"""One file of other origin gets one answer, whichever program of Sextant reads it: recordings, profiles, points of a
sweep, and the tables of sextant-mil."""

import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from programs import overrides, program
from sextant_py import profile, signal_file, sweep_points
from sextant_py.errors import UserError
from sextant_py.paths import ROOT

SCENARIO = ROOT / "configs" / "scenarios" / "constant_torque.toml"


def by_mil(path: Path) -> str:
    """What sextant-mil says of a table of the torque; nothing where it takes it."""
    settings = ["profile.torque_nm.shape=table", f"profile.torque_nm.file={path}"]
    command = [program("sextant-mil"), SCENARIO, "--print-config", *overrides(settings)]
    done = subprocess.run(command, capture_output=True, timeout=60)
    assert (done.returncode == 0) is (done.stderr == b""), done.stderr
    return done.stderr.decode()


def refusal(read: Callable[[Path], object]) -> Callable[[Path], str]:
    def says(path: Path) -> str:
        try:
            read(path)
        except UserError as error:
            return str(error)
        return ""

    return says


# Each with the heading of its files.
READERS: dict[str, tuple[str, Callable[[Path], str]]] = {
    "recording": ("t_s,torque_nm", refusal(lambda path: signal_file.load(path))),
    "profile": ("time_s,torque_nm", refusal(profile.load)),
    "sweep": ("drive.period_us,plant.u_dc_v", refusal(sweep_points.load)),
    "mil": ("time_s,value", by_mil),
}
OVER_TIME = [name for name in READERS if name != "sweep"]


def said(tmp_path: Path, reader: str, text: bytes) -> str:
    """What a reader says of a file in which HEAD stands for its heading; one line."""
    heading, says = READERS[reader]
    path = tmp_path / "a.csv"
    path.write_bytes(text.replace(b"HEAD", heading.encode()))
    answer = says(path)
    assert answer.rstrip("\n").count("\n") == 0
    assert answer.rstrip("\n").isprintable(), "a byte of the file reaches the terminal"
    return answer.replace(str(path), "FILE")


@pytest.mark.parametrize("reader", READERS)
@pytest.mark.parametrize(
    ("text", "line"),
    [
        (b"HEAD\x00\n0,1\n1,2\n", 1),
        (b"x\x00,HEAD\n0,1\n1,2\n", 1),
        (b"# by\n\nHEAD\n0,1\n1,2\x00\n", 5),
        (b"HEAD\n0,1\n\x00\n1,2\n", 3),
        (b"HEAD\n0,1\n1,\x1b[31m2\n", 3),
        (b"HEAD\x7f\n0,1\n1,2\n", 1),
        (b"HEAD\r0,1\r1,2\x08\r", 3),
        ("HEAD\n0,1\n1,2\n".encode("utf-16-le"), 1),
    ],
    ids=["heading", "first name", "cell", "line of its own", "escape", "delete", "line ends CR", "UTF-16 without mark"],
)
def test_a_byte_that_is_no_text_is_named_by_its_line(tmp_path: Path, reader: str, text: bytes, line: int) -> None:
    if b"\x00H\x00" in text:
        heading = READERS[reader][0]
        text = text.decode("utf-16-le").replace("HEAD", heading).encode("utf-16-le")
    assert f"FILE:{line}: the byte 0x" in said(tmp_path, reader, text)


@pytest.mark.parametrize("reader", READERS)
@pytest.mark.parametrize("cell", ["1e400", "-1e400", "1" + "0" * 400])
def test_a_number_beyond_the_range_is_no_infinity(tmp_path: Path, reader: str, cell: str) -> None:
    answer = said(tmp_path, reader, f"HEAD\n0,1\n1,{cell}\n2,3\n".encode())
    assert "finite number" in answer
    assert cell[:5] in answer
    assert answer.startswith(("FILE:3: ", "FILE, row 2 of telemetry: ")) or ": FILE:3: " in answer


@pytest.mark.parametrize("reader", READERS)
@pytest.mark.parametrize("cell", ["+1.5", "1.5e+00", "-.5", "5.", "1E1"])
def test_numbers_as_other_programs_write_them_are_taken(tmp_path: Path, reader: str, cell: str) -> None:
    assert said(tmp_path, reader, f"HEAD\n0,1\n1,{cell}\n".encode()) == ""


@pytest.mark.parametrize("reader", OVER_TIME)
@pytest.mark.parametrize("times", [(0, 1, 0.5), (0, -1, 1), (0, 1, 2, 0, 1, 2)])
def test_time_never_goes_back(tmp_path: Path, reader: str, times: tuple[float, ...]) -> None:
    text = "HEAD\n" + "".join(f"{t},1\n" for t in times)
    back = next(k for k in range(1, len(times)) if times[k] < times[k - 1])
    answer = said(tmp_path, reader, text.encode())
    assert f"FILE:{back + 2}: " in answer or f"FILE, row {back + 1} of telemetry: " in answer
    assert "goes back" in answer


@pytest.mark.parametrize("reader", OVER_TIME)
def test_two_rows_of_one_time_are_a_step(tmp_path: Path, reader: str) -> None:
    assert said(tmp_path, reader, b"HEAD\n0,1\n1,1\n1,2\n2,2\n") == ""


@pytest.mark.parametrize("reader", OVER_TIME)
@pytest.mark.parametrize("time", [0, 5])
def test_time_that_stands_still_is_no_axis(tmp_path: Path, reader: str, time: int) -> None:
    answer = said(tmp_path, reader, f"HEAD\n{time},1\n{time},2\n{time},3\n".encode())
    assert ("stands still" if time == 0 or reader == "recording" else "first") in answer


def test_infinity_that_a_file_says_stays(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("t_s,x\n0,inf\n1,-Inf\n2,1\n")
    assert signal_file.load(tmp_path / "a.csv").values["x"].tolist() == [np.inf, -np.inf, 1]
