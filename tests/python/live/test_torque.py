"""A torque command over CAN turns the motor: step responses in all four quadrants, by the drive's own stamps."""

from collections.abc import Callable

import numpy as np
import pytest
from attempts import commands_apart, undisturbed
from drive_process import DriveProcess
from handling import bring_up, regain
from kernel import native_kernel_only
from telemetry_record import Span, TelemetryRecord
from vehicle import Vehicle

REACH_S = 0.010
HOLD_S = 0.5

# Up and down in both directions of torque; at either direction of speed these are the four quadrants.
STEPS_NM = [15.0, 40.0, 15.0, -15.0, -40.0, -15.0, 15.0, 0.0]

# Sampled at 25 µs, switching-table DTC settles beside its reference, by more the faster the machine turns: the mean
# over half a second, with the sign of the speed, lies in these limits (lowest, highest) [N·m].
BIAS_NM = {0.0: (-1.0, 1.0), 30.0: (-1.5, 0.5), 100.0: (-3.3, 0.0)}

# What a stall of the host leaves behind has decayed by then; of the half second so much must remain.
SETTLING_NS = 10_000_000
SHARE_LEFT = 0.8
SLOW_RAD_S = 30.0
TELEMETRY_HZ = 500  # in a guest


def step(record: TelemetryRecord, vehicle: Vehicle, from_nm: float, torque_nm: float) -> Span:
    """Demands one torque, then the other; the samples from shortly before to half a second after."""
    vehicle.demand(from_nm, enable=True)
    record.run(0.2)
    begin = len(record.samples)
    record.run(0.05)
    vehicle.demand(torque_nm, enable=True)
    record.run(HOLD_S + 0.1)
    return Span(record.samples[begin:])


def acted_on(span: Span, torque_nm: float) -> int:
    """Index of the first sample that acts on the new request."""
    return int(np.argmax(np.isclose(span.torque_requested_nm, torque_nm, atol=0.006)))


def response_s(span: Span, torque_nm: float, tolerance_nm: float) -> float:
    """From reception of the command to the end of the first interval of telemetry whose mean torque is there [s]."""
    first = acted_on(span, torque_nm)
    received_ns = span.command_received_ns[first]
    there = np.abs(span.torque_mean_nm - torque_nm) <= tolerance_nm
    there[:first] = False
    if not there.any():
        pytest.fail(f"{torque_nm:g} N·m was never reached")
    return float(span.t_ns[int(np.argmax(there))] - received_ns) * 1e-9


def held(span: Span, torque_nm: float) -> Span:
    """The half second that begins 10 ms after reception."""
    begin_ns = int(span.command_received_ns[acted_on(span, torque_nm)] + REACH_S * 1e9)
    return span.between(begin_ns, begin_ns + round(HOLD_S * 1e9))


@pytest.mark.timing
@pytest.mark.parametrize("speed_rad_s", [0.0, 30.0, -30.0, 100.0, -100.0])
def test_steps(speed_rad_s: float, live_bus: str, domain: int, start_drive: Callable[..., DriveProcess]) -> None:
    if abs(speed_rad_s) > SLOW_RAD_S:
        native_kernel_only()
    start_drive(
        live_bus, "load.kind=imposed_speed", f"load.speed_rad_s.value={speed_rad_s:g}", telemetry_hz=TELEMETRY_HZ
    )
    record = TelemetryRecord(domain)
    with Vehicle(live_bus) as vehicle:
        bring_up(record, vehicle, 0.0)
        from_nm = 0.0
        for torque_nm in STEPS_NM:
            check_step(record, vehicle, speed_rad_s, from_nm, torque_nm)
            from_nm = torque_nm


def disturbance(span: Span, torque_nm: float) -> str | None:
    """What the host did that spoils the measurement; None for a sound one."""
    if set(span.states) != {"TORQUE"} or not np.isclose(span.torque_requested_nm, torque_nm, atol=0.006).any():
        return commands_apart(span)
    received_ns = int(span.command_received_ns[acted_on(span, torque_nm)])
    for begin_ns, end_ns in span.stalls_ns():
        if end_ns > received_ns - SETTLING_NS and begin_ns < received_ns + REACH_S * 1e9:
            return f"a stall of {(end_ns - begin_ns) * 1e-6:.0f} ms beside the step"
    settled = held(span, torque_nm)
    if len(settled.without_stalls(SETTLING_NS)) < SHARE_LEFT * HOLD_S * 1e9 / span.interval_ns:
        return f"{len(settled.stalls_ns())} stalls within the half second"
    return commands_apart(span)


def measured(record: TelemetryRecord, vehicle: Vehicle, from_nm: float, torque_nm: float) -> Span:
    """A step that the host did not disturb; see undisturbed()."""
    return undisturbed(
        f"{from_nm:+.0f} to {torque_nm:+.0f} N·m",
        lambda: step(record, vehicle, from_nm, torque_nm),
        lambda span: disturbance(span, torque_nm),
        lambda: regain(record, vehicle, from_nm),
    )


def check_step(record: TelemetryRecord, vehicle: Vehicle, speed_rad_s: float, from_nm: float, torque_nm: float) -> None:
    span = measured(record, vehicle, from_nm, torque_nm)
    half_second = held(span, torque_nm)
    settled = half_second.without_stalls(SETTLING_NS)
    assert len(settled) >= SHARE_LEFT * HOLD_S * 1e9 / span.interval_ns, (
        f"{len(settled)} samples cannot carry the claim"
    )
    assert settled.speed_rad_s == pytest.approx(speed_rad_s, abs=0.1)
    assert settled.torque_reference_nm == pytest.approx(torque_nm, abs=0.006)

    lowest, highest = BIAS_NM[abs(speed_rad_s)]
    took_s = response_s(span, torque_nm, max(1.5, -lowest))
    bias_nm = float(np.mean(settled.torque_mean_nm) - torque_nm)
    print(
        f"{speed_rad_s:+5.0f} rad/s {from_nm:+4.0f} to {torque_nm:+4.0f} N·m: there after {took_s * 1e3:5.2f} ms,"
        f" mean {bias_nm:+5.2f} N·m beside it, single means {settled.torque_mean_nm.min() - torque_nm:+5.2f}"
        f" to {settled.torque_mean_nm.max() - torque_nm:+5.2f}, {len(settled)} samples"
        f" ({len(half_second.stalls_ns())} stalls left out)"
    )
    assert took_s <= REACH_S
    assert lowest <= bias_nm * (1 if speed_rad_s >= 0 else -1) <= highest
