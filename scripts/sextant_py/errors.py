"""How the programs end when something outside them is wrong."""

import errno
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress

from . import shell_request

FAILED = 1  # exit status of a command that a problem has ended
REFUSED = 2  # of one that has not run: the command, a file or a key is wrong, or the machine lacks what it needs

EXHAUSTED = frozenset(
    (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EMFILE, errno.ENFILE, errno.ENOMEM, errno.EPIPE)
)  # errors of the system that no other argument avoids


class UserError(Exception):
    """What went wrong and what to do about it, in one sentence."""


class EndedError(UserError):
    """A problem that ended what was right and had begun, as a drive that does not answer."""


def status_of(error: BaseException) -> int:
    """FAILED where a problem ended the command, also one of the system behind a sentence about it; else REFUSED."""
    if isinstance(error, EndedError):
        return FAILED
    while error is not None:
        if isinstance(error, OSError) and error.errno in EXHAUSTED:
            return FAILED
        error = error.__cause__ or error.__context__
    return REFUSED


def output_of(*command: object, with_errors: bool = False) -> str:
    """What a program of the gates writes to its standard output, and with_errors to its standard error."""
    words = [str(word) for word in command]
    try:
        done = subprocess.run(words, capture_output=True, text=True, check=False)
    except FileNotFoundError:
        raise UserError(f"{words[0]} is missing; scripts/setup --gates installs it.") from None
    if done.returncode:
        raise UserError(f"{' '.join(words)} failed: {' '.join((done.stderr or done.stdout).split())[-300:]}")
    return done.stdout + (done.stderr if with_errors else "")


def reason_of(error: OSError) -> str:
    """What the system says, with the file that it is about where there is one."""
    reason = error.strerror or " ".join(str(error).split())
    return f"{error.filename}: {reason}" if error.filename is not None else reason


def _flush() -> None:
    """Writes what standard output holds back. What cannot be written is dropped: the interpreter's end would fail."""
    if sys.stdout is None:
        return
    try:
        sys.stdout.flush()
    except OSError as error:
        nothing = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nothing, sys.stdout.fileno())
        os.close(nothing)
        if isinstance(error, BrokenPipeError):
            raise
        raise EndedError(f"standard output cannot be written: {error.strerror}.") from None


def _status_of(main: Callable[[list[str]], int]) -> int:
    """What main returns, or exits with as argparse does, once its output is written."""
    try:
        status = main(sys.argv[1:])
    except SystemExit as end:
        status = end.code
    _flush()
    return status


def status_or_refusal(program: str, perform: Callable[[], int]) -> int:
    """The status of perform; where it raises a UserError, one line on stderr and the status of that."""
    try:
        return perform()
    except UserError as error:
        print(f"{program}: {error}", file=sys.stderr)
        return status_of(error)


def run(program: str, main: Callable[[list[str]], int]) -> None:
    """Runs main on the command line; a UserError or an error of the system is one line on stderr and an exit status.

    A shell that asks for completions is answered instead. SIGTERM ends it as Ctrl-C does. Ctrl-C is taken even where a
    shell started the program in the background. Where a terminal or a file takes no UTF-8, what it lacks becomes "?".
    """
    if shell_request.is_requested():
        shell_request.answer_request()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.default_int_handler)
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")
    try:
        status = status_or_refusal(program, lambda: _status_of(main))
    except KeyboardInterrupt:
        status = 130
    except BrokenPipeError:
        sys.stderr.close()
        status = FAILED
    except OSError as error:
        print(f"{program}: {reason_of(error)}.", file=sys.stderr)
        status = status_of(error)
    except UnicodeError as error:
        print(f"{program}: a text is not in the encoding that is expected: {error}.", file=sys.stderr)
        status = REFUSED
    with suppress(OSError, UserError):
        _flush()  # what an error has left
    sys.exit(status)
