"""Measurements that the host may disturb: said aloud and repeated, at most twice."""

from collections.abc import Callable
from typing import TypeVar

import numpy as np
from telemetry_record import Span

Measured = TypeVar("Measured")

REPEATS = 2
APART_NS = 40_000_000  # after so much silence the drive takes the torque back, as it should
STALL_NS = 8_000_000


def gaps_ns(span: Span) -> np.ndarray:
    """Times between one command acted on and the next, the longest first."""
    return -np.sort(-np.diff(span.command_times_ns()))


def commands_apart(span: Span, wanted: int = 0) -> str | None:
    """What there is to say of commands too far apart to hold a torque; so many silences are wanted."""
    gaps = gaps_ns(span)[wanted:]
    return f"commands came {gaps[0] * 1e-6:.0f} ms apart" if len(gaps) and gaps[0] > APART_NS else None


def silence_spoilt(span: Span, longest_ns: float | None = None, wanted: int = 1) -> str | None:
    """What there is to say of a span with so many ended silences: one more, one too long, a drive that stood still."""
    gaps = gaps_ns(span)
    if longest_ns is not None and len(gaps) and gaps[0] >= longest_ns:
        return f"the silence lasted {gaps[0] * 1e-6:.0f} ms"
    stalls = [end_ns - begin_ns for begin_ns, end_ns in span.stalls_ns()]
    if stalls and max(stalls) > STALL_NS:
        return f"{max(stalls) * 1e-6:.0f} ms without telemetry"
    return commands_apart(span, wanted)


def undisturbed(
    what: str,
    measure: Callable[[], Measured],
    disturbance: Callable[[Measured], str | None],
    before_repeat: Callable[[], None] = lambda: None,
) -> Measured:
    """A measurement that the host did not disturb; it is repeated at most twice, and the last one counts as it is."""
    for attempt in range(1 + REPEATS):
        if attempt:
            before_repeat()
        found = measure()
        reason = disturbance(found)
        if reason is None:
            return found
        print(f"{what}, attempt {attempt + 1} disturbed by the host: {reason}")
    return found
