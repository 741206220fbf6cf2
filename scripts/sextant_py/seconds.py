"""Options in seconds."""

import argparse
import math


def finite_seconds(text: str) -> float:
    """`text` as a finite time [s]; a type of argparse."""
    try:
        seconds = float(text)
    except ValueError:
        seconds = math.nan
    if not math.isfinite(seconds):
        raise argparse.ArgumentTypeError(f'expected a time in seconds, got "{text}"')
    return seconds


def positive_seconds(text: str) -> float:
    """`text` as a finite time above zero [s]; a type of argparse."""
    try:
        seconds = float(text)
    except ValueError:
        seconds = math.nan
    if not 0 < seconds < math.inf:
        raise argparse.ArgumentTypeError(f'expected a time above 0 s, got "{text}"')
    return seconds
