"""How the programs end when something outside them is wrong."""

import signal
import sys
from collections.abc import Callable


class UserError(Exception):
    """What went wrong and what to do about it, in one sentence."""


def run(program: str, main: Callable[[list[str]], int]) -> None:
    """Runs main on the command line; a UserError becomes one line on stderr and exit status 1.

    SIGTERM ends it as Ctrl-C does. Ctrl-C is taken even where a shell started the program in the background.
    """
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
