"""A drive in torque production, on a machine that may stand still for seconds.

The tests set every timeout so wide that only a defect trips it. What a machine can do all the same (a gap longer than
the plant integrates or than magnetising may take, measurements that the link has not kept) trips the drive, as it
should; then the vehicle brings it back as a vehicle does, by reset, disable and enable. Any other fault is a failure.
"""

import time
from collections.abc import Callable
from typing import Any, TypeVar

import pytest
from sextant_py.contract import Contract
from telemetry_record import Span, TelemetryRecord
from vehicle import Vehicle

FAULTS = Contract().faults()
COMMAND_LOST, FLUX_LOST, MEASUREMENT_INVALID, WATCHDOG = (
    FAULTS[name] for name in ("COMMAND_LOST", "FLUX_LOST", "MEASUREMENT_INVALID", "WATCHDOG")
)
OF_A_STALL = {COMMAND_LOST, FLUX_LOST, MEASUREMENT_INVALID, WATCHDOG}
PATIENCE_S = 120.0
TORQUE_STEP_NM = 0.006  # a torque as CAN carries it
SETTLED_S = 0.03
PIECE_S = 0.05
ENOUGH = 20  # samples for a mean torque

T = TypeVar("T")


def state(record: TelemetryRecord) -> str:
    record.poll()
    return record.samples[-1].state.name


def make_ready(record: TelemetryRecord, vehicle: Vehicle) -> None:
    """Into READY from any state; faults are reset."""
    record.wait_until_heard()
    end_s = time.monotonic() + PATIENCE_S
    vehicle.demand()
    while (now := state(record)) != "READY":
        if now == "FAULT":
            check_excusable(record)
            vehicle.demand(fault_reset=True)
            record.run(0.1)
            vehicle.demand()
        if time.monotonic() > end_s:
            pytest.fail(f"the drive did not become READY: {record.last_words()}")
        record.run(0.05)


def bring_up(record: TelemetryRecord, vehicle: Vehicle, torque_nm: float) -> None:
    """Reset where it needs one, disable, enable, until the drive has been in TORQUE with this torque admitted."""
    end_s = time.monotonic() + PATIENCE_S
    while time.monotonic() < end_s:
        make_ready(record, vehicle)
        first = len(record.samples)
        vehicle.demand(torque_nm, enable=True)
        record.wait(lambda own: is_reference(own, torque_nm) or state(own) == "FAULT", f"{torque_nm:g} N·m")
        if any(admits(sample, torque_nm) for sample in record.samples[first:]):
            return
    pytest.fail(f"the drive never came to TORQUE: {record.last_words()}")


def admits(sample: Any, torque_nm: float) -> bool:
    """Whether it is of a drive in TORQUE with this torque admitted."""
    return sample.state.name == "TORQUE" and abs(sample.torque_reference_nm - torque_nm) < TORQUE_STEP_NM


def is_reference(record: TelemetryRecord, torque_nm: float) -> bool:
    return admits(record.samples[-1], torque_nm)


def reports(record: TelemetryRecord) -> list[Any]:
    """The states of the drive that name a fault."""
    return [told for told in record.states if told.first_fault >= 0]


def check_excusable(record: TelemetryRecord) -> None:
    """The fault that the drive is in must be one that a machine that stood still can cause. It may have left it by now:
    a reset that was sent before acts as soon as the fault is gone.
    """
    record.wait(
        lambda own: reports(own) and (own.states[-1].first_fault >= 0 or state(own) != "FAULT"),
        "the reason of a FAULT",
    )
    fault = reports(record)[-1]
    if fault.first_fault not in OF_A_STALL:
        pytest.fail(f"the drive tripped: {fault.reason}")
    print(f"tripped and brought back: {fault.reason}")


def at_torque(record: TelemetryRecord, vehicle: Vehicle, torque_nm: float, seconds: float = 0.3) -> Span:
    """Samples of so many seconds in which the drive produced this torque and had settled; it is in TORQUE at their end.

    In one piece where the machine allows, in several where it trips the drive in between. Seconds are those of the
    drive's clock: of a machine that is too slow for every sample some are missing.
    """
    record.wait_until_heard()
    end_s = time.monotonic() + PATIENCE_S
    found: list[Any] = []
    covered_s = 0.0
    while time.monotonic() < end_s:
        if state(record) == "TORQUE":
            vehicle.demand(torque_nm, enable=True)
            record.wait(lambda own: is_reference(own, torque_nm) or state(own) == "FAULT", f"{torque_nm:g} N·m")
        if not is_reference(record, torque_nm):
            bring_up(record, vehicle, torque_nm)
        record.run(SETTLED_S)
        piece = record.run(PIECE_S).samples
        if all(admits(sample, torque_nm) for sample in piece):
            found += piece
            covered_s += PIECE_S
        if covered_s >= seconds and len(found) >= ENOUGH and is_reference(record, torque_nm):
            return Span(found)
    raise pytest.fail.Exception(f"never {seconds:g} s in TORQUE: {record.last_words()}")


def untripped(record: TelemetryRecord, prepare: Callable[[], Any], act: Callable[[], T]) -> T:
    """What `act` gives of a time in which the drive did not trip.

    Where the machine stood still for so long that it did, both come again: `prepare` brings the drive back.
    """
    end_s = time.monotonic() + PATIENCE_S
    while time.monotonic() < end_s:
        prepare()
        first = len(record.samples)
        found = act()
        record.poll()
        if "FAULT" not in Span(record.samples[first:]).states:
            return found
        check_excusable(record)
    raise pytest.fail.Exception(f"the drive tripped each time: {record.last_words()}")


def until(record: TelemetryRecord, condition: Callable[[Span], bool], what: str, first: int) -> Span:
    """The samples from number `first` on, once they meet the condition."""
    record.wait(lambda own: len(own.samples) > first and condition(Span(own.samples[first:])), what)
    return Span(record.samples[first:])
