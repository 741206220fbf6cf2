"""Parameters of a running drive: in virtual time, and what scripts/set and scripts/get make of replies."""

import re
import subprocess
from pathlib import Path

import pytest
from programs import overrides, program
from sextant_py import get, inject
from sextant_py import set as setter
from sextant_py.errors import UserError
from sextant_py.paths import ROOT
from test_inject import Program

FOC = ROOT / "configs" / "ecu_foc.toml"
LISTED = (
    '[{"key": "protection.over_current_a", "unit": "A", "meaning": "limit", "least": 0.1, "most": 100000, '
    '"changes": "always", "value": 224},\n'
    '{"key": "drive.period_us", "unit": "us", "meaning": "period", "least": 1, "most": 1e5, "changes": "never", '
    '"value": 25}]'
)


@pytest.fixture(scope="module")
def profile(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("set") / "profile.csv"
    file.write_text("time_s,torque_nm\n0,0\n0.1,140\n0.8,140\n", encoding="utf-8")
    return file


def run(profile: Path, *words: str) -> subprocess.CompletedProcess:
    command = [program("sextant-ecu"), FOC, "--virtual-time", "--profile", profile, *words]
    command += overrides(("plant.integrator=fixed", "drive.period_us=100"))
    command += overrides(("load.kind=imposed_speed", "load.speed_rad_s.value=40"))
    return subprocess.run(command, capture_output=True, text=True, timeout=120, stdin=subprocess.DEVNULL)


def digest(found: subprocess.CompletedProcess) -> str:
    return re.search(r"^digest .*$", found.stdout, re.MULTILINE).group()


def test_a_limit_below_the_current_trips_the_drive_under_torque(profile: Path) -> None:
    plain = run(profile)
    assert plain.returncode == 0, plain.stderr
    assert "0 faults" in plain.stdout
    late = run(profile, "--set-at", "0.7:protection.over_current_a=32")
    assert "first OVER_CURRENT" in late.stdout, late.stderr
    assert late.returncode == 3
    line = re.search(r"^parameters 1 at 0.7 s: (.*)$", late.stdout, re.MULTILINE).group(1)
    assert re.search(r"protection\.over_current_a from \S+ to 32", line)
    assert re.search(r"drive\.current_limit_a from \S+ to 25\.6", line), "what follows from it changes with it"


def test_a_gain_that_is_set_before_the_first_period_is_that_of_the_file(profile: Path) -> None:
    """Bit by bit; and set later it makes another run from there on."""
    gain = "control.foc.bandwidth_rad_s=900"
    started = run(profile, "--set", gain)
    assert digest(run(profile, "--set-at", f"0:{gain}")) == digest(started)
    later = run(profile, "--set-at", f"0.6:{gain}")
    assert later.returncode == 0, later.stderr
    assert digest(later) not in {digest(started), digest(run(profile))}
    assert digest(later) == digest(run(profile, "--set-at", f"0.6:{gain}")), "equal input, equal bits"


@pytest.mark.parametrize(
    ("setting", "sentence"),
    [
        ("0.6:control.flux_reference_wb=0.9", r"--set-at 0\.6: control\.flux_reference_wb changes only with the gates"),
        ("0.6:drive.period_us=50", r"--set-at 0\.6: drive\.period_us never changes while the drive runs"),
        ("100:protection.over_current_a=200", r"--set-at 100: the run ended before it, at "),
        ("0.6:protection.over_curent_a=50", "unknown key; the nearest known one is protection.over_current_a"),
        ("0.6:protection.over_current_a=-5", "protection.over_current_a: expected a number from 0.1 to 100000"),
        ("soon:protection.over_current_a=50", "expected TIME:KEY=VALUE with a time in seconds"),
    ],
)
def test_what_is_refused_ends_the_run_with_a_sentence(profile: Path, setting: str, sentence: str) -> None:
    found = run(profile, "--set-at", setting)
    assert found.returncode == 2, found.stdout
    assert re.search(sentence, found.stderr)


def test_a_reply_names_every_value_that_has_changed(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    drive = Program(
        tmp_path / "set", "ok\nprotection.over_current_a from 224 to 80\ndrive.current_limit_a from 179 to 64"
    )
    assert setter.main([str(tmp_path / "set"), "protection.over_current_a=80"]) == 0
    drive.end()
    assert drive.request == "protection.over_current_a=80"
    assert capsys.readouterr().out.splitlines()[1] == "drive.current_limit_a from 179 to 64"


def test_a_refusal_is_one_sentence(tmp_path: Path) -> None:
    drive = Program(tmp_path / "set", "drive.period_us never changes while the drive runs: start it anew with --set")
    with pytest.raises(UserError, match=r"^the change is refused: drive.period_us never changes"):
        setter.set_parameters(tmp_path / "set", {"drive.period_us": 50})
    drive.end()
    with pytest.raises(UserError, match="no key is set"):
        setter.set_parameters(tmp_path / "set", {})
    with pytest.raises(UserError, match=r"no drive takes parameters on .*; start sextant-ecu with --set-socket"):
        setter.set_parameters(tmp_path / "none", {"drive.period_us": 50})
    with pytest.raises(UserError, match=r"no program takes faults on .*; start sextant-ecu or sextant-plant"):
        inject.inject(tmp_path / "none", "none")


def test_the_list_says_when_a_key_may_change(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    drive = Program(tmp_path / "set", LISTED)
    assert get.main([str(tmp_path / "set"), "protection"]) == 0
    drive.end()
    assert drive.request == "describe"
    assert capsys.readouterr().out == "always     protection.over_current_a = 224 A  (0.1 to 100000)\n"
    (tmp_path / "set").unlink()
    drive = Program(tmp_path / "set", LISTED)
    with pytest.raises(UserError, match=r"drive.perid_us: unknown key; the nearest known one is drive.period_us"):
        get.main([str(tmp_path / "set"), "drive.perid_us"])
    drive.end()
