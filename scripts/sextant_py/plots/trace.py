"""The rows of a trace between two times."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np


@dataclass(frozen=True)
class Trace:
    """Rows of a trace that end in a span of time; minimum and maximum are those within a row."""

    t_s: np.ndarray
    values: dict[str, np.ndarray]

    def __getitem__(self, name: str) -> np.ndarray:
        return self.values[name]

    @cached_property
    def error(self) -> tuple[np.ndarray, np.ndarray]:
        """Lowest and highest torque error of each row. [N·m]

        Within a row the reference is a straight line, so that both are too wide by its rise within the row at most.
        """
        reference = self["torque_reference_nm"]
        before = np.concatenate((reference[:1], reference[:-1]))
        low = self["torque_min_nm"] - np.maximum(before, reference)
        high = self["torque_max_nm"] - np.minimum(before, reference)
        return low, high

    def between(self, begin_s: float, end_s: float) -> "Trace":
        wanted = (self.t_s > begin_s) & (self.t_s <= end_s)
        return Trace(self.t_s[wanted], {name: data[wanted] for name, data in self.values.items()})
