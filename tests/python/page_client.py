"""A dashboard as a process, and a page of it without a browser."""

import asyncio
import json
import re
import struct
import subprocess
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, Self

from programs import ProgramProcess
from sextant_py.paths import ROOT
from tornado import httpclient, websocket

PATIENCE_S = 60.0
TOKEN = "token-of-the-test"


class DashboardProcess(ProgramProcess):
    """scripts/dashboard on a free port."""

    def __init__(self, domain: int, folder: Path, *arguments: str) -> None:
        command = [ROOT / "scripts" / "dashboard", "--domain", str(domain), "--port", "0", *arguments]
        super().__init__(command, folder / f"dashboard.{time.monotonic_ns()}.txt", stdin=subprocess.DEVNULL)

    def __enter__(self) -> Self:
        super().__enter__()
        wait_for(lambda: "http://" in self.text() or not self.is_running(), "the address", lambda: self.text())
        self.address = re.search(r"http://\S+", self.text())[0]
        return self

    @property
    def socket(self) -> str:
        return self.address.partition("#")[0].replace("http", "ws", 1) + "socket"

    @property
    def own_socket(self) -> str:
        """With the token, as the page of the printed address opens it."""
        return f"{self.socket}?token={TOKEN}"


def wait_for(
    condition: Callable[[], Any], what: str, words: Callable[[], str] = str, within_s: float = PATIENCE_S
) -> Any:
    end_s = time.monotonic() + within_s
    while not (found := condition()):
        assert time.monotonic() < end_s, f"waited {within_s:g} s for {what}; {words()}"
        time.sleep(0.02)
    return found


class PageClient:
    """Speaks the protocol of the page; a context."""

    def __init__(self, address: str, origin: str | None = None, host: str | None = None) -> None:
        headers = {name: value for name, value in (("Origin", origin), ("Host", host)) if value}
        self._request = httpclient.HTTPRequest(address, headers=headers)
        self._loop = asyncio.new_event_loop()

    def __enter__(self) -> Self:
        self._connection = self._run(lambda: websocket.websocket_connect(self._request))
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _run(self, begin: Callable[[], Any]) -> Any:
        async def bounded() -> Any:
            return await asyncio.wait_for(begin(), PATIENCE_S)

        return self._loop.run_until_complete(bounded())

    def close(self) -> None:
        if not self._loop.is_closed():
            self._connection.close()
            self._loop.run_until_complete(asyncio.sleep(0.05))
            self._loop.close()

    def send(self, message: Any) -> None:
        text = message if isinstance(message, str) else json.dumps(message)
        self._run(lambda: self._connection.write_message(text))

    def receive(self) -> Any:
        """The next message: an object, or a frame's bytes."""
        message = self._run(self._connection.read_message)
        assert message is not None, "the server has closed the connection"
        return message if isinstance(message, bytes) else json.loads(message)

    def until(self, wanted: Callable[[Any], Any], between: Callable[[], None] = lambda: None) -> Any:
        """The first object that meets the condition; `between` is called before each message."""
        end_s = time.monotonic() + PATIENCE_S
        last = None
        while time.monotonic() < end_s:
            between()
            last = self.receive()
            if not isinstance(last, bytes) and wanted(last):
                return last
        raise AssertionError(f"the awaited message did not come; the last was {last}")

    def message(self, kind: str) -> dict:
        return self.until(lambda found: found["type"] == kind)

    def frame(self) -> tuple[int, dict[int, list[float]]]:
        """The next frame: the drive's id, and its columns by number."""
        while not isinstance(data := self.receive(), bytes):
            pass
        kind, drive, columns, rows = struct.unpack_from("<4I", data)
        assert kind == 1
        assert len(data) == 16 + 8 * columns * rows
        values = struct.unpack_from(f"<{columns * rows}d", data, 16)
        return drive, {column: list(values[column * rows : (column + 1) * rows]) for column in range(columns)}
