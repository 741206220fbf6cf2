"""What was lost on the way to a recording, by the sequence numbers and counters of the drive."""

from dataclasses import asdict, dataclass

import numpy as np

from ..e2e import COUNTER_COUNT
from .topics import TOPICS, WAVEFORM

COUNTER = "Counter"  # of the E2E protection


def missing_periods(rows: np.ndarray) -> int:
    """Control periods between the first and the last row of a waveform that have no row; not those between two starts
    of a drive."""
    steps = np.rint(np.diff(rows["t_ns"].astype(np.int64)) / rows["period_ns"][1:]).astype(np.int64)
    goes_on = np.diff(rows["sequence"].astype(np.int64)) >= 0
    return int(np.sum(steps[goes_on & (steps > 1)] - 1))


@dataclass
class Losses:
    """Of one group. What is zero was not lost or cannot be counted."""

    rows: int = 0
    lost: int = 0  # samples, batches or frames that the writer numbered and the recorder did not get
    restarts: int = 0  # of the numbering
    dropped: int = 0  # control periods lost within the drive, by its own count
    periods_missing: int = 0  # control periods between the first and the last row that have no row

    def described(self) -> dict[str, int]:
        return asdict(self)


class LossCounter:
    """Takes the blocks of a recording in their order."""

    def __init__(self) -> None:
        self.of: dict[str, Losses] = {}
        self._last: dict[str, np.void] = {}

    def take(self, name: str, block: np.ndarray) -> None:
        losses = self.of.setdefault(name, Losses())
        losses.rows += len(block)
        rows = np.concatenate((self._last[name][None], block)) if name in self._last else block
        self._last[name] = block[-1].copy()
        if name in TOPICS:
            self._take_sequence(losses, rows["sequence"].astype(np.int64), name == WAVEFORM)
        elif COUNTER in (block.dtype.names or ()):
            steps = np.mod(np.diff(rows[COUNTER]).astype(np.int64), COUNTER_COUNT)
            losses.lost += int(np.sum(np.where(steps == 0, 0, steps - 1)))
        if "dropped" in (block.dtype.names or ()):
            self._take_dropped(losses, rows["dropped"].astype(np.int64))
        if name == WAVEFORM:
            losses.periods_missing += missing_periods(rows)

    @staticmethod
    def _take_sequence(losses: Losses, sequence: np.ndarray, repeats: bool) -> None:
        steps = np.diff(sequence)
        losses.lost += int(np.sum(steps[steps > 1] - 1))
        losses.restarts += int(np.sum(steps < 0 if repeats else steps < 1))

    @staticmethod
    def _take_dropped(losses: Losses, dropped: np.ndarray) -> None:
        """A count that falls is that of a drive that has started again."""
        steps = np.diff(dropped)
        losses.dropped += int(np.sum(np.where(steps < 0, dropped[1:], steps)))

    def described(self) -> dict[str, dict[str, int]]:
        return {name: losses.described() for name, losses in self.of.items()}

    def sentence(self, name: str) -> str:
        """What a group has lost, for people."""
        losses = self.of.get(name, Losses())
        what = "batches" if name == WAVEFORM else "samples"
        text = f"{losses.lost} {what} lost on the way" if name == WAVEFORM else f"{losses.lost} lost on the way"
        if losses.dropped:
            text += f", {losses.dropped} control periods dropped within the drive"
        if losses.periods_missing:
            text += f", {losses.periods_missing} control periods without a row"
        if losses.restarts:
            text += f", the numbering began again {losses.restarts} times"
        return text
