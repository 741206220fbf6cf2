"""Triggered captures of the drive's waveform, as on an oscilloscope."""

from .program import main

__all__ = ["main"]
