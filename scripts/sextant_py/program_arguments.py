"""Parsers of the programs' arguments."""

import argparse
import math
import os
from pathlib import Path


def parser_of(program: str, description: str, epilog: str) -> argparse.ArgumentParser:
    """epilog: the examples, whose lines stay as they are."""
    raw = argparse.RawDescriptionHelpFormatter
    return argparse.ArgumentParser(prog=program, description=description, epilog=epilog, formatter_class=raw)


def from_one(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"expected a number from 1, got {text}")
    return int(text)


def _seconds(text: str, least: float, what: str) -> float:
    try:
        seconds = float(text)
    except ValueError:
        seconds = math.nan
    if not least < seconds < math.inf:
        raise argparse.ArgumentTypeError(f'expected a time {what}, got "{text}"')
    return seconds


def finite_seconds(text: str) -> float:
    return _seconds(text, -math.inf, "in seconds")


def positive_seconds(text: str) -> float:
    return _seconds(text, 0.0, "above 0 s")


def add_span(parser: argparse.ArgumentParser) -> None:
    """--from and --to, of a program that draws signals over time."""
    for name, end in (("from", "begin"), ("to", "end")):
        said = f"{end} of the span to draw [s]"
        parser.add_argument(f"--{name}", dest=f"{end}_s", type=finite_seconds, metavar="S", help=said)


def add_runs(parser: argparse.ArgumentParser, what: str = "runs") -> None:
    """--jobs and --mil, of a program that runs sextant-mil."""
    said = f"{what} at a time (default: all cores)"
    parser.add_argument("--jobs", type=from_one, default=os.cpu_count(), metavar="N", help=said)
    parser.add_argument("--mil", type=Path, metavar="PATH", help="sextant-mil to use (default: that of build/release)")
