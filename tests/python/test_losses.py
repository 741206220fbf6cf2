"""What is lost is counted, by hand-made rows whose losses are known."""

import numpy as np
import pytest
from sextant_py.recording import topics
from sextant_py.recording.losses import LossCounter
from sextant_py.recording.model import MAIN

SEED = 37


def numbered(name: str, sequence: list[int], **columns: list[int]) -> np.ndarray:
    rows = np.zeros(len(sequence), topics.group_of(name).dtype)
    rows["sequence"] = sequence
    for column, values in columns.items():
        rows[column] = values
    return rows


def counted(name: str, rows: np.ndarray, at: list[int]) -> tuple[int, int, int, int, int]:
    """Rows, lost, restarts, dropped and periods without a row, of rows that come in blocks cut at these places."""
    counter = LossCounter()
    for block in np.split(rows, at):
        if len(block):
            counter.take(name, block)
    losses = counter.of[name]
    assert counter.described() == {name: losses.described()}
    return losses.rows, losses.lost, losses.restarts, losses.dropped, losses.periods_missing


@pytest.mark.parametrize("at", [[], [1], [3, 4], [2, 5]])
@pytest.mark.parametrize(
    ("sequence", "dropped", "expected"),
    [
        ([5, 6, 7, 8, 9, 10], [0, 0, 0, 0, 0, 0], (6, 0, 0, 0, 0)),
        ([5, 6, 9, 10, 11, 20], [0, 0, 0, 0, 0, 0], (6, 10, 0, 0, 0)),
        ([5, 6, 7, 8, 9, 10], [3, 3, 7, 7, 8, 8], (6, 0, 0, 5, 0)),  # what was dropped before is not of this recording
        ([90, 91, 0, 1, 3, 4], [40, 40, 2, 2, 2, 3], (6, 1, 1, 3, 0)),  # the drive has started again
        ([2**33, 2**33 + 1, 2**33 + 4, 2**33 + 5, 2**33 + 6, 2**33 + 7], [0] * 6, (6, 2, 0, 0, 0)),
    ],
)
def test_gaps_and_restarts_of_telemetry(
    at: list[int], sequence: list[int], dropped: list[int], expected: tuple[int, ...]
) -> None:
    assert counted(MAIN, numbered(MAIN, sequence, dropped=dropped), at) == expected


@pytest.mark.parametrize("at", [[], [1], [2, 4]])
def test_batches_and_periods_of_the_waveform(at: list[int]) -> None:
    """A batch of two rows, one that lacks a period, a missing one, and one after it."""
    times = [0, 25_000, 50_000, 100_000, 250_000, 275_000]
    rows = numbered(topics.WAVEFORM, [7, 7, 8, 8, 10, 10], t_ns=times, period_ns=[25_000] * 6)
    assert counted(topics.WAVEFORM, rows, at) == (6, 1, 0, 0, 1 + 5)


@pytest.mark.parametrize("at", [[], [2], [3]])
def test_the_time_between_two_starts_of_a_drive_is_not_missing(at: list[int]) -> None:
    times = [0, 25_000, 75_000, 5_000_000, 5_025_000]
    rows = numbered(topics.WAVEFORM, [7, 7, 8, 0, 0], t_ns=times, period_ns=[25_000] * 5)
    assert counted(topics.WAVEFORM, rows, at) == (5, 0, 1, 0, 1)


def test_frames_are_counted_by_their_counters() -> None:
    """The counter runs from 0 to 14; a repeated frame is no loss."""
    kind = np.dtype([("t_ns", "<i8"), ("Counter", "<f8")])
    rows = np.zeros(8, kind)
    rows["Counter"] = [12, 13, 14, 0, 0, 1, 4, 3]  # two lost before the 4, 13 before the 3
    assert counted("can/MCU_Motion", rows, [3]) == (8, 2 + 13, 0, 0, 0)


def test_random_losses_are_found_whatever_the_blocks() -> None:
    print(f"seed {SEED}")
    random = np.random.default_rng(SEED)
    for _ in range(50):
        count = int(random.integers(20, 400))
        kept = np.sort(random.choice(count, size=int(random.integers(2, count)), replace=False))
        rows = numbered(topics.WAVEFORM, list(kept // 10), t_ns=kept * 25_000, period_ns=[25_000] * len(kept))
        numbers = np.unique(kept // 10)
        lost = int(numbers[-1] - numbers[0] + 1 - len(numbers))
        missing = int(kept[-1] - kept[0] + 1 - len(kept))
        at = np.sort(random.integers(0, len(kept), 5)).tolist()
        assert counted(topics.WAVEFORM, rows, at) == (len(kept), lost, 0, 0, missing)
