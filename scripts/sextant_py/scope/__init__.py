"""Triggered captures of the drive's waveform, as on an oscilloscope."""


def main(arguments: list[str]) -> int:
    from .program import main as perform

    return perform(arguments)
