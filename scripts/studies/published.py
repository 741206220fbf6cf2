"""The torque that a drive publishes as available, and by it the torque that is due."""

import math
from collections.abc import Mapping


def published(metrics: Mapping, speed: float, torque: float) -> float | None:
    """In the direction of the command; None: the gates are off. [N·m]"""
    return metrics.get("torque_motoring_nm" if torque * speed >= 0 else "torque_regenerating_nm")


def mean_and_due(metrics: Mapping, speed: float, torque: float) -> tuple[float, float]:
    """The mean torque, and the commanded one as far as it is published. [N·m]"""
    due = math.copysign(min(abs(torque), published(metrics, speed, torque) or 0.0), torque)
    return torque + metrics["torque_bias_nm"], due
