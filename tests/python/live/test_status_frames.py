"""What the drive sends over CAN: decodes by the contract, is protected, complete, and agrees with DDS.

That the messages keep their cycles is claimed in virtual time (tests/python/test_virtual_time.py).
"""

from collections.abc import Callable
from pathlib import Path

import e2e.p11 as reference
import numpy as np
import pytest
from drive_process import DriveProcess
from frame_log import FrameLog, RawFrame
from handling import at_torque, untripped
from sextant_py.contract import Contract
from telemetry_record import Span, TelemetryRecord
from vehicle import Vehicle

TORQUE_NM = 25.0
SPEED_RAD_S = 30.0
LISTEN_S = 3.5
MESSAGES = Contract().messages_of_the_drive()
CYCLES_MS = {name: message.cycle_time for name, message in MESSAGES.items()}
PROTECTED = [name for name in MESSAGES if Contract().data_id(name) is not None]


def recorded(log: FrameLog, record: TelemetryRecord) -> tuple[dict[str, list[RawFrame]], Span]:
    """The frames of some seconds in TORQUE by name, and the telemetry of the same time and a little around it."""
    names = {message.frame_id: message.name for message in Contract().database.messages}
    first = len(record.samples)
    record.run(0.2)
    with log:
        record.run(LISTEN_S)
        frames = log.frames()
    record.run(0.2)
    by_name: dict[str, list[RawFrame]] = {}
    for frame in frames:
        by_name.setdefault(names[frame.frame_id], []).append(frame)
    return by_name, Span(record.samples[first:])


@pytest.mark.kernel_can
def test_status_frames(live_bus: str, domain: int, tmp_path: Path, start_drive: Callable[..., DriveProcess]) -> None:
    start_drive(live_bus, "load.kind=imposed_speed", f"load.speed_rad_s.value={SPEED_RAD_S:g}")
    record = TelemetryRecord(domain)
    with Vehicle(live_bus) as vehicle:
        frames, span = untripped(
            record,
            lambda: at_torque(record, vehicle, TORQUE_NM),
            lambda: recorded(FrameLog(live_bus, tmp_path), record),
        )
    assert set(frames) == {*CYCLES_MS, "VCU_TorqueCommand"}
    check_counts(frames)
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


def check_counts(frames: dict[str, list[RawFrame]]) -> None:
    """As often as their cycles, one beside the other; what a machine leaves out it leaves out of all."""
    fastest = len(frames["MCU_TorqueStatus"])
    for name, cycle_ms in CYCLES_MS.items():
        print(f"{name}: {len(frames[name])} frames")
        assert len(frames[name]) >= 0.5 * fastest * CYCLES_MS["MCU_TorqueStatus"] / cycle_ms - 1, name
        assert len(frames[name]) <= 2 * fastest * CYCLES_MS["MCU_TorqueStatus"] / cycle_ms + 2, name


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


def near(found: np.ndarray, expected: np.ndarray, tolerance: float, what: str) -> None:
    """The middle of both; neither half of the samples is that beside a gap of the machine's."""
    assert np.median(found) == pytest.approx(np.median(expected), abs=tolerance), what


def mostly_within(values: np.ndarray, lowest: float, highest: float) -> bool:
    """A sample of telemetry that was lost on its way may have held the extreme."""
    return bool(np.mean((values >= lowest) & (values <= highest)) >= 0.95)


def check_torque_status(status: dict[str, np.ndarray], span: Span) -> None:
    assert set(status["DriveState"]) == {"TORQUE"} == set(span.states)
    assert not status["Lockout"].any()
    assert np.all(np.abs(status["TorqueReference"] - TORQUE_NM) < 0.011)
    assert np.all(np.abs(span.torque_reference_nm - TORQUE_NM) < 0.011)
    estimated = status["TorqueEstimated"]
    assert mostly_within(estimated, span.torque_min_nm.min() - 0.01, span.torque_max_nm.max() + 0.01)
    near(estimated, span.torque_mean_nm, 4.0, "torque")
    # It tells of every command of a vehicle that counts to 15.
    assert set(status["CommandCounter"].astype(int)) == set(range(15))


def check_motion(motion: dict[str, np.ndarray], span: Span) -> None:
    assert motion["Speed"] == pytest.approx(SPEED_RAD_S * 30 / np.pi, abs=0.5)
    assert set(motion["Direction"]) == {"FORWARD"}
    assert mostly_within(motion["FluxMagnitude"], span.flux_min_wb.min() - 1e-4, span.flux_max_wb.max() + 1e-4)


def check_electrical(electrical: dict[str, np.ndarray], span: Span) -> None:
    assert electrical["DcVoltage"] == pytest.approx(530.0, abs=0.02)
    peak_a = electrical["PhaseCurrentRms"] * np.sqrt(2)
    assert mostly_within(peak_a, span.current_min_a.min() - 0.03, span.current_max_a.max() + 0.03)
    near(peak_a, span.current_mean_a, 0.1 * np.median(span.current_mean_a), "current")
    # The power on the shaft and the copper losses come out of the link.
    assert np.mean(span.power_w) > 0.8 * np.mean(span.torque_mean_nm) * SPEED_RAD_S
    assert np.mean(electrical["DcVoltage"] * electrical["DcCurrent"]) > 0


def check_slow_frames(signals: dict[str, dict[str, np.ndarray]]) -> None:
    assert set(signals["MCU_Capability"]["TorqueMotoring"]) == {150.0}
    faults = signals["MCU_Faults"]
    assert set(faults["FirstFault"]) == {"NONE"}
    for mask in (signals["MCU_FaultsActive"], signals["MCU_FaultsLatched"]):
        assert not any(mask[key].any() for key in mask if key.startswith(("Active", "Latched")))
    assert set(signals["MCU_Identification"]["ContractMajor"]) == {Contract().version()[0]}
    assert np.all(signals["MCU_RealTime"]["TelemetryDropped"] == 0)
