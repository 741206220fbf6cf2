"""Where connections arrive: each goes to the lane of its first request, and only so many wait without one."""

import asyncio
import functools
import socket
from urllib.parse import parse_qs, urlsplit

from tornado import netutil

from .access import Access
from .lane import Lane

MOST_WAITING = 64  # connections without a first line
PATIENCE_S = 5.0  # for it
PAUSE_S = 0.05  # before a part of it is looked at again
LONGEST_LINE = 8192  # bytes
SOCKET = "/socket"
NO_ROOM = b"HTTP/1.1 503 Too many connections\r\nConnection: close\r\nContent-Length: 0\r\n\r\n"


def token_of(line: bytes) -> str | None:
    """The token in the first line of a request for the WebSocket; None where there is none."""
    words = line.decode("latin-1").split(" ")
    try:
        target = urlsplit(words[1])
        tokens = parse_qs(target.query).get("token", [])
    except (IndexError, ValueError):
        return None
    return tokens[0] if target.path == SOCKET and tokens else None


class Door:
    """Accepts connections on the loop that starts it.

    The WebSocket of a page with the token has a lane of its own, without a limit. Of all other connections, those for
    the files and captures of every page too, the number is limited, and one that waits without sending gives way to a
    new one: idle connections keep nobody out who sends a request.
    """

    def __init__(self, access: Access, public: Lane, trusted: Lane | None) -> None:
        self._access, self._public, self._trusted = access, public, trusted
        self._waiting: dict[asyncio.Task, None] = {}  # in the order of arrival
        self.turned_away = 0

    def open(self, sockets: list[socket.socket]) -> None:
        for one in sockets:
            netutil.add_accept_handler(one, self._accept)

    def _accept(self, connection: socket.socket, address: tuple) -> None:
        connection.setblocking(False)
        if len(self._waiting) >= MOST_WAITING:
            oldest = next(iter(self._waiting))
            del self._waiting[oldest]
            oldest.cancel()
        task = asyncio.get_running_loop().create_task(first_line_in_time(connection))
        self._waiting[task] = None
        task.add_done_callback(functools.partial(self._admit, connection, address))

    def _admit(self, connection: socket.socket, address: tuple, task: asyncio.Task) -> None:
        self._waiting.pop(task, None)
        if task.cancelled() or task.exception() is not None:
            self.turned_away += 1
            connection.close()
            return
        token = token_of(task.result())
        is_trusted = self._trusted and token is not None and self._access.may_command(token)
        lane = self._trusted if is_trusted else self._public
        if not lane.take(connection, address):
            self._turn_away(connection)

    def _turn_away(self, connection: socket.socket) -> None:
        self.turned_away += 1
        with connection:
            try:
                connection.send(NO_ROOM)
            except OSError:
                return


async def first_line_in_time(connection: socket.socket) -> bytes:
    async with asyncio.timeout(PATIENCE_S):
        return await first_line(connection)


async def first_line(connection: socket.socket) -> bytes:
    """The first line that arrives, which stays to be read. OSError where none can come."""
    while True:
        await readable(connection)
        found = connection.recv(LONGEST_LINE, socket.MSG_PEEK)
        if b"\r\n" in found:
            return found.partition(b"\r\n")[0]
        if not found or len(found) == LONGEST_LINE:
            raise ConnectionError("no first line")
        await asyncio.sleep(PAUSE_S)  # what is there stays readable


async def readable(connection: socket.socket) -> None:
    loop = asyncio.get_running_loop()
    future = loop.create_future()
    loop.add_reader(connection, lambda: future.done() or future.set_result(None))
    try:
        await future
    finally:
        loop.remove_reader(connection)
