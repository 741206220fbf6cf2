"""The Python side of Sextant: vehicle control unit, telemetry monitor, recorder and plots."""
