"""Wrong frames of `sextant.Vcu` before the drive itself, in virtual time: each is refused for its own reason, by the
rules of docs/can.md, and the drive trips where these say so."""

import re
import subprocess
from collections.abc import Callable
from pathlib import Path

import can
import pytest
import sextant
from programs import program
from sextant_py.paths import ROOT
from sextant_py.wrong_frames import WRONG

START_UP = 2  # frames until the check of the sequence has three
TORQUE_NM = 20.0
Report = dict[str, int | str]


def played(path: Path) -> Report:
    """What sextant-ecu reports of the log: commands accepted, refused and why, and the first fault ("" for none)."""
    command = [program("sextant-ecu"), ROOT / "configs" / "ecu.toml", "--virtual-time", path]
    said = subprocess.run(command, capture_output=True, text=True, timeout=600).stdout
    accepted, rejected = re.search(r"^commands (\d+) accepted, (\d+) rejected$", said, re.MULTILINE).groups()
    causes = {cause: int(count) for cause, count in re.findall(r"^  (\S.*?) +(\d+)$", said, re.MULTILINE)}
    fault = re.search(r"^left in \w+, \d+ faults(?:, first (\w+))?$", said, re.MULTILINE)[1]
    assert causes.pop("E2E state not valid yet") >= START_UP
    return {"accepted": int(accepted), "rejected": int(rejected), "fault": fault or "", **causes}


@pytest.fixture
def run(tmp_path: Path) -> Callable[[str, int], Report]:
    def run(kind: str, frames: int) -> Report:
        path = tmp_path / "commands.log"
        with sextant.Vcu(log=path, identifier_offset=0) as vcu:
            vcu.run(0.1)
            vcu.demand(TORQUE_NM, enable=True)
            vcu.run(0.5)
            if frames:
                vcu.spoil(kind, frames)
            vcu.run(0.5)
            assert (vcu.missed, vcu.unsent) == (0, 0)
        return played(path)

    return run


@pytest.fixture
def undisturbed(run: Callable[[str, int], Report]) -> Report:
    return run("crc", 0)


CAUSES = {
    "crc": "wrong CRC",
    "data_id": "wrong CRC",
    "repeated": "repeated counter",
    "jumped": "wrong sequence",
    "reserved": "invalid counter",
    "range": "out of range",
    "length": "wrong length",
}


def test_right_frames_are_accepted(undisturbed: Report) -> None:
    """110 in 1.1 s and ten disables at the end."""
    assert undisturbed == {"accepted": 120 - START_UP, "rejected": START_UP, "fault": ""}


@pytest.mark.parametrize("kind", CAUSES)
def test_one_wrong_frame_is_refused_for_its_reason(
    kind: str, run: Callable[[str, int], Report], undisturbed: Report
) -> None:
    accepted = int(undisturbed["accepted"]) - 1
    assert run(kind, 1) == {"accepted": accepted, "rejected": START_UP + 1, "fault": "", CAUSES[kind]: 1}


@pytest.mark.parametrize(("kind", "lost"), [("lost", 2), ("late", 3), ("late", 10)])
def test_frames_that_do_not_come_are_no_errors(
    kind: str, lost: int, run: Callable[[str, int], Report], undisturbed: Report
) -> None:
    """Two lost in a row pass the check of the counter; a counter that waits with its frame is in sequence."""
    accepted = int(undisturbed["accepted"]) - lost
    assert run(kind, lost) == {"accepted": accepted, "rejected": START_UP, "fault": ""}


def test_three_lost_are_a_jump(run: Callable[[str, int], Report], undisturbed: Report) -> None:
    accepted = int(undisturbed["accepted"]) - 4
    assert run("lost", 3) == {"accepted": accepted, "rejected": START_UP + 1, "fault": "", "wrong sequence": 1}


@pytest.mark.parametrize(
    ("kind", "frames", "fault"),
    [
        ("crc", 2, ""),
        ("crc", 3, "COMMAND_INVALID"),  # more than two errors among ten
        ("data_id", 3, "COMMAND_INVALID"),
        ("range", 2, ""),
        ("range", 3, "COMMAND_OUT_OF_RANGE"),  # command.blocked_limit
        ("late", 18, ""),
        ("late", 21, "COMMAND_LOST"),  # command.lost_ms = 200
        ("repeated", 10, ""),
    ],
)
def test_several_wrong_frames_trip_the_drive(
    kind: str, frames: int, fault: str, run: Callable[[str, int], Report]
) -> None:
    assert run(kind, frames)["fault"] == fault


def test_a_log_has_each_frame_when_it_is_due(tmp_path: Path) -> None:
    path = tmp_path / "commands.log"
    with sextant.Vcu(log=path, identifier_offset=64, period_s=0.02) as vcu:
        vcu.run(0.1)
        vcu.spoil("late", 3)
        vcu.run(0.1)
    frames = list(can.LogReader(path))
    times = [0.02 * n for n in (1, 2, 3, 4, 5, 9, 10, *range(11, 21))]
    assert [frame.timestamp for frame in frames] == pytest.approx(times, abs=1e-9)
    assert {frame.arbitration_id for frame in frames} == {0x110 + 64}
    assert [frame.data[1] & 0x0F for frame in frames] == [n % 15 for n in range(len(times))]


def test_a_log_is_the_same_each_time(tmp_path: Path) -> None:
    logs = []
    for name in ("a.log", "b.log"):
        with sextant.Vcu(log=tmp_path / name, identifier_offset=0) as vcu:
            for kind in WRONG:
                vcu.spoil(kind, 2)
                vcu.run(0.1)
        logs.append((tmp_path / name).read_text())
    assert logs[0] == logs[1]


def test_no_drive_replies_to_a_log(tmp_path: Path) -> None:
    with sextant.Vcu(log=tmp_path / "commands.log", identifier_offset=0) as vcu:
        for call in (vcu.enable, vcu.make_ready):
            with pytest.raises(sextant.UserError, match=r"^a log has no drive that could get ready; demand a disable"):
                call()
        with pytest.raises(sextant.UserError, match="on a bus"), vcu.repeating():
            pass
        with pytest.raises(sextant.UserError, match="the drive sends no status frames"):
            vcu.run_until(lambda vcu: vcu.state == "TORQUE", timeout_s=0.1)
    with pytest.raises(sextant.UserError, match=r"cannot be written: No such file or directory\.$"):
        sextant.Vcu(log=tmp_path / "none" / "commands.log")
