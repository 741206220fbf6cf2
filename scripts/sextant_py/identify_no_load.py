"""Magnetising inductance at the whole flux, of a shaft that coasts.

Without torque there is no slip, and the stator flux is L_s i: the drive's estimate of the flux, which at speed follows
from the volt-seconds, and the measured current give L_s at that flux, however the iron saturates.
"""

import math
from dataclasses import dataclass

import numpy as np

from .errors import UserError
from .identify_machine import InverseGamma

PARTS = 10  # of the window, whose means scatter


@dataclass(frozen=True)
class NoLoad:
    flux_wb: float
    current_a: float
    sigma: float  # relative standard deviation of L_s
    speed: float  # [rad/s]
    acceleration: float = 0.0  # [rad/s²]

    @property
    def l_s(self) -> float:
        """[H]"""
        return self.flux_wb / self.current_a

    def of(self, machine: InverseGamma) -> InverseGamma:
        """The machine at this flux."""
        return machine.with_stator_inductance(self.l_s)


def current_along(angle: np.ndarray, phases: list[np.ndarray]) -> np.ndarray:
    """Of phase currents, along a flux at this angle: no noise or offset raises it, as they do the magnitude. [A]"""
    turned = [current * np.cos(angle - k * 2 * np.pi / 3) for k, current in enumerate(phases)]
    return 2 / 3 * np.sum(turned, axis=0)


def acceleration(time: np.ndarray, speed: np.ndarray) -> float:
    """By the line through the speed. [s], [rad/s]"""
    away = time - np.mean(time)
    return float(away @ speed / (away @ away))


def fit(flux: np.ndarray, current: np.ndarray, speed: np.ndarray) -> NoLoad:
    """Of samples over the time without torque. [Wb], [A], [rad/s]"""
    fluxes, currents = (np.array([np.mean(part) for part in np.array_split(x, PARTS)]) for x in (flux, current))
    if flux.size < 2 * PARTS or not np.all(currents > 0):
        raise UserError("the drive was not magnetised while the shaft coasted: see the trace of no_load.")
    ratios = fluxes / currents
    sigma = float(np.std(ratios, ddof=1) / np.mean(ratios)) / math.sqrt(PARTS)
    return NoLoad(float(np.mean(flux)), float(np.mean(current)), sigma, float(np.mean(speed)))
