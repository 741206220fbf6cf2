"""The check of a drive for protected frames: CRC, data ID and the sequence of their counters."""

from enum import Enum

from sextant_py import e2e


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
        if not e2e.is_valid(frame, self._data_id):
            return Result.ERROR
        last, self._last = self._last, frame[1] & 0x0F
        if last is None:
            return Result.OK
        delta = (self._last - last) % e2e.COUNTER_COUNT
        if delta == 0:
            return Result.REPEATED
        if delta == 1:
            return Result.OK
        return Result.SOME_LOST if delta <= self._max_delta else Result.WRONG_SEQUENCE
