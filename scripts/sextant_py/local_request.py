"""Requests to a running program on a local socket of its owner."""

import json
import socket
from pathlib import Path
from typing import Any

from .errors import EndedError, UserError

REPLY_S = 5.0  # for which a program's reply is waited for
LARGEST = 1 << 20  # bytes of a reply


def ask(path: str | Path, request: str, absent: str) -> str:
    """The reply to a request. A program that is not there, or does not reply, is a UserError.

    absent: what the sentence says then, with what to do
    """
    with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as client:
        client.settimeout(REPLY_S)
        try:
            client.connect(str(path))
            client.send(request.encode(errors="replace"))
            return client.recv(LARGEST).decode(errors="replace")
        except TimeoutError:
            raise EndedError(f"no reply on {path} within {REPLY_S:g} s.") from None
        except OSError as error:
            reason, _, what_to_do = absent.partition("; ")
            raise UserError(f"{reason} on {path}: {error.strerror or error}; {what_to_do}") from None


def described(path: str | Path, absent: str) -> list[dict[str, Any]]:
    """What the program describes: objects of key, unit, meaning and so on. Without a list it is a UserError."""
    reply = ask(path, "describe", absent)
    try:
        return json.loads(reply)
    except ValueError:
        raise UserError(f"the program on {path} describes no keys: {reply}") from None


def order(path: str | Path, request: str, what: str, absent: str) -> list[str]:
    """The lines of the reply behind its "ok"; a refusal is a UserError, one sentence. what: that is refused."""
    reply = ask(path, request, absent)
    head, *lines = reply.splitlines() or [""]
    if head != "ok":
        problems = "; ".join(" ".join(line.split()) for line in reply.splitlines() if line.strip())
        raise UserError(f"{what} is refused: {problems or 'the program has ended'}")
    return lines
