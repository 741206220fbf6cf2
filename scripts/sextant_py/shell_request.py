"""A shell that asks a program for completions."""

import argparse
import os
from typing import Any

REQUESTED = "_ARGCOMPLETE"  # set by the shell that asks for completions


def answer_request() -> None:
    """Lets the next parser that is asked to parse answer the shell and end the program."""
    import argcomplete

    names = ("parse_known_args", "parse_known_intermixed_args")
    kept = {name: getattr(argparse.ArgumentParser, name) for name in names}

    def answer(parser: argparse.ArgumentParser, *_: Any, **__: Any) -> None:
        for name, function in kept.items():
            setattr(argparse.ArgumentParser, name, function)
        argcomplete.autocomplete(parser)

    for name in kept:
        setattr(argparse.ArgumentParser, name, answer)


def is_requested() -> bool:
    return REQUESTED in os.environ
