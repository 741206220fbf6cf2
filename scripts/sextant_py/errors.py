"""How the programs end when something outside them is wrong."""

import os
import signal
import subprocess
import sys
from collections.abc import Callable


class UserError(Exception):
    """What went wrong and what to do about it, in one sentence."""


def output_of(*command: object, with_errors: bool = False) -> str:
    """What a program of the gates writes to its standard output, and with_errors to its standard error."""
    words = [str(word) for word in command]
    try:
        done = subprocess.run(words, capture_output=True, text=True, check=False)
    except FileNotFoundError:
        raise UserError(f"{words[0]} is missing; scripts/setup --gates installs it.") from None
    if done.returncode:
        raise UserError(f"{' '.join(words)} failed: {(done.stderr or done.stdout).strip()[-300:]}")
    return done.stdout + (done.stderr if with_errors else "")


def run(program: str, main: Callable[[list[str]], int]) -> None:
    """Runs main on the command line; a UserError becomes one line on stderr and exit status 1.

    A shell that asks for completions is answered instead. SIGTERM ends it as Ctrl-C does. Ctrl-C is taken even where a
    shell started the program in the background.
    """
    if "_ARGCOMPLETE" in os.environ:
        from .completion import answer_request

        answer_request()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.default_int_handler)
    try:
        status = main(sys.argv[1:])
    except UserError as error:
        print(f"{program}: {error}", file=sys.stderr)
        status = 1
    except KeyboardInterrupt:
        status = 130
    except BrokenPipeError:
        sys.stderr.close()
        status = 1
    sys.exit(status)
