"""Fewer points for a picture: blocks of samples by their minimum and maximum, so that no peak is lost."""

import numpy as np


def envelope(time_s: np.ndarray, values: np.ndarray, most: int) -> tuple[np.ndarray, np.ndarray]:
    """No more than `most` points: of each block its minimum and its maximum, at the block's first and last time."""
    if len(values) <= most:
        return time_s, values
    starts = np.linspace(0, len(values), max(most // 2, 1), endpoint=False).astype(int)
    ends = np.append(starts[1:], len(values)) - 1
    low, high = np.fmin.reduceat(values, starts), np.fmax.reduceat(values, starts)
    return np.column_stack((time_s[starts], time_s[ends])).ravel(), np.column_stack((low, high)).ravel()


def bands(
    time_s: np.ndarray, mean: np.ndarray, low: np.ndarray, high: np.ndarray, most: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Time, mean, minimum and maximum of no more than `most` blocks; samples without a value are left out of them."""
    if len(mean) <= most:
        return time_s, mean, low, high
    starts = np.linspace(0, len(mean), most, endpoint=False).astype(int)
    there = np.isfinite(mean)
    counts = np.add.reduceat(there.astype(int), starts)
    sums = np.add.reduceat(np.where(there, mean, 0.0), starts)
    means = np.divide(sums, counts, out=np.full(len(starts), np.nan), where=counts > 0)
    return time_s[starts], means, np.fmin.reduceat(low, starts), np.fmax.reduceat(high, starts)
