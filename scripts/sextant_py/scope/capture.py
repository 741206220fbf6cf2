"""A stretch of the waveform around a trigger."""

from dataclasses import dataclass

import numpy as np

from ..recording.losses import missing_periods


@dataclass(frozen=True)
class Capture:
    """Rows of DriveWaveform, one a control period, and the instant of the trigger."""

    rows: np.ndarray
    trigger_ns: int  # [ns] on the drive's clock
    trigger: str  # as it was written, or why there is a capture without it

    @property
    def times_s(self) -> np.ndarray:
        """From the trigger. [s]"""
        return (self.rows["t_ns"].astype(np.int64) - self.trigger_ns) * 1e-9

    @property
    def periods_missing(self) -> int:
        """Control periods between the first and the last row that have no row."""
        return missing_periods(self.rows)
