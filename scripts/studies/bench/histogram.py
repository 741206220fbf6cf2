"""Durations as counted by the programs: percentiles of several runs together."""

import math
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field

PERCENTS = (50.0, 99.0, 99.9, 99.99)


@dataclass
class Histogram:
    counts: Counter = field(default_factory=Counter)  # by duration [ns]
    max_ns: int = 0

    @staticmethod
    def of(values_ns: Iterable[int]) -> "Histogram":
        counts = Counter(values_ns)
        return Histogram(counts, max(counts, default=0))

    @staticmethod
    def from_json(data: dict) -> "Histogram":
        return Histogram(Counter(dict(map(tuple, data["buckets"]))), data["max_ns"])

    def __add__(self, other: "Histogram") -> "Histogram":
        return Histogram(self.counts + other.counts, max(self.max_ns, other.max_ns))

    @property
    def count(self) -> int:
        return self.counts.total()

    def percentile_ns(self, percent: float) -> float:
        """The nearest-rank percentile; NaN without samples."""
        rank = max(1, math.ceil(percent / 100.0 * self.count - 1e-9))  # 99.9 % of 1000 are 999
        for value in sorted(self.counts):
            rank -= self.counts[value]
            if rank <= 0:
                return float(value)
        return math.nan

    def by_time(self, period_ns: int) -> "Histogram":
        """Of wake-up latencies: each weighted by how long its wake-up was waited for. So their percentiles are those
        of something that comes at any time: it meets a late wake-up more often than one in time."""
        return Histogram(Counter({ns: count * (period_ns + ns) for ns, count in self.counts.items()}), self.max_ns)

    def part_above(self, limit_ns: float) -> float:
        return sum(count for ns, count in self.counts.items() if ns > limit_ns) / self.count

    def exceeded(self) -> tuple[list[float], list[float]]:
        """Durations [µs] in ascending order, and the part of all samples that is at least so long."""
        durations, parts, left = [], [], self.count
        for value in sorted(self.counts):
            durations.append(value * 1e-3)
            parts.append(left / self.count)
            left -= self.counts[value]
        return durations, parts

    def summary(self) -> dict[str, float]:
        percentiles = {f"p{percent:g}_us": self.percentile_ns(percent) * 1e-3 for percent in PERCENTS}
        return {"count": self.count, **percentiles, "max_us": self.max_ns * 1e-3}
