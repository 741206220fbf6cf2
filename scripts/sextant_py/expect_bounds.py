"""What the rows of a recording prove of a metric: the values between which it lies.

sextant-mil takes its metrics from the course between all switching instants, of which a row keeps mean, minimum and
maximum. So most metrics are known to bounds: exactly, where the window begins and ends with a row and the torque
request stands still. The definitions are those of sextant/run/metric_list.hpp. The torque request runs monotonically
within a row; a pulse that is shorter is not seen.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .expect_rows import Course, Rows
from .expect_scenario import Window

RESPONSE_SHARE = 0.95  # of a step, that the torque has covered
ROUNDING_S = 1e-9
PHASE_SHARE = math.cos(math.pi / 6)  # the largest phase of a vector of length 1, where it is smallest


@dataclass(frozen=True)
class Bounds:
    """low and high are NaN where the run has no value."""

    low: float = -math.inf
    high: float = math.inf

    def holds(self, low: float | None, high: float | None) -> bool | None:
        """Whether a value between the bounds lies within the limits, both included; None: some do, some do not. A
        metric without a value is not within."""
        least, most = -math.inf if low is None else low, math.inf if high is None else high
        if math.isnan(self.low) or self.low > most or self.high < least:
            return False
        return True if least <= self.low and self.high <= most else None


@dataclass(frozen=True)
class Part:
    """The rows of a window. `unsure_s`: by which the times of the rows may be off. [s]"""

    rows: Rows
    inside: np.ndarray  # rows that are wholly within, whatever the times are off
    touching: np.ndarray  # rows that may have a part in it
    length_s: float
    is_covered: bool  # no part of the window is without rows

    @classmethod
    def of(cls, rows: Rows, window: Window, unsure_s: float, duration_s: float) -> "Part":
        last_s = float(rows.end_s[-1])
        to_s = last_s if window.to_s is None else min(window.to_s, max(duration_s, window.from_s))
        margin = unsure_s + ROUNDING_S
        inside = (rows.begin_s >= window.from_s + unsure_s - ROUNDING_S) & (rows.end_s <= to_s - unsure_s + ROUNDING_S)
        touching = (rows.end_s > window.from_s - margin) & (rows.begin_s < to_s + margin)
        covered = rows.begin_s[0] <= window.from_s - unsure_s + ROUNDING_S
        covered &= window.to_s is None or last_s >= to_s + unsure_s - ROUNDING_S
        return cls(rows, inside, inside | touching, to_s - window.from_s, bool(covered and touching.any()))

    def smallest(self, course: Course) -> Bounds:
        return Bounds(self._reduced(course.min_low, np.min, self.touching, -np.inf),
                      self._reduced(course.min_high, np.min, self.inside, np.inf))  # fmt: skip

    def largest(self, course: Course) -> Bounds:
        return Bounds(self._reduced(course.max_low, np.max, self.inside, -np.inf),
                      self._reduced(course.max_high, np.max, self.touching, np.inf))  # fmt: skip

    def mean(self, course: Course) -> Bounds:
        return self._mean((course.mean_low, course.mean_high), (course.min_low, course.max_high))

    def mean_square(self, course: Course) -> Bounds:
        """Of values between m and M with the mean μ: from μ² to μ(M + m) − mM (Bhatia and Davis, 2000)."""
        low, high = course.min_low, course.max_high
        is_known = np.isfinite(low) & np.isfinite(high)
        has_mean = is_known & np.isfinite(course.mean_low) & np.isfinite(course.mean_high)
        m, top = np.where(is_known, low, 0.0), np.where(is_known, high, 0.0)
        means = [np.where(has_mean, mean, 0.0) for mean in (course.mean_low, course.mean_high)]
        least = np.where(means[0] * means[1] <= 0, 0.0, np.minimum(means[0] ** 2, means[1] ** 2))
        most = np.where(has_mean, np.maximum(*(mean * (top + m) - m * top for mean in means)), np.inf)
        return self._mean(
            (least, np.maximum(most, least)), (np.zeros_like(m), np.where(is_known, np.maximum(m**2, top**2), np.inf))
        )

    def _mean(self, inside: tuple[np.ndarray, np.ndarray], edge: tuple[np.ndarray, np.ndarray]) -> Bounds:
        """Over the window: of the rows wholly within their means, of the rest of the time anything that the rows at its
        ends have."""
        if self.length_s <= 0 or not self.is_covered:
            return Bounds()
        lengths = (self.rows.end_s - self.rows.begin_s)[self.inside]
        rest_s = max(0.0, self.length_s - float(lengths.sum()))
        ends = self.touching & ~self.inside
        sums = []
        for values, extremes, reduce in zip(inside, edge, (np.min, np.max), strict=True):
            total = float(np.sum(lengths * values[self.inside]))
            if rest_s > ROUNDING_S:
                total += rest_s * float(reduce(extremes[ends])) if ends.any() else math.nan
            sums.append(total / self.length_s)
        return Bounds(*sums) if not any(map(math.isnan, sums)) else Bounds()

    def _reduced(self, values: np.ndarray, reduce: Callable, of: np.ndarray, unknown: float) -> float:
        """A row without a part in the window proves nothing of an extreme within it."""
        is_outer = of is self.touching
        return float(reduce(values[of])) if of.any() and (self.is_covered or not is_outer) else unknown


def _ripple(part: Part) -> Bounds:
    low, high = part.smallest(part.rows.error), part.largest(part.rows.error)
    return Bounds(max(0.0, high.low - low.high), high.high - low.low)


def _error_max(part: Part) -> Bounds:
    low, high = part.smallest(part.rows.error), part.largest(part.rows.error)
    return Bounds(max(0.0, high.low, -low.high), max(high.high, -low.low))


def _root(bounds: Bounds) -> Bounds:
    return Bounds(math.sqrt(max(0.0, bounds.low)), math.sqrt(max(0.0, bounds.high)))


def _ripple_rms(part: Part) -> Bounds:
    """The variance is the mean square less the square of the mean."""
    square, mean = part.mean_square(part.rows.error), part.mean(part.rows.error)
    if not (math.isfinite(mean.low) and math.isfinite(mean.high)):
        return Bounds(0.0)
    most = max(mean.low**2, mean.high**2)
    least = 0.0 if mean.low * mean.high <= 0 else min(mean.low**2, mean.high**2)
    return _root(Bounds(square.low - most, square.high - least))


def _peak_current(rows: Rows) -> Bounds:
    """Of the whole run: no phase exceeds the vector, and one has cos 30° of it at least."""
    finite = rows.current_max[np.isfinite(rows.current_max)]
    low = max(PHASE_SHARE * float(finite.max()) if len(finite) else 0.0, float(rows.phase_max.max()))
    return Bounds(low, float(rows.current_max.max()))


def _response_ms(rows: Rows, step_s: float | None, unsure_s: float) -> Bounds:
    """From the step until the torque has covered 95 % of the way between the requests before and at it."""
    if step_s is None:
        return Bounds(math.nan, math.nan)
    before = rows.end_s < step_s - unsure_s - ROUNDING_S
    after = rows.end_s >= step_s + unsure_s - ROUNDING_S
    if (not before.any() and rows.begin_s[0] > ROUNDING_S) or not after.any():
        return Bounds()
    first = rows.requested[before][-1] if before.any() else 0.0
    requests = rows.requested[after][:2]
    if np.ptp(requests) != 0 or (before.sum() > 1 and rows.requested[before][-2] != first) or requests[0] == first:
        return Bounds()
    target = first + RESPONSE_SHARE * (requests[0] - first)
    is_up = requests[0] > first
    extremes = (rows.torque.max_low, rows.torque.max_high) if is_up else (rows.torque.min_low, rows.torque.min_high)
    surely, maybe = (column >= target if is_up else column <= target for column in extremes[:: 1 if is_up else -1])
    low = rows.begin_s[(rows.end_s > step_s - unsure_s - ROUNDING_S) & maybe]
    high = rows.end_s[(rows.begin_s >= step_s + unsure_s - ROUNDING_S) & surely]
    if not len(low):
        return Bounds(math.nan, math.nan)
    most = float(high[0]) - step_s + unsure_s if len(high) else math.inf
    return Bounds(1e3 * max(0.0, float(low[0]) - step_s - unsure_s), 1e3 * most)


WINDOWED: dict[str, Callable[[Part], Bounds]] = {
    "torque_ripple_pp_nm": _ripple,
    "torque_ripple_rms_nm": _ripple_rms,
    "torque_bias_nm": lambda part: part.mean(part.rows.error),
    "torque_error_rms_nm": lambda part: _root(part.mean_square(part.rows.error)),
    "torque_error_max_nm": _error_max,
    "flux_mean_wb": lambda part: part.mean(part.rows.flux),
    "flux_min_wb": lambda part: part.smallest(part.rows.flux),
    "flux_max_wb": lambda part: part.largest(part.rows.flux),
}
TORQUE_EXTREMES = ("torque_min_nm", "torque_max_nm")
TORQUE, FLUX = ("torque_mean_nm", *TORQUE_EXTREMES), ("flux_mean_wb", "flux_min_wb", "flux_max_wb")
COLUMNS = {  # of which the bounds of a metric are made
    "torque_ripple_pp_nm": TORQUE_EXTREMES,
    "torque_ripple_rms_nm": TORQUE,
    "torque_bias_nm": TORQUE,
    "torque_error_rms_nm": TORQUE,
    "torque_error_max_nm": TORQUE_EXTREMES,
    "flux_mean_wb": FLUX,
    "flux_min_wb": ("flux_min_wb",),
    "flux_max_wb": ("flux_max_wb",),
    "peak_current_a": ("current_max_a",),
    "response_time_ms": TORQUE_EXTREMES,
}


def absence(metric: str, rows: Rows) -> str:
    """Why nothing of a metric is in the recording; empty where something may be."""
    if metric not in COLUMNS:
        return "not in this recording: sextant-mil alone has it"
    lacking = [name for name in COLUMNS[metric] if name not in rows.columns]
    return f"not in this recording, which has no {' and no '.join(lacking)}" if lacking else ""


def bounds(metric: str, rows: Rows, window: Window, step_s: float | None, unsure_s: float, duration_s: float) -> Bounds:
    """Of a metric that rows say nothing of: any value."""
    if metric == "peak_current_a":
        return _peak_current(rows)
    if metric == "response_time_ms":
        return _response_ms(rows, step_s, unsure_s)
    if metric not in WINDOWED:
        return Bounds()
    return WINDOWED[metric](Part.of(rows, window, unsure_s, duration_s))
