"""A web server with a loop in a thread of its own: the pages of one lane cannot delay those of another."""

import asyncio
import socket
import threading
from collections.abc import Callable
from typing import Any

from tornado import httpserver, ioloop, iostream

from .server import LARGEST_MESSAGE, Hub, application

LARGEST_QUEUE = 16 << 20  # bytes that a page has not taken yet; a capture of a second has half of it
IDLE_S = 10.0  # a connection without a request for so long is closed


class _Stream(iostream.IOStream):
    """Closes where more waits than has room: nobody counts replies to pings, which wait too."""

    def write(self, data: bytes | memoryview) -> Any:
        try:
            return super().write(data)
        except iostream.StreamBufferFullError:
            self.close()
            raise iostream.StreamClosedError from None


class _Server(httpserver.HTTPServer):
    """Reports each connection that it serves no more: one that was closed or has become a page's WebSocket."""

    def initialize(self, *arguments: Any, report_end: Callable[[], None], **options: Any) -> None:
        super().initialize(*arguments, **options)
        self._report_end = report_end

    def on_close(self, server_conn: object) -> None:
        self._report_end()
        super().on_close(server_conn)


class Lane:
    """Serves the connections that it is handed."""

    def __init__(self, name: str, make_hub: Callable[[], Hub], most_connections: int | None = None) -> None:
        """most_connections: without their WebSockets, of which the hub has a limit; none by default."""
        self._make_hub, self._most = make_hub, most_connections
        self.open = 0  # connections that were taken, served already or not, and have not ended
        self._count = threading.Lock()  # of `open`
        self._is_ready = threading.Event()
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self.hub: Hub
        self._server: _Server
        self._loop: ioloop.IOLoop

    def start(self) -> None:
        self._thread.start()
        self._is_ready.wait()

    def stop(self) -> None:
        self._loop.add_callback(self._loop.stop)
        self._thread.join(5.0)

    def _run(self) -> None:
        asyncio.set_event_loop(asyncio.new_event_loop())
        self._loop = ioloop.IOLoop.current()
        self.hub = self._make_hub()
        limits = {"max_body_size": LARGEST_MESSAGE, "idle_connection_timeout": IDLE_S, "body_timeout": IDLE_S}
        self._server = _Server(application(self.hub), report_end=self._end, **limits)
        self._is_ready.set()
        self._loop.start()

    def take(self, connection: socket.socket, address: tuple) -> bool:
        """A connection whose first request has not been read; from any thread. False: there is no room for it."""
        with self._count:
            if self._most is not None and self.open >= self._most:
                return False
            self.open += 1
        self._loop.add_callback(self._serve, connection, address)
        return True

    def _end(self) -> None:
        with self._count:
            self.open -= 1

    def _serve(self, connection: socket.socket, address: tuple) -> None:
        stream = _Stream(connection, max_buffer_size=4 * LARGEST_MESSAGE, max_write_buffer_size=LARGEST_QUEUE)
        self._server.handle_stream(stream, address)
