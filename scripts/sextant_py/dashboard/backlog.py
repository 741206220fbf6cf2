"""The newest frames of a drive's telemetry, and a page's place among them."""

from collections import deque


class Backlog:
    """Numbers the frames and keeps the newest."""

    def __init__(self, most: int) -> None:
        self._frames: deque[bytes] = deque(maxlen=most)
        self.end = 0  # number of the next frame

    @property
    def begin(self) -> int:
        return self.end - len(self._frames)

    def append(self, frame: bytes) -> None:
        self._frames.append(frame)
        self.end += 1

    def frame(self, number: int) -> bytes:
        return self._frames[number - self.begin]


class Reader:
    """Takes one frame after another, from the oldest on.

    Once it has had the newest it leaves out what it is too late for: a reader that is further behind than `most_behind`
    goes on with the newest.
    """

    def __init__(self, backlog: Backlog, most_behind: int) -> None:
        self._backlog, self._most_behind = backlog, most_behind
        self._number = backlog.begin
        self._has_caught_up = False
        self.dropped = 0

    def next(self) -> bytes | None:
        """The next frame; None where there is none yet."""
        backlog = self._backlog
        if self._number == backlog.end:
            self._has_caught_up = True
            return None
        is_late = self._has_caught_up and backlog.end - self._number > self._most_behind
        oldest = backlog.end - 1 if is_late else backlog.begin
        self.dropped += max(0, oldest - self._number)
        self._number = max(self._number, oldest) + 1
        return backlog.frame(self._number - 1)
