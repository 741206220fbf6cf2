"""Times of command lines."""

import argparse


def positive_seconds(text: str) -> float:
    """A time above 0 s."""
    try:
        seconds = float(text)
    except ValueError:
        seconds = 0.0
    if not seconds > 0:
        raise argparse.ArgumentTypeError(f'expected a time above 0 s, got "{text}"')
    return seconds
