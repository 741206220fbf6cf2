"""Triggers and captures of the scope, on waveforms of which the instants are known."""

import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
from page_client import wait_for
from programs import ProgramProcess
from sextant_py import dds, telemetry_types
from sextant_py.errors import UserError
from sextant_py.paths import ROOT
from sextant_py.recording import formats
from sextant_py.recording.topics import STATE, WAVEFORM, group_of
from sextant_py.scope import files, program, quantities
from sextant_py.scope.capture import Capture
from sextant_py.scope.scope import Scope, Settings
from sextant_py.scope.trigger_text import parse
from sextant_py.signal_file import SignalFile
from sextant_py.telemetry_contract import enumerators
from topic_writer import Writer
from waveform_writer import WaveformWriter

PERIOD_NS = 25_000
BEGIN_NS = 7_000_000_000
STATES = enumerators("DriveStateKind")


def waveform(periods: int, **signals: np.ndarray | float) -> np.ndarray:
    rows = np.zeros(periods, group_of(WAVEFORM).dtype)
    rows["t_ns"] = BEGIN_NS + PERIOD_NS * np.arange(periods)
    rows["period_ns"] = PERIOD_NS
    rows["state"] = STATES.index("TORQUE")
    for name, values in signals.items():
        rows[name] = values
    return rows


def fed(scope: Scope, rows: np.ndarray, sizes: np.ndarray) -> list:
    """The captures of the rows, given in blocks of such sizes."""
    found = []
    for block in np.split(rows, np.cumsum(sizes)):
        found += scope.take(block)
    return found


def hit_periods(text: str, rows: np.ndarray, size: int = 400) -> list[int]:
    condition = parse(text)
    hits = [condition.hits(block) for block in np.split(rows, range(size, len(rows), size))]
    return np.flatnonzero(np.concatenate(hits)).tolist()


@pytest.mark.parametrize("size", [1, 7, 400, 5000])
def test_an_edge_is_the_first_period_beyond_the_level(size: int) -> None:
    period = np.arange(4000)
    current = 10.0 * np.sin(2.0 * np.pi * (period + 0.5) / 800)  # passes zero between two periods
    rows = waveform(4000, i_a_a=current)
    assert hit_periods("rise i_a_a 0", rows, size) == [800, 1600, 2400, 3200]
    assert hit_periods("fall i_a_a 0", rows, size) == [400, 1200, 2000, 2800, 3600]
    assert hit_periods("edge i_a_a 0", rows, size) == [400 * k for k in range(1, 10)]


def test_hysteresis_ignores_noise_around_the_level() -> None:
    seed = 20261123
    print(f"seed {seed}")
    noise = np.random.default_rng(seed).uniform(-1.0, 1.0, 8000)
    current = np.where(np.arange(8000) < 4000, 0.0, 5.0) + noise
    rows = waveform(8000, i_a_a=current)
    assert len(hit_periods("rise i_a_a 0", rows)) > 100
    assert hit_periods("rise i_a_a 2.5 2", rows) == [4000]


def test_levels_and_magnitudes() -> None:
    angle = np.linspace(0.0, 20.0, 1000)
    size = np.where(np.arange(1000) < 600, 3.0, 30.0)
    phases = {name: size * np.cos(angle - k * 2.0 * np.pi / 3.0) for k, name in enumerate(("i_a_a", "i_b_a", "i_c_a"))}
    rows = waveform(1000, **phases, flux_alpha_wb=0.6, flux_beta_wb=-0.8)
    np.testing.assert_allclose(quantities.values(rows, "current_a"), size, rtol=1e-5)
    np.testing.assert_allclose(quantities.values(rows, "flux_wb"), 1.0, rtol=1e-6)
    assert hit_periods("above current_a 29", rows) == list(range(600, 1000))
    assert hit_periods("below current_a 29", rows) == list(range(600))
    assert hit_periods("rise current_a 29", rows) == [600]


def test_nan_fulfils_nothing() -> None:
    rows = waveform(1000, i_a_a=np.nan)
    for text in ("above i_a_a 0", "below i_a_a 0", "edge i_a_a 0", "rise current_a 1"):
        assert hit_periods(text, rows) == []


def test_states() -> None:
    state = np.full(1000, STATES.index("TORQUE"))
    state[300:500] = STATES.index("DERATED")
    state[500:] = STATES.index("FAULT")
    rows = waveform(1000, state=state)
    assert hit_periods("state", rows, 100) == [300, 500]
    assert hit_periods("state=derated", rows, 100) == [300]
    assert hit_periods("fault", rows, 100) == [500]
    assert hit_periods("state READY", rows, 100) == []


@pytest.mark.parametrize("block", [1, 13, 400, 4000])
def test_a_torque_step_is_found_whatever_the_blocks(block: int) -> None:
    reference = np.zeros(4000)
    reference[1000:] = 10.0  # a step
    reference[2000:] += np.minimum(np.arange(2000) * 0.004, 5.0)  # a ramp of 0.16 N·m a millisecond
    reference[3500:] -= np.minimum(np.arange(500) * 0.5, 8.0)  # 8 N·m within 0.4 ms
    rows = waveform(4000, torque_reference_nm=reference)
    assert hit_periods("step 5", rows, block) == [1000, 3510]
    assert hit_periods("step 9", rows, block) == [1000]


def test_a_capture_has_every_period_around_its_trigger() -> None:
    state = np.full(20_000, STATES.index("TORQUE"))
    state[11_111:] = STATES.index("FAULT")
    rows = waveform(20_000, state=state, torque_nm=np.arange(20_000))
    scope = Scope(Settings("fault", "single", before_s=0.02, after_s=0.05))
    (capture,) = fed(scope, rows, np.full(49, 400))
    assert capture.trigger_ns == BEGIN_NS + 11_111 * PERIOD_NS
    np.testing.assert_array_equal(capture.rows["torque_nm"], np.arange(11_111 - 800, 11_111 + 2001))
    assert capture.times_s[0] == pytest.approx(-0.02)
    assert capture.times_s[-1] == pytest.approx(0.05)
    assert capture.periods_missing == 0
    assert scope.state == "stopped"


def test_captures_do_not_depend_on_the_blocks() -> None:
    seed = 11
    print(f"seed {seed}")
    random = np.random.default_rng(seed)
    rows = waveform(40_000, i_a_a=10.0 * np.sin(np.arange(40_000) / 300.0), torque_nm=np.arange(40_000))
    settings = Settings("rise i_a_a 3", "normal", before_s=0.003, after_s=0.07, hold_off_s=0.1)
    expected = [(c.trigger_ns, c.rows["torque_nm"].tolist()) for c in fed(Scope(settings), rows, np.array([40_000]))]
    assert len(expected) > 5
    for _ in range(5):
        sizes = random.integers(1, 900, 200)
        found = [(c.trigger_ns, c.rows["torque_nm"].tolist()) for c in fed(Scope(settings), rows, sizes)]
        assert found == expected


def test_hold_off_is_the_least_time_between_triggers() -> None:
    rows = waveform(100_000, i_a_a=np.sin(np.arange(100_000) / 20.0))
    for hold_off_s in (0.0, 0.2):
        settings = Settings("rise i_a_a 0", "normal", before_s=0.001, after_s=0.002, hold_off_s=hold_off_s)
        triggers = [capture.trigger_ns for capture in fed(Scope(settings), rows, np.full(249, 400))]
        distance_s = np.diff(triggers) * 1e-9
        turn_s = 2.0 * np.pi * 20.0 * PERIOD_NS * 1e-9
        assert np.all(distance_s > max(hold_off_s, 0.002))
        assert np.all(distance_s < max(hold_off_s, 0.002) + 2.0 * turn_s)


def test_auto_captures_without_a_trigger_and_normal_does_not() -> None:
    rows = waveform(100_000)
    assert fed(Scope(Settings("fault", "normal")), rows, np.full(249, 400)) == []
    captures = fed(Scope(Settings("fault", "auto", auto_s=0.5)), rows, np.full(249, 400))
    assert len(captures) == 4
    assert all(capture.trigger == "auto: no fault" for capture in captures)
    assert all(len(capture.rows) in (2800, 2801) for capture in captures)


def test_auto_takes_no_capture_in_a_gap_of_the_waveform() -> None:
    rows = np.delete(waveform(100_000), range(8000, 60_000))
    scope = Scope(Settings("fault", "auto", auto_s=0.5))
    captures = fed(scope, rows, np.full(119, 400))
    assert len(captures) == scope.captures == 2
    assert all(len(capture.rows) > 0 for capture in captures)


def test_missing_periods_are_counted() -> None:
    rows = np.delete(waveform(4000, torque_reference_nm=np.where(np.arange(4000) < 2000, 0.0, 10.0)), range(2100, 2150))
    (capture,) = fed(Scope(Settings("step 5", "single", 0.01, 0.02)), rows, np.full(8, 400))
    assert capture.periods_missing == 50


def test_a_drive_that_starts_again_starts_the_scope_again() -> None:
    rows = waveform(4000)
    again = waveform(8000, state=np.where(np.arange(8000) < 100, STATES.index("INIT"), STATES.index("FAULT")))
    again["t_ns"] -= 3_000_000_000
    scope = Scope(Settings("fault", "single", 0.02, 0.02))
    (capture,) = fed(scope, np.concatenate((rows, again)), np.full(29, 400))
    assert len(capture.rows) == 901, "no row of the drive before"


def test_a_capture_is_a_recording(tmp_path: Path) -> None:
    state = np.where(np.arange(8000) < 4000, STATES.index("TORQUE"), STATES.index("FAULT"))
    rows = waveform(8000, state=state, torque_nm=np.arange(8000))
    (capture,) = fed(Scope(Settings("fault", "single", 0.01, 0.01)), rows, np.full(19, 400))
    path = tmp_path / "capture.h5"
    states = np.zeros(3, group_of(STATE).dtype)
    states["t_ns"] = [BEGIN_NS, capture.trigger_ns, BEGIN_NS + 10**10]
    states["reason"] = [b"before", b"OVER_CURRENT", b"after"]
    files.write(path, capture, 3, states)
    with h5py.File(path) as file:
        np.testing.assert_array_equal(file["waveform/torque_nm"][:], np.arange(3600, 4401))
        assert file["waveform/torque_nm"].attrs["unit"] == "N·m"
        np.testing.assert_array_equal(file["waveform/t_ns"][:], capture.rows["t_ns"])
        assert file["drive_state/reason"][:].tolist() == [b"OVER_CURRENT"], "only what changed within the capture"
    np.testing.assert_allclose(SignalFile(path).groups["waveform"].time_s, capture.times_s, atol=1e-12)


def stepped(periods: int = 800) -> tuple[Capture, np.ndarray]:
    """A capture of a torque step, and a change of the state long before it."""
    rows = waveform(10 * periods, torque_reference_nm=np.where(np.arange(10 * periods) < 5 * periods, 0.0, 10.0))
    half_s = periods * PERIOD_NS * 0.5e-9
    (capture,) = fed(Scope(Settings("step 5", "single", half_s, half_s)), rows, np.full(19, periods // 2))
    states = np.zeros(1, group_of(STATE).dtype)
    states["t_ns"] = BEGIN_NS
    return capture, states


@pytest.mark.parametrize("suffix", formats.SUFFIXES)
def test_a_capture_without_a_change_of_state_is_readable(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"step{suffix}"
    capture, states = stepped()
    inside = states.copy()
    inside["t_ns"] = capture.trigger_ns
    files.write(path, capture, 3, inside)
    assert path.is_file()
    assert set(SignalFile(path).groups) == {"waveform", "drive_state"}
    files.write(path, capture, 3, states)
    file = SignalFile(path)
    assert set(file.groups) == {"waveform"}, "no state, and none of the file that was replaced"
    np.testing.assert_array_equal(file.signals(["waveform"]).values["torque_nm"], capture.rows["torque_nm"])
    np.testing.assert_allclose(file.groups["waveform"].time_s, capture.times_s, atol=1e-9)


FILL_A_DISK = """
import resource, sys
from pathlib import Path
from sextant_py.errors import run
from sextant_py.scope import files
from test_scope import stepped

def fill(arguments):
    capture, states = stepped(40_000)
    states["t_ns"] = capture.trigger_ns
    resource.setrlimit(resource.RLIMIT_FSIZE, (int(arguments[1]), resource.RLIM_INFINITY))
    files.write(Path(arguments[0]), capture, 3, states)

run("scope", fill)
"""


@pytest.mark.parametrize("suffix", formats.SUFFIXES)
@pytest.mark.parametrize("room", [100, 60_000])
def test_a_full_disk_leaves_no_part_of_a_capture(tmp_path: Path, suffix: str, room: int) -> None:
    path = tmp_path / f"capture{suffix}"
    files.write(path, stepped()[0], 3)
    before = {file.name for file in tmp_path.iterdir()}
    folders = f"{ROOT / 'scripts'}:{ROOT / 'tests' / 'python'}"
    environment = {**os.environ, "PYTHONPATH": folders, "PYTHONDONTWRITEBYTECODE": "1"}  # it would be cut as well
    command = [sys.executable, "-c", FILL_A_DISK, str(path), str(room)]
    ended = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=300)
    assert ended.returncode == 1, ended.stderr
    assert re.fullmatch(
        f"scope: the capture {path} cannot be written: [^:;]+; nothing of it is kept.\n", ended.stderr
    ), ended.stderr
    assert {file.name for file in tmp_path.iterdir()} == before
    assert len(SignalFile(path).groups["waveform"].time_s) == 801, "the file before stays"


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", "is empty"),
        ("falut", "is not known"),
        ("rise i_a 30", "the nearest are i_._a"),
        ("rise i_a_a much", 'has "much" where a number is expected'),
        ("rise torque_nm nan", 'has "nan" where a number is expected'),
        ("above torque_nm inf", 'has "inf" where a number is expected'),
        ("edge torque_nm 5 -1", "a hysteresis below zero"),
        ("step nan", 'has "nan" where a number is expected'),
        ("state TORK", "the nearest is TORQUE"),
        ("step -1", "a size that is not above zero"),
    ],
)
def test_a_wrong_trigger_is_one_sentence(text: str, sentence: str) -> None:
    with pytest.raises(UserError, match=sentence):
        parse(text)


@pytest.mark.parametrize(
    ("settings", "sentence"),
    [
        (Settings(before_s=0.0, after_s=0.0), "there is nothing to capture"),
        (Settings(after_s=-1.0), "after the trigger must be from 0"),
        (Settings(mode="once"), "none of auto, normal, single"),
        *((Settings(auto_s=auto_s), "mode auto must be above 0 s") for auto_s in (0.0, -50.0, np.nan, np.inf)),
    ],
)
def test_wrong_settings_are_one_sentence(settings: Settings, sentence: str) -> None:
    with pytest.raises(UserError, match=sentence):
        Scope(settings)


def test_no_sample_of_a_drive_names_the_drives_that_are_there(domain: int) -> None:
    kind = telemetry_types.struct("DriveState")
    watch = program.Watch(program.parse_arguments(["--domain", str(domain), "--drive", "9"]))

    def reason() -> str:
        watch.poll()
        return watch.reason()

    with WaveformWriter(domain), Writer(domain, dds.STATE, kind, dds.latched_qos(), drive_id=7):
        expected = f"no sample of drive 9 arrived in domain {domain}; drives there: 7."
        wait_for(lambda: reason() == expected, "the drive that is there", reason)
    watch.close()


def scope_process(domain: int, folder: Path, *arguments: str) -> ProgramProcess:
    command = [ROOT / "scripts" / "scope", "--domain", str(domain), "--out", folder / "capture.h5", *arguments]
    return ProgramProcess(command, folder / "scope.txt")


def test_a_drive_that_sends_without_a_trigger_has_no_reason(domain: int, tmp_path: Path) -> None:
    with WaveformWriter(domain), scope_process(domain, tmp_path) as scope:
        wait_for(lambda: "drive 7, waiting for: fault" in scope.text(), "the waveform", scope.text)
        scope.send_signal(signal.SIGINT)
        assert scope.wait(30.0) == 1
    assert scope.text().endswith("scope: ended before the trigger (fault): nothing was written.\n")


def test_the_line_of_a_capture_from_its_trigger_on(domain: int, tmp_path: Path) -> None:
    with WaveformWriter(domain), scope_process(domain, tmp_path, "--trigger", "step 5", "--before", "0") as scope:
        assert scope.wait(60.0) == 0
    assert ", 0.000 ms before to 50.000 ms after the trigger (step 5)" in scope.text()


@pytest.mark.parametrize("time_s", ["0", "-1", "nan", "inf", "soon"])
def test_a_timeout_that_is_no_time_above_zero_is_refused(time_s: str, capsys: pytest.CaptureFixture) -> None:
    with pytest.raises(SystemExit):
        program.parse_arguments([f"--timeout={time_s}"])
    assert f'argument --timeout: expected a time above 0 s, got "{time_s}"' in capsys.readouterr().err
