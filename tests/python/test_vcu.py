"""The vehicle control unit against the CAN side of a drive, over UDP multicast."""

import json
import signal
import subprocess
import time
from pathlib import Path

import pytest
from fake_drive import FakeDrive
from sextant_py.contract import Contract
from sextant_py.paths import ROOT

PERIOD_S = 0.01
PROFILE_S = 0.6


@pytest.fixture
def profile(tmp_path: Path) -> Path:
    path = tmp_path / "profile.csv"
    path.write_text("time_s,torque_nm\n0,0\n0.2,0\n0.2,20\n0.6,20\n0.6,0\n")
    return path


@pytest.fixture
def long_profile(tmp_path: Path) -> Path:
    """One that no test waits for the end of."""
    path = tmp_path / "long.csv"
    path.write_text("time_s,torque_nm\n0,20\n600,20\n")
    return path


def start(address: str, profile: Path, *options: str) -> subprocess.Popen:
    command = [ROOT / "scripts" / "vcu", "--can", address, "--profile", profile, *options]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def enabled(drive: FakeDrive) -> list[bool]:
    return [str(command["Enable"]) == "ENABLE" for _, command in drive.accepted]


def wait_for_disables(drive: FakeDrive, count: int) -> None:
    """Until the last so many commands that the drive has taken were disables; it may lag behind."""
    deadline = time.monotonic() + 240
    while any(enabled(drive)[-count:]) and time.monotonic() < deadline:
        time.sleep(0.02)


def test_hand_shake_profile_and_disable(bus_address: str, profile: Path, tmp_path: Path) -> None:
    log_file = tmp_path / "log.json"
    with FakeDrive(bus_address) as drive:
        vcu = start(bus_address, profile, "--log", str(log_file))
        output, errors = vcu.communicate(timeout=240)
        assert vcu.returncode == 0, errors
        wait_for_disables(drive, 5)
        flags = enabled(drive)
        assert not flags[0]
        assert not flags[-1]
        assert flags == sorted(flags[: flags.index(True)]) + [True] * sum(flags) + [False] * flags[::-1].index(True)
        assert drive.refused == 0
        assert max(command["TorqueRequest"] for _, command in drive.accepted) == pytest.approx(20.0)
        assert drive.state == "READY"
    assert "the drive is ready" in output

    log = json.loads(log_file.read_text())
    sent = log["commands"]
    assert len(sent) - len(drive.accepted) in range(6)  # the first ones only make the counter known
    assert [command["counter"] for command in sent] == [index % 15 for index in range(len(sent))]
    times = [command["t_ns"] for command in sent if command["enable"]]
    assert times[0] >= log["profile_start_ns"]
    # One frame a period of the profile, where the machine had time for it; the rest was skipped, not made up for.
    assert len(times) <= PROFILE_S / PERIOD_S + 1
    assert len(times) + log["missed_periods"] >= PROFILE_S / PERIOD_S


def test_no_drive_is_said(bus_address: str, profile: Path) -> None:
    vcu = start(bus_address, profile, "--timeout", "0.5")
    _, errors = vcu.communicate(timeout=240)
    assert vcu.returncode == 1
    assert errors.startswith("vcu: no status frame from a drive with the identifier offset 0 within 0.5 s;")


def test_a_drive_with_another_offset_is_no_drive(bus_address: str, profile: Path) -> None:
    with FakeDrive(bus_address, identifier_offset=64):
        vcu = start(bus_address, profile, "--timeout", "0.5", "--identifier-offset", "32")
        _, errors = vcu.communicate(timeout=240)
        assert vcu.returncode == 1
        for word in ("the identifier offset 32", "--identifier-offset", "can.identifier_offset"):
            assert word in errors


def test_a_drive_that_stays_locked_is_said(bus_address: str, profile: Path) -> None:
    with FakeDrive(bus_address, stubborn=True) as drive:
        vcu = start(bus_address, profile, "--timeout", "0.5")
        _, errors = vcu.communicate(timeout=240)
        assert vcu.returncode == 1
        assert "it reports STANDBY and lockout" in errors
        assert not any(enabled(drive))


def test_without_hand_shake_the_first_frame_enables(bus_address: str, profile: Path) -> None:
    with FakeDrive(bus_address) as drive:
        vcu = start(bus_address, profile, "--no-handshake")
        _, errors = vcu.communicate(timeout=240)
        assert vcu.returncode == 0, errors
        assert enabled(drive)[0]


def test_a_fault_ends_the_profile(bus_address: str, long_profile: Path) -> None:
    with FakeDrive(bus_address, fault_after=30) as drive:
        vcu = start(bus_address, long_profile)
        _, errors = vcu.communicate(timeout=240)
        assert vcu.returncode == 1
        assert "the drive went to FAULT" in errors
        wait_for_disables(drive, 5)
        assert not enabled(drive)[-1]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=["SIGINT", "SIGTERM"])
def test_interrupted_it_disables(bus_address: str, long_profile: Path, number: signal.Signals) -> None:
    with FakeDrive(bus_address) as drive:
        vcu = start(bus_address, long_profile)
        deadline = time.monotonic() + 240
        while True not in enabled(drive) and time.monotonic() < deadline:
            time.sleep(0.02)
        vcu.send_signal(number)
        vcu.communicate(timeout=240)
        assert vcu.returncode == 130
        wait_for_disables(drive, 5)
        assert enabled(drive)[-5:] == [False] * 5


def test_a_drive_with_another_contract_is_said(bus_address: str, long_profile: Path) -> None:
    with FakeDrive(bus_address, contract_major=77) as drive:
        vcu = start(bus_address, long_profile)
        _, errors = vcu.communicate(timeout=240)
        assert vcu.returncode == 1
        major, minor = Contract().version()
        assert f"the drive speaks version 77.0 of the CAN contract, this program {major}.{minor}." in errors
        wait_for_disables(drive, 1)


def test_two_drives_on_one_bus_each_follow_their_own_vehicle(bus_address: str, tmp_path: Path) -> None:
    # Long enough for a machine that stands still for a while: the torque has to be seen.
    profile = tmp_path / "seconds.csv"
    profile.write_text("time_s,torque_nm\n0,20\n4,20\n4,0\n")
    with FakeDrive(bus_address) as first, FakeDrive(bus_address, identifier_offset=32) as second:
        vcu = start(bus_address, profile, "--identifier-offset", "32")
        _, errors = vcu.communicate(timeout=240)
        assert vcu.returncode == 0, errors
        wait_for_disables(second, 5)
        assert any(enabled(second))
        assert not first.accepted
        assert first.refused == second.refused == 0


@pytest.mark.parametrize("offset", ["-32", "16", "1760"])
def test_an_offset_of_no_block_is_refused(bus_address: str, profile: Path, offset: str) -> None:
    vcu = start(bus_address, profile, "--identifier-offset", offset)
    _, errors = vcu.communicate(timeout=240)
    assert vcu.returncode == 2
    assert f"the identifier offset {offset} is not a multiple of 32 from 0 to 1728" in errors
    assert errors.count("\n") == 1


def test_a_torque_outside_the_contract_is_refused(bus_address: str, tmp_path: Path) -> None:
    profile = tmp_path / "high.csv"
    profile.write_text("time_s,torque_nm\n0,0\n1,4000\n")
    vcu = start(bus_address, profile)
    _, errors = vcu.communicate(timeout=240)
    assert vcu.returncode == 2
    assert "leaves the contract's range of torque" in errors
    assert errors.count("\n") == 1
