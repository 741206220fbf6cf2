"""Fewer points for a picture: blocks of samples by their minimum and maximum, so that no peak is lost. As a row of a
trace stands at the end of what it covers, so does a block: what is drawn at a time has nothing of after it."""

import itertools

import numpy as np


def envelope(time_s: np.ndarray, values: np.ndarray, most: int) -> tuple[np.ndarray, np.ndarray]:
    """No more than `most` points: of each block its minimum and its maximum, each at its own time."""
    if len(values) <= most:
        return time_s, values
    edges = np.linspace(0, len(values), max(most // 2, 1) + 1).astype(int)
    below, above = np.where(np.isnan(values), np.inf, values), np.where(np.isnan(values), -np.inf, values)
    kept = [
        begin + place
        for begin, end in itertools.pairwise(edges)
        for place in sorted((int(below[begin:end].argmin()), int(above[begin:end].argmax())))
    ]
    return time_s[kept], values[kept]


def bands(
    time_s: np.ndarray, mean: np.ndarray, low: np.ndarray, high: np.ndarray, most: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """End, mean, minimum and maximum of no more than `most` blocks; samples without a value are left out of them."""
    if len(mean) <= most:
        return time_s, mean, low, high
    starts = np.linspace(0, len(mean), most, endpoint=False).astype(int)
    there = np.isfinite(mean)
    counts = np.add.reduceat(there.astype(int), starts)
    sums = np.add.reduceat(np.where(there, mean, 0.0), starts)
    means = np.divide(sums, counts, out=np.full(len(starts), np.nan), where=counts > 0)
    ends = np.append(starts[1:], len(mean)) - 1
    return time_s[ends], means, np.fmin.reduceat(low, starts), np.fmax.reduceat(high, starts)
