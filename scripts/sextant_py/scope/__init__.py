"""Triggered captures of the drive's waveform, as on an oscilloscope."""
