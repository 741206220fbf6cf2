"""Parsers of the programs' arguments."""

import argparse
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


def add_runs(parser: argparse.ArgumentParser, what: str = "runs") -> None:
    """--jobs and --mil, of a program that runs sextant-mil."""
    said = f"{what} at a time (default: all cores)"
    parser.add_argument("--jobs", type=from_one, default=os.cpu_count(), metavar="N", help=said)
    parser.add_argument("--mil", type=Path, metavar="PATH", help="sextant-mil to use (default: that of build/release)")
