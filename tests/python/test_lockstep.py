"""`sextant.Vcu(lockstep=…)`: a closed loop with a drive in virtual time."""

import re
import subprocess
from pathlib import Path

import pytest
import sextant
from programs import program
from sextant_py.paths import ROOT

ECU = ROOT / "configs" / "ecu.toml"
SHAFT = {"load.kind": "constant", "load.value": 0.0}
DIGEST = re.compile(r"^digest (\w{16})", re.MULTILINE)


def digest(run: tuple[list[float], str]) -> str:
    return DIGEST.search(run[1])[1]


@pytest.fixture(autouse=True)
def programs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SEXTANT_BIN", str(program("sextant-ecu").parent))


def driven(torque_nm: float, **more: object) -> tuple[list[float], str]:
    """Torque is asked until the shaft has 20 rad/s, and then the opposite until it stands: what only a drive that
    replies allows. The speeds at each period, and the drive's report."""
    speeds = []

    def speed(vcu: sextant.Vcu) -> float:
        speeds.append(float(vcu.latest["MCU_Motion"]["Speed"]))
        return speeds[-1]

    with sextant.Vcu(lockstep=ECU, **more) as vcu:
        vcu.enable()
        vcu.demand(torque_nm, enable=True)
        vcu.run_until(lambda vcu: speed(vcu) > 20.0, timeout_s=5.0)
        vcu.demand(-torque_nm, enable=True)
        vcu.run_until(lambda vcu: speed(vcu) < 0.5, timeout_s=5.0)
        assert (vcu.missed, vcu.unsent) == (0, 0)
    return speeds, vcu.report


def test_a_closed_loop_has_equal_bits_in_each_run() -> None:
    first, second = driven(20.0), driven(20.0)
    assert max(first[0]) > 20.0 > 0.5 > first[0][-1]
    assert first[0] == second[0]
    assert digest(first) == digest(second) != digest(driven(21.0))
    assert "left in READY, 0 faults" in first[1]


def test_overrides_reach_the_drive() -> None:
    with sextant.Vcu(lockstep=ECU, overrides={"protection.over_speed_rad_s": 15.0}) as vcu:
        vcu.enable()
        vcu.demand(20.0, enable=True)
        vcu.run_until(lambda vcu: vcu.state == "FAULT", timeout_s=5.0)
        assert vcu.first_fault == "OVER_SPEED"


def test_wrong_frames_trip_it_and_a_reset_frees_it() -> None:
    with sextant.Vcu(lockstep=ECU) as vcu:
        vcu.enable()
        vcu.spoil("crc", frames=4)
        vcu.run(0.1)
        assert (vcu.state, vcu.first_fault) == ("FAULT", "COMMAND_INVALID")
        vcu.run(1.0)
        vcu.enable(reset_faults=True)
        assert vcu.state in ("TORQUE", "DERATED")


def test_time_passes_only_in_the_frames_of_the_program() -> None:
    with sextant.Vcu(lockstep=ECU) as vcu:
        vcu.run(0.25)
        seen = vcu.latest["MCU_TorqueStatus"]
        vcu.send(0.0, False)
        assert vcu.latest["MCU_TorqueStatus"] is seen
    assert re.search(r"^virtual time 0\.3\d+ s", vcu.report, re.MULTILINE)  # and ten frames of disable


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ({"lockstep": "no/such.toml"}, r"sextant-ecu refuses the drive: .*no/such.toml"),
        ({"lockstep": ECU, "overrides": {"drive.nonsense": 1}}, r"sextant-ecu refuses the drive: .*unknown key"),
        ({"lockstep": "no/such.toml", "identifier_offset": 0}, r"sextant-ecu has ended with status 2: .*no/such.toml"),
        ({"lockstep": ROOT / "configs" / "ecu_four.toml"}, "has 4 drives; identifier_offset says which one"),
        ({"lockstep": ECU, "log": "commands.log"}, "a bus, a log or a drive in lockstep"),
        ({"overrides": {"drive_id": 2}}, "overrides are those of a drive in lockstep"),
    ],
)
def test_what_is_no_drive_is_said(words: dict[str, object], sentence: str) -> None:
    with pytest.raises(sextant.UserError, match=sentence), sextant.Vcu(**words) as vcu:
        vcu.run(0.1)


def test_the_identifiers_are_those_of_the_drive() -> None:
    with sextant.Vcu(lockstep=ECU, overrides={"can.identifier_offset": 32}) as vcu:
        vcu.make_ready(timeout_s=0.2)
    assert "0 faults" in vcu.report


def test_disable_frames_are_right_ones() -> None:
    with sextant.Vcu(lockstep=ECU) as vcu:
        vcu.enable()
        vcu.spoil("lost", frames=100)
        vcu.run(0.02)
    assert "left in READY, 0 faults" in vcu.report


def test_a_drive_that_ends_by_itself_leaves_its_report(tmp_path: Path) -> None:
    file = tmp_path / "two.toml"
    drive = f'[[drive]]\nbase = "{ECU}"\n'
    second = f"{drive}drive_id = 2\ncan.identifier_offset = 32\n"
    file.write_text(f'on_fault = "all_shut_down"\n{drive}{second}', encoding="utf-8")
    with pytest.raises(sextant.UserError, match="has ended with status"):  # noqa: SIM117
        with sextant.Vcu(lockstep=file, identifier_offset=32) as vcu:
            vcu.enable()
            vcu.spoil("crc", frames=4)
            vcu.run(5.0)
    assert "left in SHUTDOWN" in vcu.report or "COMMAND_INVALID" in vcu.report
    with pytest.raises(sextant.UserError, match="a new vehicle control unit starts it again"):
        vcu.run(0.1)


def test_a_drive_that_was_killed_is_told_at_the_end() -> None:
    with pytest.raises(sextant.UserError, match="has ended with status -9"):  # noqa: SIM117
        with sextant.Vcu(lockstep=ECU) as vcu:
            vcu.run(0.05)
            vcu._bus._drive.kill()
            vcu._bus._drive.wait()
            vcu.close()


def test_files_are_whole_where_the_program_dies(tmp_path: Path) -> None:
    log, telemetry = tmp_path / "frames.log", tmp_path / "telemetry.csv"
    command = [program("sextant-ecu"), ECU, "--virtual-time", "--lockstep"]
    with subprocess.Popen(
        [*command, "--frames-out", log, "--telemetry-out", telemetry],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as drive:
        drive.stdin.write("(1.0)\n")
        drive.stdin.flush()
        drive.stdout.readline()
        drive.stdout.close()
        drive.stdin.write("(2.0)\n(3.0)\n(4.0)\n")
        drive.stdin.close()
        assert drive.wait(60) == 1
        assert "standard output cannot be written" in drive.stderr.read()
    for file in (log, telemetry):
        assert file.read_bytes().endswith(b"\n")
    assert float(log.read_text().splitlines()[-1].split(")")[0].strip("(")) >= 1.0


def test_no_thread_repeats_into_a_drive_that_waits() -> None:
    with (
        sextant.Vcu(lockstep=ECU) as vcu,
        pytest.raises(sextant.UserError, match="repeats its demand once, and on a bus"),
        vcu.repeating(),
    ):
        pass


@pytest.mark.parametrize(
    ("lines", "sentence"),
    [
        ("(0.1)\n(0.05)\n", "the standard input, line 2: the time goes back"),
        ("(0.1)\nnonsense\n", "line 2: expected a time"),
        ("(0.1) can0 100#XX\n", "line 1: .*is no byte"),
    ],
)
def test_lines_that_are_none_are_refused(lines: str, sentence: str) -> None:
    found = subprocess.run(
        [program("sextant-ecu"), ECU, "--virtual-time", "--lockstep"],
        input=lines,
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert found.returncode == 2
    assert re.search(sentence, found.stderr), found.stderr
    assert len(found.stderr.splitlines()) == 1


def test_lines_without_a_program_are_a_recording(tmp_path: Path) -> None:
    log = tmp_path / "commands.log"
    with sextant.Vcu(log=log, identifier_offset=0) as vcu:
        vcu.run(0.1)
        vcu.demand(20.0, enable=True)
        vcu.run(0.3)
    command = [program("sextant-ecu"), ECU, "--virtual-time"]
    lines = log.read_text(encoding="utf-8")
    piped = subprocess.run([*command, "--lockstep"], input=lines, capture_output=True, text=True, timeout=60)
    assert piped.returncode == 0
    accepted = re.compile(r"^commands (\d+) accepted, 0 rejected|^commands (\d+) accepted", re.MULTILINE)
    played = subprocess.run([*command, log], capture_output=True, text=True, timeout=60)
    assert accepted.search(piped.stdout)[0] == accepted.search(played.stdout)[0]
