"""What the drive sends over CAN: decodes by the contract, is protected, keeps its cycle, and agrees with DDS."""

import time
from collections.abc import Callable
from pathlib import Path

import e2e.p11 as reference
import numpy as np
import pytest
from attempts import commands_apart, undisturbed
from drive_process import DriveProcess
from frame_log import FrameLog, RawFrame
from handling import bring_up, regain
from sextant_py.contract import Contract
from telemetry_record import Span, TelemetryRecord
from vehicle import Vehicle

TORQUE_NM = 25.0
SPEED_RAD_S = 30.0
LISTEN_S = 3.2
STARTING_S = 0.5  # of candump
PROTECTED = {"MCU_TorqueStatus", "MCU_Motion", "MCU_Capability"}
CYCLES_MS = {
    "MCU_TorqueStatus": 10,
    "MCU_Motion": 10,
    "MCU_Electrical": 10,
    "MCU_Capability": 100,
    "MCU_Faults": 100,
    "MCU_RealTime": 1000,
    "MCU_Temperatures": 100,
}


def recorded(log: FrameLog, record: TelemetryRecord) -> tuple[dict[str, list[RawFrame]], Span]:
    """The drive's frames by name, and the telemetry of the same time."""
    names = {message.frame_id: message.name for message in Contract().database.messages}
    # Telemetry of every moment in which a frame may have been made.
    record.run(0.1)
    first = len(record.samples)
    first = max(first - round(0.1 * 1e9 / Span(record.samples).interval_ns), 0)
    with log:
        begin_s = time.time() + STARTING_S
        record.run(LISTEN_S + STARTING_S)
        end_s = time.time()
        record.run(0.1)
        frames = log.until(end_s)
    span = Span(record.samples[first:])
    by_name: dict[str, list[RawFrame]] = {}
    for frame in frames:
        if frame.time_s >= begin_s:
            by_name.setdefault(names[frame.frame_id], []).append(frame)
    return by_name, span


def test_status_frames(live_bus: str, domain: int, tmp_path: Path, start_drive: Callable[..., DriveProcess]) -> None:
    start_drive(live_bus, "load.kind=imposed_speed", f"load.speed_rad_s.value={SPEED_RAD_S:g}")
    record = TelemetryRecord(domain)
    log = FrameLog(live_bus, tmp_path)
    with Vehicle(live_bus) as vehicle:
        bring_up(record, vehicle, TORQUE_NM)
        record.run(0.5)
        frames, span = undisturbed(
            "status frames",
            lambda: recorded(log, record),
            lambda found: commands_apart(found[1]),
            lambda: regain(record, vehicle, TORQUE_NM),
        )
    assert set(frames) == {*CYCLES_MS, "VCU_TorqueCommand"}
    check_cycles(frames)
    for name in PROTECTED:
        check_protection(name, frames[name])
    signals = {name: decoded(name, frames[name]) for name in CYCLES_MS}
    check_torque_status(signals["MCU_TorqueStatus"], span)
    check_motion(signals["MCU_Motion"], span)
    check_electrical(signals["MCU_Electrical"], span)
    check_slow_frames(signals)


def decoded(name: str, frames: list[RawFrame]) -> dict[str, np.ndarray]:
    """The signals by the contract, in the words of its value tables where it has any; an array each."""
    message = Contract().message(name)
    rows = [message.decode(frame.data) for frame in frames]
    return {
        key: np.array([str(row[key]) if hasattr(row[key], "name") else row[key] for row in rows]) for key in rows[0]
    }


def check_cycles(frames: dict[str, list[RawFrame]]) -> None:
    for name, cycle_ms in CYCLES_MS.items():
        times_ms = np.array([frame.time_s for frame in frames[name]]) * 1e3
        assert len(times_ms) >= 0.9 * LISTEN_S * 1000 / cycle_ms - 1, name
        intervals_ms = np.diff(times_ms)
        print(f"{name}: {len(times_ms)} frames, {intervals_ms.mean():.2f} ms apart, at most {intervals_ms.max():.1f}")
        assert intervals_ms.mean() == pytest.approx(cycle_ms, rel=0.05), name


def check_protection(name: str, frames: list[RawFrame]) -> None:
    """CRC by an implementation that is not ours; the counter without a gap."""
    data_id = Contract().data_id(name)
    for frame in frames:
        assert len(frame.data) == 8
        ours = bytearray(frame.data)
        assert reference.e2e_p11_check(ours, data_id, data_id_mode=reference.E2E_P11_DATAID_NIBBLE), frame
    counters = np.array([frame.data[1] & 0x0F for frame in frames])
    assert counters.max() <= 14
    assert np.all((counters[1:] - counters[:-1]) % 15 == 1), f"{name}: {counters}"


def check_torque_status(status: dict[str, np.ndarray], span: Span) -> None:
    assert set(status["DriveState"]) == {"TORQUE"} == set(span.states)
    assert not status["Lockout"].any()
    # A command that the host held up for 40 ms makes the drive begin its ramp; frames and telemetry both show it.
    assert np.mean(np.abs(status["TorqueAdmitted"] - TORQUE_NM) < 0.011) > 0.95
    assert np.mean(np.abs(span.torque_reference_nm - TORQUE_NM) < 0.011) > 0.95
    estimated = status["TorqueEstimated"]
    assert span.torque_min_nm.min() - 0.01 <= estimated.min()
    assert estimated.max() <= span.torque_max_nm.max() + 0.01
    # Single values of a torque that swings by several N·m: their mean is uncertain by its standard error.
    uncertain_nm = 5 * estimated.std() / np.sqrt(len(estimated))
    assert estimated.mean() == pytest.approx(span.torque_mean_nm.mean(), abs=uncertain_nm)
    assert uncertain_nm < 1.5
    # Commands come about as often as frames go.
    echo = status["CommandCounter"].astype(int)
    steps = (echo[1:] - echo[:-1]) % 15
    assert steps.max() <= 4
    assert steps.mean() == pytest.approx(1.0, abs=0.05)


def check_motion(motion: dict[str, np.ndarray], span: Span) -> None:
    assert motion["Speed"] == pytest.approx(SPEED_RAD_S * 30 / np.pi, abs=0.5)
    assert set(motion["Direction"]) == {"FORWARD"}
    assert span.flux_min_wb.min() - 1e-4 <= motion["FluxMagnitude"].min()
    assert motion["FluxMagnitude"].max() <= span.flux_max_wb.max() + 1e-4


def check_electrical(electrical: dict[str, np.ndarray], span: Span) -> None:
    assert electrical["DcVoltage"] == pytest.approx(530.0, abs=0.02)
    peak_a = electrical["PhaseCurrentRms"] * np.sqrt(2)
    assert span.current_min_a.min() - 0.03 <= peak_a.min()
    assert peak_a.max() <= span.current_max_a.max() + 0.03
    assert peak_a.mean() == pytest.approx(span.current_mean_a.mean(), rel=0.05)
    # The power on the shaft and the copper losses come out of the link.
    shaft_w = span.torque_mean_nm.mean() * SPEED_RAD_S
    assert span.power_w.mean() > shaft_w
    power_w = electrical["ElectricalPower"]
    assert power_w.mean() == pytest.approx(span.power_w.mean(), abs=5 * power_w.std() / np.sqrt(len(power_w)) + 10)


def check_slow_frames(signals: dict[str, dict[str, np.ndarray]]) -> None:
    assert set(signals["MCU_Capability"]["TorqueMotoring"]) == {150.0}
    faults = signals["MCU_Faults"]
    assert set(faults["FirstFault"]) == {"NONE"}
    assert not any(faults[key].any() for key in faults if key.startswith(("Active", "Latched")))
    assert np.all(signals["MCU_RealTime"]["TelemetryDropped"] == 0)
