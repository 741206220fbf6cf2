"""Discrete signals above each other: enumerations as bands with the names of their values, numbers as steps."""

from dataclasses import dataclass

import numpy as np

from .panels import Line
from .points import envelope
from .styles import COLOURS

HEIGHT = 0.8  # of a lane, which takes 1


@dataclass(frozen=True)
class Band:
    begin_s: float
    end_s: float
    text: str
    colour: str

    @property
    def middle_s(self) -> float:
        return 0.5 * (self.begin_s + self.end_s)

    @property
    def length_s(self) -> float:
        return self.end_s - self.begin_s


@dataclass(frozen=True)
class Lane:
    """A signal between base and base + HEIGHT."""

    label: str
    line: Line
    base: float

    @property
    def is_named(self) -> bool:
        return bool(self.line.series.value_texts)

    @property
    def middle(self) -> float:
        return self.base + HEIGHT / 2

    def bands(self) -> list[Band]:
        """The runs of the values, each up to the row of the next; the last one up to the last row."""
        time_s, values = self.line.series.time_s, self.line.series.values
        texts = self.line.series.value_texts
        begins = np.flatnonzero(np.diff(values.astype(np.int64), prepend=values[0].astype(np.int64) - 1))
        ends = np.append(begins[1:], len(values) - 1)
        return [
            Band(float(time_s[begin]), float(time_s[end]), texts.get(value, str(value)), COLOURS[value % len(COLOURS)])
            for begin, end, value in zip(begins, ends, map(int, values[begins]), strict=True)
        ]

    def steps(self, most: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Times, heights and values of no more than `most` rows."""
        time_s, values = envelope(self.line.series.time_s, self.line.series.values, most)
        low, high = self.line.series.values.min(), self.line.series.values.max()
        share = (values.astype(float) - low) / (float(high) - float(low)) if high > low else np.full(len(values), 0.5)
        return time_s, self.base + HEIGHT * share, values


def of(lines: list[Line]) -> list[Lane]:
    """The first on top. The label of numbers has their range."""
    found = []
    for place, line in enumerate(lines):
        label = line.label
        if not line.series.value_texts:
            low, high = line.series.values.min(), line.series.values.max()
            label += f" ({low:g})" if low == high else f" ({low:g}…{high:g})"
        found.append(Lane(label, line, float(len(lines) - 1 - place)))
    return found
