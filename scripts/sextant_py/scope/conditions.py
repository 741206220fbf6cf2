"""The conditions of a trigger. Each takes the rows of the waveform in their order and remembers what it needs of the
rows before."""

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from . import quantities


class Condition(Protocol):
    """What a trigger waits for."""

    def hits(self, rows: np.ndarray) -> np.ndarray:
        """True for each row at which it is fulfilled."""
        ...


@dataclass
class Edge:
    """A signal passes a level. It has to leave the level by the hysteresis before it can pass it again."""

    signal: str
    level: float
    rising: bool = True
    falling: bool = False
    hysteresis: float = 0.0
    _side: float = field(default=0.0, repr=False)  # 1 above, −1 below, 0 before the first row

    def hits(self, rows: np.ndarray) -> np.ndarray:
        sides = self._sides(quantities.values(rows, self.signal))
        before = np.concatenate(([self._side], sides[:-1]))
        self._side = float(sides[-1]) if len(sides) else self._side
        up, down = (before < 0) & (sides > 0), (before > 0) & (sides < 0)
        return (up & self.rising) | (down & self.falling)

    def _sides(self, values: np.ndarray) -> np.ndarray:
        """The side of the level, and within the hysteresis the side before."""
        half = self.hysteresis / 2.0
        decided = np.where(values >= self.level + half, 1.0, np.where(values < self.level - half, -1.0, 0.0))
        last = np.maximum.accumulate(np.where(decided != 0.0, np.arange(1, len(values) + 1), 0))
        return np.concatenate(([self._side], decided))[last]


@dataclass
class Level:
    signal: str
    level: float
    above: bool = True

    def hits(self, rows: np.ndarray) -> np.ndarray:
        values = quantities.values(rows, self.signal)
        return values > self.level if self.above else values < self.level


@dataclass
class StateChange:
    """The drive enters a state, or any other one."""

    entered: int | None = None  # value of DriveStateKind; None: any
    _state: int | None = field(default=None, repr=False)

    def hits(self, rows: np.ndarray) -> np.ndarray:
        states = rows["state"].astype(np.int64)
        if not len(states):
            return np.zeros(0, bool)
        first = states[0] if self._state is None else self._state
        changed = states != np.concatenate(([first], states[:-1]))
        self._state = int(states[-1])
        return changed if self.entered is None else changed & (states == self.entered)


@dataclass
class TorqueStep:
    """The torque reference changes by a size or more within a time. [N·m], [ns]"""

    size: float
    within_ns: int = 1_000_000
    _before: np.ndarray | None = field(default=None, repr=False)

    def hits(self, rows: np.ndarray) -> np.ndarray:
        if not len(rows):
            return np.zeros(0, bool)
        new = np.stack((rows["t_ns"].astype(np.float64), rows["torque_reference_nm"].astype(np.float64)))
        both = new if self._before is None else np.concatenate((self._before, new), axis=1)
        times, reference = both
        earlier = np.searchsorted(times, times - self.within_ns)
        stepped = np.abs(reference - reference[earlier]) >= self.size
        self._before = both[:, times > times[-1] - self.within_ns]
        # A step is one event: its first row.
        starts = stepped & ~np.concatenate(([False], stepped[:-1]))
        return starts[both.shape[1] - len(rows) :]
