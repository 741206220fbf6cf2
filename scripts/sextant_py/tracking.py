"""Whether a drive delivers the torque that it is asked for."""

from collections import deque

TOLERANCE_NM = 5.0
TOLERANCE_SHARE = 0.05  # of the torque asked for
MEAN_S = 0.1  # over which the torque delivered is taken, so that the ripple of switching has no say
WINDOW_S = 0.1 + MEAN_S  # of the torques asked for: a step, a ramp and the way over the bus are over within 0.1 s


class Tracking:
    """Compares the mean of the torque delivered with the range of the torques asked for over the last WINDOW_S."""

    def __init__(self) -> None:
        self._asked: deque[tuple[float, float]] = deque()
        self._delivered: deque[tuple[float, float]] = deque()
        self._last_s: float | None = None
        self.deviation_nm = 0.0  # of the last sample from that range; 0 within the tolerance [N·m]
        self.worst_nm = 0.0  # the deviation of the largest magnitude so far [N·m]
        self.off_s = 0.0  # time with a deviation [s]
        self.total_s = 0.0  # time compared [s]

    def add(self, time_s: float, asked_nm: float, delivered_nm: float) -> None:
        self._asked.append((time_s, asked_nm))
        # What was asked last before the window still holds at its beginning.
        while len(self._asked) > 1 and self._asked[1][0] <= time_s - WINDOW_S:
            self._asked.popleft()
        self._delivered.append((time_s, delivered_nm))
        while self._delivered[0][0] <= time_s - MEAN_S:
            self._delivered.popleft()
        torques = [torque for _, torque in self._asked]
        mean_nm = sum(torque for _, torque in self._delivered) / len(self._delivered)
        nearest = min(max(mean_nm, min(torques)), max(torques))
        tolerance = max(TOLERANCE_NM, TOLERANCE_SHARE * max(abs(torque) for torque in torques))
        off_nm = mean_nm - nearest
        self.deviation_nm = off_nm if abs(off_nm) > tolerance else 0.0
        elapsed_s = 0.0 if self._last_s is None else min(time_s - self._last_s, WINDOW_S)
        self._last_s = time_s
        self.total_s += elapsed_s
        if self.deviation_nm:
            self.off_s += elapsed_s
            self.worst_nm = max(self.worst_nm, self.deviation_nm, key=abs)

    def pause(self) -> None:
        """No torque is asked for: what was asked before is forgotten."""
        self._asked.clear()
        self._delivered.clear()
        self._last_s = None
        self.deviation_nm = 0.0

    def sentence(self) -> str | None:
        """What is to be said of it; None where nothing was off."""
        if not self.worst_nm:
            return None
        return (
            f"the drive did not deliver the torque asked for during {self.off_s:.1f} of {self.total_s:.1f} s,"
            f" by {self.worst_nm:+.0f} N·m at worst (tolerance {TOLERANCE_NM:g} N·m or {TOLERANCE_SHARE:.0%})"
        )
