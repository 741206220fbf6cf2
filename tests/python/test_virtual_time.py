"""sextant-ecu --virtual-time: recordings of can-utils and python-can go in and come out, and runs repeat."""

import csv
import itertools
import re
import shutil
import subprocess
from pathlib import Path

import can
import h5py
import pytest
from programs import program
from sextant_py import e2e
from sextant_py.contract import Contract
from sextant_py.errors import UserError
from sextant_py.paths import ROOT
from sextant_py.profile import load
from sextant_py.tracking import Tracking
from studies.bench import speed

ECU_CONFIG = ROOT / "configs" / "ecu.toml"
PERIOD_S = 0.01
CYCLES_S = {
    name: message.cycle_time / 1e3
    for name, message in Contract().messages_of_the_drive().items()
    if message.cycle_time <= 100
}


def start(*arguments: object) -> subprocess.CompletedProcess:
    return launch(ECU_CONFIG, *arguments)


def replay(*arguments: object) -> subprocess.CompletedProcess:
    """Without a configuration: the recording has it."""
    return launch("--replay", *arguments)


def launch(*arguments: object) -> subprocess.CompletedProcess:
    return subprocess.run(
        [program("sextant-ecu"), *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=480,
        stdin=subprocess.DEVNULL,
    )


def run(*arguments: object) -> str:
    """The report of a run that went well."""
    found = start("--virtual-time", *arguments)
    assert found.returncode == 0, found.stderr
    return found.stdout


def test_several_drives_of_one_file_play_the_same_each_with_its_files(tmp_path: Path) -> None:
    out = tmp_path / "run.csv"
    wanted = ("--virtual-time", "--duration", "0.3", "--telemetry-out", out)
    found = launch(ROOT / "configs" / "ecu_four.toml", *wanted)
    assert found.returncode == 0, found.stderr
    assert re.findall(r"^drive (\d)$", found.stdout, re.MULTILINE) == [*"12341234"]
    telemetry = re.findall(r"telemetry (\w{16})", found.stdout)
    assert len(telemetry) == 4 and len(set(telemetry)) == 1, "the same drive four times, each with its own identifiers"
    assert sorted(path.name for path in tmp_path.iterdir()) == [f"run_{number}.csv" for number in range(1, 5)]


def digest(report: str) -> str:
    return re.search(r"^digest .*$", report, re.MULTILINE).group()


def telemetry(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


@pytest.fixture
def profile(tmp_path: Path) -> Path:
    """Half a second of torque, both ways."""
    path = tmp_path / "profile.csv"
    path.write_text("time_s,torque_nm\n0,15\n0.25,15\n0.25,-10\n0.5,-10\n", encoding="utf-8")
    return path


@pytest.fixture
def commands(tmp_path: Path) -> Path:
    """A vehicle's side of half a second, written by python-can: disable, then 12 N·m."""
    path = tmp_path / "commands.log"
    contract = Contract()
    with can.CanutilsLogWriter(path, channel="can0") as writer:
        for n in range(50):
            signals = {"TorqueRequest": 12.0 if n >= 10 else 0.0, "TorqueLimit": 150.0, "Enable": int(n >= 10)}
            frame = contract.encode("VCU_TorqueCommand", {**signals, "FaultReset": 0}, n % e2e.COUNTER_COUNT)
            frame.timestamp = 1_700_000_000 + n * PERIOD_S
            writer.on_message_received(frame)
    return path


def test_a_recording_of_python_can_drives_the_drive(commands: Path, tmp_path: Path) -> None:
    report = run(commands, "--telemetry-out", tmp_path / "run.csv")
    assert "commands 48 accepted, 2 rejected" in report
    assert "E2E state not valid yet 2" in report
    assert "left in TORQUE, 0 faults" in report
    rows = [row for row in telemetry(tmp_path / "run.csv") if 200e6 < int(row["t_ns"]) < 480e6]
    assert {row["state"] for row in rows} == {"TORQUE"}
    assert sum(float(row["torque_mean_nm"]) for row in rows) / len(rows) == pytest.approx(12.0, abs=2.5)


@pytest.mark.parametrize("config", ["ecu.toml", "ecu_foc.toml"])
def test_the_shipped_drives_follow_the_profile_of_the_demo(config: str, tmp_path: Path) -> None:
    """The pairs of the README: a file as it stands, and the profile that scripts/vcu plays."""
    out = tmp_path / "run.csv"
    demo = ROOT / "configs" / "profiles" / "demo.csv"
    found = launch(ROOT / "configs" / config, "--virtual-time", "--profile", demo, "--telemetry-out", out)
    assert found.returncode == 0, found.stderr
    tracking = Tracking()
    for row in telemetry(out):
        tracking.add(int(row["t_ns"]) / 1e9, float(row["torque_requested_nm"]), float(row["torque_mean_nm"]))
    assert tracking.total_s > 9
    assert tracking.sentence() is None


def test_a_long_ramp_to_zero_has_its_time(tmp_path: Path) -> None:
    profile = tmp_path / "profile.csv"
    profile.write_text("time_s,torque_nm\n0,15\n20,15\n", encoding="utf-8")
    settings = ("--set", "command.zero_ramp_ms=5000", "--duration", "0.5")
    report = run("--profile", profile, "--telemetry-out", tmp_path / "run.csv", *settings)
    assert "left in TORQUE, 0 faults" in report
    last = telemetry(tmp_path / "run.csv")[-1]
    assert int(last["t_ns"]) > 4e9


@pytest.mark.parametrize("method", speed.METHODS)
def test_every_control_method_follows_without_another_change_of_the_file(
    method: str, profile: Path, tmp_path: Path
) -> None:
    settings = ("--set", f"control.controller={method}")
    report = run("--profile", profile, "--telemetry-out", tmp_path / "run.csv", *settings)
    assert "left in READY, 0 faults" in report
    torques = [float(row["torque_mean_nm"]) for row in telemetry(tmp_path / "run.csv") if row["state"] == "TORQUE"]
    assert max(torques) == pytest.approx(15, abs=3)
    assert min(torques) == pytest.approx(-10, abs=3)


@pytest.mark.parametrize("path", sorted((ROOT / "tests" / "csv").iterdir()), ids=lambda path: path.stem)
def test_both_readers_of_profiles_agree(path: Path) -> None:
    """scripts/vcu and sextant-ecu accept the same files, of any origin, and refuse the same at the same line."""
    found = start("--virtual-time", "--profile", path, "--duration", "0.005")
    place = re.search(rf"{re.escape(str(path))}(:\d+)?", found.stderr)
    if path.stem.startswith("good"):
        assert [(point.time_s, point.torque_nm) for point in load(path).points] == [(0, 0), (1, 5), (2, 0)]
        assert place is None, found.stderr
        return
    assert found.returncode != 0
    with pytest.raises(UserError) as refused:
        load(path)
    assert place.group() in str(refused.value), found.stderr


def test_a_run_too_short_for_the_hand_shake_says_how_short_it_was(profile: Path) -> None:
    found = start("--virtual-time", "--profile", profile, "--duration", "0.005")
    assert found.returncode == 4
    assert "the drive was not ready within 0.005 s" in found.stderr


def test_python_can_reads_what_was_recorded(profile: Path, tmp_path: Path) -> None:
    log = tmp_path / "run.log"
    run("--profile", profile, "--frames-out", log)
    contract = Contract()
    sent: dict[str, list[tuple[float, dict]]] = {}
    for frame in can.LogReader(log):
        name, signals = contract.decode(frame)
        sent.setdefault(name, []).append((frame.timestamp, signals))
        if name == "MCU_TorqueStatus":
            assert e2e.is_valid(bytes(frame.data), contract.data_id(name))
    assert len(sent) == len(contract.database.messages)
    said = sent["MCU_Identification"][0][1]
    assert (said["ContractMajor"], said["ContractMinor"]) == contract.version()
    statuses = sent["MCU_TorqueStatus"]
    for name, cycle_s in CYCLES_S.items():
        # The last status tells of the shutdown and the last faults of what they are, due or not.
        cyclic = [time for time, _ in sent[name][:-1]]
        assert len(cyclic) >= 0.4 / cycle_s - 1, name
        assert all(b - a == pytest.approx(cycle_s, abs=1e-5) for a, b in itertools.pairwise(cyclic)), name
    assert {"STANDBY", "READY", "TORQUE", "SHUTDOWN"} <= {str(signals["DriveState"]) for _, signals in statuses}
    assert str(statuses[-1][1]["DriveState"]) == "SHUTDOWN"


@pytest.mark.skipif(shutil.which("log2asc") is None, reason="NOT TESTED: can-utils are not installed")
def test_can_utils_read_what_was_recorded(profile: Path, tmp_path: Path) -> None:
    log = tmp_path / "run.log"
    run("--profile", profile, "--frames-out", log)
    found = subprocess.run(["log2asc", "-I", log, "can0"], capture_output=True, text=True, timeout=240, check=True)
    frames = [line for line in found.stdout.splitlines() if re.search(r" (Rx|Tx) ", line)]
    assert len(frames) == len(log.read_text(encoding="utf-8").splitlines())


def test_frames_of_one_instant_are_all_heard(tmp_path: Path) -> None:
    """Were each to cost what all that wait cost, this would take longer than a test may."""
    count = 300_000
    log = tmp_path / "equal.log"
    log.write_text("(1700000000.000000) can0 110#0000000000000000\n" * count, encoding="utf-8")
    assert f", {count} received\n" in run(log, "--duration", "0.001")


def test_a_replay_of_its_own_recording_is_the_same_run(profile: Path, tmp_path: Path) -> None:
    names = [tmp_path / name for name in ("a.log", "a.csv", "b.log", "b.csv")]
    first = run("--profile", profile, "--frames-out", names[0], "--telemetry-out", names[1])
    second = run(names[0], "--frames-out", names[2], "--telemetry-out", names[3])
    assert digest(first) == digest(second)
    assert names[0].read_bytes() == names[2].read_bytes()
    assert names[1].read_bytes() == names[3].read_bytes()


def test_an_offset_moves_all_frames_of_the_run(profile: Path, tmp_path: Path) -> None:
    logs = {offset: tmp_path / f"{offset}.log" for offset in (0, 64)}
    for offset, log in logs.items():
        run("--profile", profile, "--frames-out", log, "--set", f"can.identifier_offset={offset}")
    base, moved = ([frame.arbitration_id for frame in can.LogReader(log)] for log in logs.values())
    assert moved == [identifier + 64 for identifier in base]
    # Its replay leaves out the status frames of the drive with this offset, and of no other.
    assert "status frames of the recording were left out" in run(logs[64], "--set", "can.identifier_offset=64")
    elsewhere = run(logs[64])
    assert "were left out" not in elsewhere
    assert "no frame has the command's identifier 0x110 (can.identifier_offset = 0)" in elsewhere


def test_one_command_is_enough_for_its_identifier_to_be_right(commands: Path) -> None:
    assert "no frame has the command's identifier" not in run(commands, "--duration", "0.001")


def test_a_seed_is_a_run(profile: Path) -> None:
    # A vehicle may not get through its profile on such a bus; the run is the same all the same.
    reports = [start("--virtual-time", "--profile", profile, "--bus-seed", seed).stdout for seed in (3, 3, 4)]
    assert digest(reports[0]) == digest(reports[1]) != digest(reports[2])
    assert "disturbed with seed 3" in reports[0]


def test_the_fixed_step_repeats_as_well(profile: Path) -> None:
    reports = [run("--profile", profile, "--set", "plant.integrator=fixed") for _ in range(2)]
    assert digest(reports[0]) == digest(reports[1]) != digest(run("--profile", profile))


def test_hdf5_and_csv_hold_the_same(profile: Path, tmp_path: Path) -> None:
    run("--profile", profile, "--telemetry-out", tmp_path / "run.h5")
    run("--profile", profile, "--telemetry-out", tmp_path / "run.csv")
    rows = telemetry(tmp_path / "run.csv")
    with h5py.File(tmp_path / "run.h5") as file:
        assert set(file) == set(rows[0])  # and no group `plant`: the drive does not know it
        assert list(file["torque_mean_nm"]) == [float(row["torque_mean_nm"]) for row in rows]
        assert list(file["t_ns"]) == [int(row["t_ns"]) for row in rows]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((), ("the run has no input and no end", "--profile")),
        (("gone.log",), ("gone.log cannot be read",)),
        (
            ("{commands}", "--profile", "{profile}"),
            ("there are the recording ", "commands.log and --profile: leave all but one"),
        ),
        (("{commands}", "--lockstep"), ("commands.log and --lockstep: leave all but one",)),
        (("{commands}", "--log-interface", "vcan7"), ("holds frames of can0",)),
        (("{commands}", "--telemetry-out", "run.txt"), ("must end in .csv or .h5",)),
        (("{commands}", "--frames-out", "/no/where.log"), ("/no/where.log cannot be written",)),
        (("{commands}", "--frames-out", "{commands}"), ("read and written at once",)),
        (("{profile}",), ("profile.csv:1: expected a time",)),
        (("/dev/zero",), ("/dev/zero cannot be read: it is a device",)),
        (("--profile", "/dev/zero"), ("/dev/zero cannot be read: it is a device",)),
        (("{centuries}",), ("centuries.log:2: the time jumps ahead by", "a log may have gaps of 86400 s")),
        (("--profile", "{commands}"), ("commands.log:2",)),
    ],
)
def test_bad_input_is_one_sentence(
    arguments: tuple[str, ...], words: tuple[str, ...], commands: Path, profile: Path, tmp_path: Path
) -> None:
    before = commands.read_bytes()
    files = {"commands": commands, "profile": profile, "centuries": tmp_path / "centuries.log"}
    files["centuries"].write_text("(1700000000.000000) can0 110#00\n(8899999999.000000) can0 110#00\n")
    found = start("--virtual-time", *(text.format(**files) for text in arguments))
    assert found.returncode == 2
    assert found.stdout == ""
    assert len(found.stderr.splitlines()) == 1
    assert found.stderr.startswith("sextant-ecu: ")
    for word in words:
        assert word in found.stderr
    assert commands.read_bytes() == before


def test_a_vehicle_that_is_let_down_says_so(profile: Path) -> None:
    table = ("--set", "drive.magnetise_first=false")  # its start surges to 84 A
    lowered = (*table, "--set", "protection.over_current_a=30")
    found = start("--virtual-time", "--profile", profile, *lowered)
    assert found.returncode == 3
    assert "went to FAULT (OVER_CURRENT)" in found.stderr
    assert "left in FAULT, 1 faults, first OVER_CURRENT" in found.stdout


def test_a_recording_that_trips_the_drive_says_so(commands: Path) -> None:
    lowered = ("--set", "drive.magnetise_first=false", "--set", "protection.over_current_a=30")
    found = start("--virtual-time", commands, *lowered)
    assert found.returncode == 3
    assert f"the drive went to FAULT (OVER_CURRENT) while it followed {commands}" in found.stderr


# 150 kW, 565 V.
LARGE = """
machine.r_s_ohm = 0.01379
machine.r_r_ohm = 0.007728
machine.l_ls_h = 0.000152
machine.l_lr_h = 0.000152
machine.l_m_h = 0.00769
machine.poles = 4
machine.inertia_kg_m2 = 2.9
machine.reactance_frequency_hz = 50
control.controller = "foc"
drive.period_us = 125
plant.integrator = "fixed"
plant.u_dc_v = 565
realtime.wake_every_periods = 8
"""


def test_what_the_contract_cannot_carry_is_announced(tmp_path: Path) -> None:
    """By the ranges that cantools reads from the database."""
    config, profile, contract = tmp_path / "large.toml", tmp_path / "small.csv", Contract()
    config.write_text(LARGE, encoding="utf-8")
    low, high = contract.limits("VCU_TorqueCommand", "TorqueRequest")
    profile.write_text(f"time_s,torque_nm\n0,{high}\n0.1,{low}\n", encoding="utf-8")
    found = launch(config, "--virtual-time", "--profile", profile)
    assert found.returncode == 0, found.stderr
    said = [line for line in found.stderr.splitlines() if "warn" in line]
    assert len(said) == 1
    assert f"VCU_TorqueCommand.TorqueRequest carries {low:g} to {high:g} N·m, and command.torque_limit_nm is" in said[0]
    rms = contract.limits("MCU_Electrical", "PhaseCurrentRms")[1]
    assert f"MCU_Electrical.PhaseCurrentRms carries 0 to {rms:g} A" in said[0]
    assert "FluxMagnitude" not in said[0]


@pytest.mark.parametrize("beyond", [1, -1])
def test_a_profile_beyond_the_contract_is_refused_as_by_scripts_vcu(beyond: int, tmp_path: Path) -> None:
    profile = tmp_path / "large.csv"
    high = Contract().limits("VCU_TorqueCommand", "TorqueRequest")[1]
    profile.write_text(f"time_s,torque_nm\n0,0\n1,{beyond * (high + 0.01)}\n", encoding="utf-8")
    found = start("--virtual-time", "--profile", profile)
    assert (found.returncode, found.stdout) == (2, "")
    assert "large.csv:3: torque_nm is" in found.stderr and "-250 to 250 N·m" in found.stderr


def test_its_options_need_virtual_time(profile: Path) -> None:
    found = start("--profile", profile)
    assert found.returncode == 2
    assert "--virtual-time" in found.stderr


@pytest.mark.parametrize(("method", "most_segments"), [("dtc", 1), ("foc", 7)])
def test_recorded_control_periods_replay_with_identical_switching(
    method: str, most_segments: int, tmp_path: Path, profile: Path
) -> None:
    cycles, first, again = (tmp_path / name for name in ("run.h5", "first.csv", "again.csv"))
    settings = ("--set", f"control.controller={method}")
    report = run("--profile", profile, "--record-cycles", cycles, "--telemetry-out", first, *settings)
    periods = int(re.search(r"run.h5: (\d+) control periods recorded", report)[1])
    found = replay(cycles, "--telemetry-out", again)
    assert found.returncode == 0, found.stdout + found.stderr
    assert f"{periods} of {periods} gate patterns as recorded\n" in found.stdout
    assert telemetry(again) == telemetry(first), "not only the switching"
    with h5py.File(cycles) as file:
        rows = file["cycles"][:]
        assert len(rows) == periods > 20_000
        assert set(rows["torque_nm"]) >= {15.0, -10.0}
        # Each pattern is what the power stage has applied by the next measurement.
        pattern, applied = rows["pattern"][:-1], rows["applied"][1:]
        assert (pattern["segments"] == most_segments).sum() > 10_000
        # A machine that is magnetised has a modulated voltage with any method.
        assert pattern["segments"].max() <= 7
        for member in ("segments", "state", "duration_ns"):
            assert (pattern[member] == applied[member]).all(), member


def test_a_replay_with_another_configuration_tells_the_first_other_pattern(tmp_path: Path, profile: Path) -> None:
    cycles = tmp_path / "run.h5"
    run("--profile", profile, "--record-cycles", cycles)
    found = replay(cycles, "--set", "control.dtc.flux_band_wb=0.02")
    assert found.returncode == 1
    as_recorded, periods = map(int, re.search(r"(\d+) of (\d+) gate patterns as recorded", found.stdout).groups())
    assert 0 < as_recorded < periods
    assert re.search(r"first other one in period \d+, .* after the first\n +recorded: .*\n +replayed: ", found.stdout)
    # The protections of the replay see the recorded speed.
    found = replay(cycles, "--set", "protection.over_speed_rad_s=1", "--telemetry-out", tmp_path / "t.csv")
    assert found.returncode == 3
    assert "the drive went to FAULT (OVER_SPEED) while it followed" in found.stderr
    assert "FAULT" in {row["state"] for row in telemetry(tmp_path / "t.csv")}
    replay(cycles, "--telemetry-out", tmp_path / "same.csv")
    assert "FAULT" not in {row["state"] for row in telemetry(tmp_path / "same.csv")}


def test_a_recording_that_cannot_be_made_loses_nothing(tmp_path: Path, profile: Path) -> None:
    cycles = tmp_path / "run.h5"
    run("--profile", profile, "--record-cycles", cycles)
    before = cycles.read_bytes()
    found = start("--virtual-time", tmp_path / "missing.log", "--record-cycles", cycles)
    assert found.returncode == 2
    assert "missing.log" in found.stderr
    assert cycles.read_bytes() == before
    found = start("--virtual-time", "--profile", profile, "--record-cycles", profile)
    assert found.returncode == 2
    assert "profile.csv is there and no recording of control periods" in found.stderr
    assert profile.read_text(encoding="utf-8").startswith("time_s")
    found = start("--virtual-time", "--profile", profile, "--record-cycles", tmp_path / "none" / "run.h5")
    assert found.returncode == 2
    assert "run.h5 cannot be written: No such file or directory" in found.stderr


def test_what_is_no_recording_of_control_periods_is_refused(tmp_path: Path, profile: Path) -> None:
    cycles = tmp_path / "run.h5"
    run("--profile", profile, "--record-cycles", cycles)
    cut = tmp_path / "cut.h5"
    cut.write_bytes(cycles.read_bytes()[: cycles.stat().st_size // 2])
    for file, why in ((ECU_CONFIG, "signature"), (cut, "truncated file"), (tmp_path / "none.h5", "No such file")):
        found = replay(file)
        assert found.returncode == 2
        assert f"{file} is no recording of control periods" in found.stderr
        assert why in found.stderr
    found = replay(cycles, "--set", "drive.perod_us=25")
    assert found.returncode == 2
    assert "drive.perod_us: unknown key" in found.stderr
    found = replay(cycles, "--set", "drive.period_us=50")
    assert found.returncode == 2
    assert "drive.period_us is that of the recording (25 us)" in found.stderr
    for other in (("--duration", 1), ("--record-cycles", tmp_path / "again.h5"), ("--print-config",), (ECU_CONFIG,)):
        found = replay(cycles, *other)
        assert found.returncode == 2, other
        assert len(found.stderr.splitlines()) == 1
    with h5py.File(cycles, "a") as file:
        rows = file["cycles"][:]
        del file["cycles"]
        file["cycles"] = rows.astype(
            [(name.replace("speed_rad_s", "speed"), rows.dtype[name]) for name in rows.dtype.names]
        )
    found = replay(cycles)
    assert found.returncode == 2
    assert "its rows are of another version of Sextant" in found.stderr
    found = start("--telemetry-out", tmp_path / "t.csv", "--duration", 1)
    assert found.returncode == 2
    assert "needs --virtual-time or --replay" in found.stderr
