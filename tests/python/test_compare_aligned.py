"""Recordings compared signal by signal from a trigger on: the instant, tolerances, faults; bad input."""

import json
from pathlib import Path

import made_recording
import numpy as np
import pytest
from sextant_py import alignment, compare
from sextant_py.comparison import OUT
from sextant_py.errors import status_or_refusal
from sextant_py.recording.formats import SUFFIXES
from sextant_py.recording.model import MAIN
from sextant_py.recording.topics import STATE, WAVEFORM, group_of
from sextant_py.scope import files
from sextant_py.scope.scope import Scope, Settings
from sextant_py.scope.trigger_text import FORMS
from sextant_py.signal_file import SignalFile
from sextant_py.telemetry_contract import enumerators

STATES = enumerators("DriveStateKind")
STEP_NS = 1_000_000
TORQUE, SPEED, FLUX = 20.0, 50.0, 1.1
FAULTS = ((7, 0.3), (9, 0.4))  # bit and time from the step [s]


def drive(
    begin_ns: int = 0,
    step_s: float = 0.5,
    phase: float = 0.0,
    delay_s: float = 0.0,
    offset: float = 0.0,
    faults: tuple[tuple[int, float], ...] = (),
    state: int = 4,
) -> made_recording.MadeSource:
    """Telemetry of 1.2 s: the torque rises at step_s with a time constant of 20 ms, the speed with it from 30 ms later.

    phase: of the rows between two control instants, as a share; delay_s: of the speed; offset: of the torque.
    """
    rows = np.zeros(1200, group_of(MAIN).dtype)
    count = np.arange(len(rows))
    rows["t_ns"] = begin_ns + np.rint((count + phase) * STEP_NS)
    t_s = (count + phase) * STEP_NS * 1e-9 - step_s
    torque = np.where(t_s > 0, TORQUE * -np.expm1(-np.maximum(t_s, 0) / 0.02), 0.0) + offset
    rows["torque_mean_nm"], rows["torque_min_nm"], rows["torque_max_nm"] = torque, torque - 1, torque + 1
    rows["torque_reference_nm"] = np.where(t_s > 0, TORQUE, 0.0)
    rows["speed_rad_s"] = SPEED * np.maximum(t_s - 0.03 - delay_s, 0)
    rows["flux_mean_wb"], rows["flux_angle_rad"] = FLUX, 7.0 * t_s
    rows["u_dc_v"], rows["state"] = 530.0, state
    states = np.zeros(1 + len(faults), group_of(STATE).dtype)
    states["t_ns"], states["first_fault"], latched = begin_ns, -1, 0
    for row, (bit, after_s) in zip(states[1:], faults, strict=True):
        latched |= 1 << bit
        row["t_ns"] = begin_ns + round((step_s + after_s) * 1e9)
        row["faults_latched"], row["first_fault"], row["state"] = latched, faults[0][0], 6
    return made_recording.MadeSource({MAIN: rows, STATE: states}, [group_of(MAIN), group_of(STATE)])


def run(capsys: pytest.CaptureFixture, *words: object) -> tuple[int, dict[str, dict], str]:
    """Exit status, rows by their names, and standard error."""
    status = status_or_refusal("compare", lambda: compare.main([*map(str, words), "--json"]))
    said = capsys.readouterr()
    rows = json.loads(said.out[said.out.index("{") :])["rows"] if "{" in said.out else []
    return status, {row["metric"]: row for row in rows}, said.err


def out(rows: dict[str, dict]) -> list[str]:
    return [name for name, row in rows.items() if row["result"] == OUT]


@pytest.mark.parametrize("seed", range(5))
def test_the_same_course_at_another_time_and_phase_agrees(
    seed: int, tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    print(f"seed {seed}")
    random = np.random.default_rng(seed)
    suffix = SUFFIXES[seed % len(SUFFIXES)]
    a, b = tmp_path / "a.h5", tmp_path / f"b{suffix}"
    made_recording.write(drive(faults=FAULTS), a)
    begin_ns, step_s, phase = int(random.integers(10**12)), random.uniform(0.3, 0.6), random.uniform()
    moved = {"begin_ns": begin_ns, "step_s": step_s, "phase": phase, "faults": FAULTS}
    made_recording.write(drive(**moved), b)
    status, rows, _ = run(capsys, a, b, "--align", "rise torque_nm 10")
    assert (status, out(rows)) == (0, [])
    assert rows["trigger_s"]["first"] == pytest.approx(0.5 + 0.02 * np.log(2), abs=1.1e-3)
    assert {"state", "torque_mean_nm", "speed_rad_s", "u_dc_v", "faults"} < rows.keys()
    assert not {"t_ns", "flux_angle_rad", "i_a_a", "sequence"} & rows.keys()
    # What is 10 ms late is seen in the signal that is: 0.5 rad/s, of 33.5 rad/s at the end.
    made_recording.write(drive(**moved, delay_s=0.01), b)
    status, rows, _ = run(capsys, a, b, "--align", "rise torque_nm 10")
    assert (status, out(rows)) == (1, ["speed_rad_s"])


def test_near_zero_a_share_is_of_the_scale_of_the_signal(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    """Before the step the torque is zero: 1 % of 20 N·m is allowed there, and an amount is an amount."""
    made_recording.write(drive(), tmp_path / "a.h5")
    torque = ["--align", "rise torque_reference_nm 10", "--signal", "torque_mean_nm", "--to", "-0.05"]
    for offset, tolerance, status in ((0.19, "1%", 0), (0.21, "1%", 1), (-0.21, "1%", 1), (0.21, "0.22", 0)):
        made_recording.write(drive(offset=offset), tmp_path / "b.h5")
        options = ["--tolerance", f"torque_mean_nm={tolerance}"]
        found, rows, _ = run(capsys, tmp_path / "a.h5", tmp_path / "b.h5", *torque, *options)
        assert found == status, (offset, tolerance)
        assert rows["torque_mean_nm"]["second"] == pytest.approx(offset, abs=1e-6)
        assert abs(rows["torque_mean_nm"]["first"]) < 1e-9


def test_faults_and_their_times_count_from_the_trigger(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    a, b = tmp_path / "a.h5", tmp_path / "b.mcap"
    made_recording.write(drive(faults=FAULTS), a)
    cases = {
        "same": (FAULTS, []),
        "late": ((FAULTS[0], (9, 0.405)), ["fault DC_OVER_VOLTAGE"]),
        "other": ((FAULTS[0], (10, 0.4)), ["faults"]),
        "one": (FAULTS[:1], ["faults"]),
        "order": (((9, 0.3), (7, 0.4)), ["faults"]),
    }
    from sextant_py.drive_view import fault_names

    cases["late"] = (cases["late"][0], [f"fault {fault_names(1 << 9)[0]}"])
    for name, (faults, wrong) in cases.items():
        made_recording.write(drive(begin_ns=10**10, step_s=0.6, faults=faults), b)
        status, rows, _ = run(capsys, a, b, "--align", "rise torque_reference_nm 10")
        assert (out(rows), status) == (wrong, int(bool(wrong))), name
        assert rows["faults"]["first"] == ", ".join(fault_names(1 << bit)[0] for bit, _ in FAULTS)
    options = ["--align", "rise torque_reference_nm 10"]
    made_recording.write(drive(faults=cases["late"][0]), b)
    assert run(capsys, a, b, *options, "--tolerance", "fault_s=5e-3")[0] == 0
    assert run(capsys, a, b, *options, "--to", "0.35")[0] == 0  # the second fault is not in that time


def test_another_state_and_a_missing_signal_are_out(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    made_recording.write(drive(), tmp_path / "a.h5")
    made_recording.write(drive(state=5), tmp_path / "b.h5")
    status, rows, _ = run(capsys, tmp_path / "a.h5", tmp_path / "b.h5", "--align", "rise torque_reference_nm 10")
    assert (status, out(rows)) == (1, ["state"])
    assert (rows["state"]["first"], rows["state"]["second"]) == (4, 5)


def test_a_value_that_is_missing_is_out(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    a, b = drive(), drive()
    b._blocks[MAIN]["u_dc_v"][700] = np.nan
    made_recording.write(a, tmp_path / "a.h5")
    made_recording.write(b, tmp_path / "b.h5")
    files_of = tmp_path / "a.h5", tmp_path / "b.h5"
    status, rows, _ = run(capsys, *files_of, "--align", "rise torque_reference_nm 10")
    assert (status, out(rows), rows["u_dc_v"]["second"]) == (1, ["u_dc_v"], None)
    assert run(capsys, tmp_path / "b.h5", tmp_path / "b.h5", "--align", "rise torque_reference_nm 10")[0] == 0


def random_waveform(seed: int) -> np.ndarray:
    """A course with a rising and a falling edge of every signal that a trigger can evaluate."""
    random = np.random.default_rng(seed)
    rows = np.zeros(4000, group_of(WAVEFORM).dtype)
    rows["t_ns"] = 7_000_000_000 + 25_000 * np.arange(len(rows))
    rows["period_ns"] = 25_000
    turn = 2 * np.pi * np.arange(len(rows)) / 700
    for name in rows.dtype.names:
        if rows.dtype[name].kind == "f":
            rows[name] = 10 * np.sin(turn + random.uniform(0, 6)) + random.standard_normal(len(rows))
    rows["state"] = np.where(np.arange(len(rows)) < 2500, STATES.index("TORQUE"), STATES.index("FAULT"))
    return rows


TEXTS = ("fault", "state", "state FAULT", "step 3", "rise i_a_a 2 1", "fall torque_nm -3 2", "edge speed_rad_s 1 0.5",
         "above current_a 11", "below flux_wb 6")  # fmt: skip


@pytest.mark.parametrize("text", TEXTS)
def test_a_trigger_is_that_of_the_scope(text: str, tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    seed = 20261126
    print(f"seed {seed}")
    rows = random_waveform(seed)
    made_recording.write(made_recording.MadeSource({WAVEFORM: rows}, [group_of(WAVEFORM)]), tmp_path / "whole.h5")
    (capture,) = Scope(Settings(text, "single", 0.0, 0.005)).take(rows)
    found_s, _ = alignment.instant(tmp_path / "whole.h5", SignalFile(tmp_path / "whole.h5"), text)
    assert found_s == pytest.approx((capture.trigger_ns - 7_000_000_000) * 1e-9, abs=1e-12)
    # The capture agrees with the recording that it is from, by its own trigger and by the same text where that holds.
    files.write(tmp_path / "capture.h5", capture, 3)
    assert run(capsys, tmp_path / "capture.h5", tmp_path / "capture.h5", "--align", "trigger")[0] == 0


def test_every_form_of_a_trigger_is_tested() -> None:
    assert {form.split()[0] for form in FORMS} == {text.split()[0] for text in TEXTS}


def test_bad_input_has_status_2(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    made_recording.write(drive(), tmp_path / "a.h5")
    (tmp_path / "dir").mkdir()
    (tmp_path / "text.h5").write_text("x")
    a, rise = tmp_path / "a.h5", ("--align", "rise torque_nm 10")
    made_recording.write(drive(step_s=9.0), tmp_path / "flat.h5")
    for words, said in (
        ((a, tmp_path / "none.h5", *rise), "none.h5 does not exist."),
        ((a, tmp_path / "dir", *rise), "holds no trace.h5, which --align compares."),
        ((a, tmp_path / "text.h5", *rise), "text.h5"),
        ((a, tmp_path / "flat.h5", *rise), 'the trigger "rise torque_nm 10" is not fulfilled in'),
        ((a, a, "--align", "rise torque_nm"), 'the trigger "rise torque_nm" is not known; a trigger is one of'),
        ((a, a, "--align", "rise torqe_nm 1"), 'the waveform has no signal "torqe_nm"; the nearest are torque_nm'),
        ((a, a, "--align", "rise duty_a 0.5"), "has no signal duty_a, which the trigger"),
        ((a, a, "--align", "trigger"), "is no capture, so it has no trigger of its own"),
        ((a, a, *rise, "--signal", "tork"), 'has no signal "tork"'),
        ((a, a, *rise, "--tolerance", "tork=1"), 'no signal "tork" is compared'),
        ((a, a, *rise, "--from", "5"), "--from and --to leave nothing of the common time"),
        ((a, a, "--signal", "torque"), "--signal, --from and --to are for --align"),
    ):
        status, _, refused = run(capsys, *words)
        assert (status, said in refused, refused.count("\n")) == (2, True, 1), (words, refused)


@pytest.mark.parametrize("option", ("--from", "--to"))
def test_a_time_that_is_no_number_is_refused(option: str) -> None:
    with pytest.raises(SystemExit) as ended:
        compare.main(["a.h5", "b.h5", "--align", "trigger", option, "nan"])
    assert ended.value.code == 2
