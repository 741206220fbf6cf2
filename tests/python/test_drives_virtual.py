"""Several drives in virtual time: changes for one of them, recordings of commands, scenarios."""

import json
import re
import subprocess
from pathlib import Path
from xml.etree import ElementTree

import h5py
import pytest
from programs import overrides, program
from sextant_py.paths import ROOT

OFFSETS = {1: 0, 2: 32}
LIGHT = ("plant.integrator=fixed", "drive.period_us=100", "control.controller=foc")
TURNING = ("load.kind=imposed_speed", "load.speed_rad_s.value=40")


@pytest.fixture(scope="module")
def pair(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("drives") / "pair.toml"
    table = '[[drive]]\nbase = "{0}"\ndrive_id = {1}\ncan.identifier_offset = {2}\n'
    base = ROOT / "configs" / "ecu.toml"
    file.write_text("".join(table.format(base, *drive) for drive in OFFSETS.items()), encoding="utf-8")
    return file


@pytest.fixture(scope="module")
def profile(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("drives") / "profile.csv"
    file.write_text("time_s,torque_nm\n0,0\n0.1,140\n0.4,140\n", encoding="utf-8")
    return file


def run(file: Path, *words: object, settings: tuple[str, ...] = (*LIGHT, *TURNING)) -> subprocess.CompletedProcess:
    command = [program("sextant-ecu"), file, "--virtual-time", *map(str, words), *overrides(settings)]
    return subprocess.run(command, capture_output=True, text=True, timeout=240, stdin=subprocess.DEVNULL)


def digests(found: subprocess.CompletedProcess) -> list[str]:
    """Of the telemetry of each drive: the frames have identifiers of their own."""
    telemetry = re.findall(r"telemetry (\w{16})", found.stdout)
    assert len(telemetry) == len(OFFSETS), found.stderr
    return telemetry


def test_a_key_for_one_drive_leaves_the_other_as_it_is(pair: Path, profile: Path) -> None:
    gain = "control.foc.bandwidth_rad_s=900"
    plain = digests(run(pair, "--profile", profile))
    assert plain[0] == plain[1], "the same drive twice"
    both = digests(run(pair, "--profile", profile, "--set", gain))
    assert both[0] == both[1] != plain[0]
    assert digests(run(pair, "--profile", profile, "--set", f"drive[2].{gain}")) == [plain[0], both[1]]


def test_a_key_is_set_at_a_time_for_one_drive_or_for_all(pair: Path, profile: Path) -> None:
    plain = digests(run(pair, "--profile", profile))
    limit = "protection.over_current_a=32"
    one = run(pair, "--profile", profile, "--set-at", f"0.4:drive[2].{limit}")
    assert re.search(r"^drive 2: parameters 1 at 0.4 s: .*over_current_a from \S+ to 32", one.stdout, re.MULTILINE)
    assert "drive 1: parameters" not in one.stdout
    assert one.returncode == 3
    assert "drive 2: the drive went to FAULT (OVER_CURRENT)" in one.stderr
    assert digests(one)[0] == plain[0], "the first drive runs as without"
    each = run(pair, "--profile", profile, "--set-at", f"0.4:{limit}")
    assert digests(each) == [digests(one)[1]] * 2


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (
            ("--set", "drive[7].drive.period_us=50"),
            r"--set: drive\[7\].drive.period_us=50: no drive has this drive_id; there is 1, 2",
        ),
        (("--set-at", "0.1:drive[7].protection.over_current_a=80"), r"--set-at: no drive has drive_id 7"),
        (("--set-at", "0.1:drive[2].drive.period_us=50"), r"--set-at 0\.1: drive 2: drive\.period_us never changes"),
        (("--set", "drive[2].control.nonsense=1"), r"control\.nonsense: "),
    ],
)
def test_a_key_that_no_drive_can_take_is_refused(
    pair: Path, profile: Path, words: tuple[str, str], sentence: str
) -> None:
    found = run(pair, "--profile", profile, *words)
    assert found.returncode == 2
    assert re.search(sentence, found.stderr), found.stderr


def test_a_recording_of_both_drives_commands_both_again(pair: Path, profile: Path, tmp_path: Path) -> None:
    frames = tmp_path / "run.log"
    first = run(pair, "--profile", profile, "--frames-out", frames)
    assert first.returncode == 0, first.stderr
    sent = [line.split()[2] for line in frames.read_text(encoding="utf-8").splitlines()]
    again = run(pair, frames)
    assert again.returncode == 0, again.stderr
    assert len(re.findall(r"^commands [1-9]\d+ accepted", again.stdout, re.MULTILINE)) == 2, again.stdout
    left_out = int(re.search(r"(\d+) status frames of the recording were left out", again.stdout)[1])
    commands = sum(frame.startswith(("110#", "130#")) for frame in sent)
    assert left_out == len(sent) - commands, "the status of both drives, and nothing else"
    states = re.findall(r"^left in (\w+), 0 faults$", again.stdout, re.MULTILINE)
    assert len(states) == 2, again.stdout


def test_a_scenario_is_evaluated_for_each_drive(pair: Path, tmp_path: Path) -> None:
    scenario = tmp_path / "step.toml"
    scenario.write_text(
        f"""
name = "step"
duration_s = 0.5
machine = "{ROOT}/configs/machines/paper_3hp.toml"
[profile.torque_nm]
shape = "steps"
points = [[0, 0], [0.3, 15]]
[load]
kind = "imposed_speed"
speed_rad_s.value = 40
[drive]
period_us = 100
[control]
controller = "foc"
flux_reference_wb = 1.1
[metrics]
window_from_s = 0.35
[expect]
torque_bias_nm = {{ min = -0.5, max = 0.5 }}
""",
        encoding="utf-8",
    )
    junit, out = tmp_path / "junit.xml", tmp_path / "out"
    words = ("--scenario", scenario, "--junit", junit, "--out", out)
    # 20 % less than the machine's, and nothing corrects it: torque by a wrong flux.
    wrong = ("machine_estimate.l_m_h=0.066", "flux_estimator=current_model", "adapts_parameters=false")
    found = run(pair, *words, settings=(*LIGHT, *(f"drive[2].control.{key}" for key in wrong)))
    assert found.returncode == 1, found.stderr
    suites = {suite.get("name"): int(suite.get("failures")) for suite in ElementTree.parse(junit).iter("testsuite")}
    assert suites["step_1"] == 0 < suites["step_2"]
    verdicts = {}
    for number in OFFSETS:
        directory = out / f"step_{number}"
        verdicts[number] = json.loads((directory / "summary.json").read_text(encoding="utf-8"))["verdict"]
        with h5py.File(directory / "trace.h5") as trace:
            assert abs(trace["plant/omega_m_rad_s"][-1] - 40) < 1e-6
    assert verdicts == {1: "pass", 2: "fail"}


def test_drives_of_a_scenario_have_one_control_period(pair: Path) -> None:
    scenario = ROOT / "configs" / "scenarios" / "reversal.toml"
    settings = (*LIGHT, "drive[2].drive.period_us=150")
    found = run(pair, "--scenario", scenario, settings=settings)
    assert found.returncode == 2
    assert "give the drives one drive.period_us" in found.stderr
