"""AUTOSAR E2E profile 11 in data-ID mode NIBBLE, by the package autosar-e2e; the sequence of counters is checked here.

Byte 0 holds the CRC, the low nibble of byte 1 the counter, its high nibble the low nibble of the data ID's high byte.
"""

from enum import Enum

from e2e import p11

COUNTER_COUNT = 15
"""The counter runs from 0 to 14; 15 is invalid."""


def crc(frame: bytes, data_id: int) -> int:
    """The CRC that byte 0 of the frame should hold."""
    signed = bytearray(frame)
    p11.e2e_p11_protect(signed, data_id, data_id_mode=p11.E2E_P11_DATAID_NIBBLE, increment_counter=False)
    return signed[0]


def protect(frame: bytearray, data_id: int, counter: int) -> None:
    """Writes counter, data-ID nibble and CRC into the frame."""
    if not 0 <= counter < COUNTER_COUNT:
        raise ValueError(f"counter {counter} is not within 0 and {COUNTER_COUNT - 1}")
    frame[1] = ((data_id >> 8) & 0x0F) << 4 | counter
    frame[0] = crc(frame, data_id)


class Result(Enum):
    """What a check found."""

    OK = "ok"
    SOME_LOST = "some lost"
    REPEATED = "repeated"
    WRONG_SEQUENCE = "wrong sequence"
    ERROR = "wrong CRC, data ID or counter"

    @property
    def usable(self) -> bool:
        return self in (Result.OK, Result.SOME_LOST)


class Checker:
    """Judges the frames of one data ID as they arrive."""

    def __init__(self, data_id: int, max_delta: int = 3) -> None:
        self._data_id = data_id
        self._max_delta = max_delta
        self._last: int | None = None

    def check(self, frame: bytes) -> Result:
        counter = frame[1] & 0x0F
        nibble = frame[1] >> 4
        if counter >= COUNTER_COUNT or nibble != (self._data_id >> 8) & 0x0F or frame[0] != crc(frame, self._data_id):
            return Result.ERROR
        last, self._last = self._last, counter
        if last is None:
            return Result.OK
        delta = (counter - last) % COUNTER_COUNT
        if delta == 0:
            return Result.REPEATED
        if delta == 1:
            return Result.OK
        return Result.SOME_LOST if delta <= self._max_delta else Result.WRONG_SEQUENCE
