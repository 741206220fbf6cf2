"""What pages without the token can cost the dashboard: a bounded number, bounded memory, and no command of others."""

import asyncio
import json
import socket
import threading
from collections.abc import Callable
from contextlib import ExitStack, suppress

import pytest
from sextant_py.dashboard import backlog, door, lane, server
from sextant_py.dashboard.access import Access
from sextant_py.dashboard.door import Door, token_of
from sextant_py.dashboard.lane import Lane
from sextant_py.dashboard.onlookers import Onlookers
from sextant_py.dashboard.server import Hub
from tornado import netutil, websocket

PATIENCE_S = 300.0  # the machine may stand still for seconds; only a defect takes so long
TOKEN = "token-of-the-test"
UPGRADE = (
    "GET {path} HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
)
STANDING = {"type": "command", "allowed": True, "holder": None}
DOMAIN = 231  # no participant is made: no scope is armed


def of(frames: range) -> list[bytes]:
    return [bytes([number]) for number in frames]


def taken(reader: backlog.Reader) -> list[bytes]:
    return list(iter(reader.next, None))


def test_a_reader_gets_what_is_kept_and_then_each_new_frame() -> None:
    frames = backlog.Backlog(10)
    for frame in of(range(25)):
        frames.append(frame)
    reader = backlog.Reader(frames, 3)
    assert taken(reader) == of(range(15, 25))
    for frame in of(range(25, 28)):
        frames.append(frame)
    assert taken(reader) == of(range(25, 28)), "three late is not too late"
    assert reader.dropped == 0


def test_a_reader_that_is_late_goes_on_with_the_newest_and_counts() -> None:
    frames = backlog.Backlog(100)
    reader = backlog.Reader(frames, 3)
    assert reader.next() is None
    for frame in of(range(4)):
        frames.append(frame)
    assert taken(reader) == of(range(3, 4))
    assert reader.dropped == 3
    for frame in of(range(4, 204)):
        frames.append(frame)
    assert taken(reader) == of(range(203, 204))
    assert reader.dropped == 3 + 199


def test_frames_that_are_gone_before_they_are_read_are_counted() -> None:
    """The first frames are read slowly, as by a page that has just been opened."""
    frames = backlog.Backlog(10)
    for frame in of(range(10)):
        frames.append(frame)
    reader = backlog.Reader(frames, 3)
    assert reader.next() == bytes([0])
    for frame in of(range(10, 25)):
        frames.append(frame)
    assert taken(reader) == of(range(15, 25))
    assert reader.dropped == 14


@pytest.mark.parametrize(
    ("line", "token"),
    [
        (b"GET /socket?token=abc HTTP/1.1", "abc"),
        (b"GET /socket?x=1&token=a%2Bb HTTP/1.1", "a+b"),
        (b"GET /socket HTTP/1.1", None),
        (b"GET /js/main.js?token=abc HTTP/1.1", None),
        (b"GET", None),
        (b"", None),
        (b"GET //[/socket?token=abc HTTP/1.1", None),
        (b"\xff\xfe \xfd?token=\xfc x", None),
    ],
)
def test_the_token_of_a_request(line: bytes, token: str | None) -> None:
    assert token_of(line) == token


def run(test: Callable) -> None:
    async def bounded() -> None:
        await asyncio.wait_for(test(), PATIENCE_S)

    asyncio.run(bounded())


class Serving:
    """A door and its lanes, with as many places as a test needs."""

    def __init__(self, most_pages: int = 2, most_connections: int = 4, pause_s: float = 0.0) -> None:
        access = Access("127.0.0.1", TOKEN)
        self.said: list[str] = []
        limits = {"most_pages": most_pages, "pause_s": pause_s, "say": self.said.append}
        self.public = Lane("public", lambda: Hub(DOMAIN, access, Onlookers(STANDING), **limits), most_connections)
        self.trusted = Lane("trusted", lambda: Hub(DOMAIN, access, Onlookers(STANDING), say=self.said.append))
        for one in (self.public, self.trusted):
            one.start()
        self.sockets = netutil.bind_sockets(0, "127.0.0.1")
        self.address = self.sockets[0].getsockname()[:2]
        self.door = Door(access, self.public, self.trusted)
        self.door.open(self.sockets)
        self._stack = ExitStack()

    async def __aenter__(self) -> "Serving":
        return self

    async def __aexit__(self, *_: object) -> None:
        self._stack.close()
        for one in (self.public, self.trusted):
            one.stop()

    def idle(self) -> socket.socket:
        """A connection that sends nothing."""
        one = socket.socket()
        self._stack.callback(one.close)
        one.setblocking(False)
        one.connect_ex(self.address)
        return one

    async def opened(self, path: str = "/socket", receive_buffer: int | None = None) -> tuple[str, socket.socket]:
        """The first line of the reply, and the connection."""
        one = socket.socket()
        self._stack.callback(one.close)
        if receive_buffer:
            one.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive_buffer)
        one.setblocking(False)
        loop = asyncio.get_running_loop()
        await loop.sock_connect(one, self.address)
        await loop.sock_sendall(one, UPGRADE.format(path=path).encode())
        return (await loop.sock_recv(one, 512)).partition(b"\r\n")[0].decode(), one


async def until(condition: Callable[[], object]) -> None:
    """The bound of time is that of the test."""
    while not condition():
        await asyncio.sleep(0.01)


def test_idle_connections_keep_nobody_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(door, "MOST_WAITING", 8)
    monkeypatch.setattr(door, "PATIENCE_S", PATIENCE_S)

    async def test() -> None:
        async with Serving() as serving:
            for _ in range(100):
                serving.idle()
            await until(lambda: serving.door.turned_away >= 92)
            first, _ = await serving.opened()
            assert "101" in first
            for _ in range(100):
                serving.idle()
            first, _ = await serving.opened(f"/socket?token={TOKEN}")
            assert "101" in first
            await until(lambda: len(serving.trusted.hub.pages) == len(serving.public.hub.pages) == 1)

    run(test)


def test_a_line_that_does_not_end_is_turned_away(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(door, "PATIENCE_S", 0.3)

    async def test() -> None:
        async with Serving() as serving:
            loop = asyncio.get_running_loop()
            for begin in (b"", b"GET /socket", b"x" * 20_000):
                one = socket.create_connection(serving.address)
                one.setblocking(False)
                await loop.sock_sendall(one, begin)
                before = serving.door.turned_away
                await until(lambda before=before: serving.door.turned_away > before)
                one.close()

    run(test)


def test_pages_without_the_token_are_limited_and_pages_with_it_are_not() -> None:
    async def test() -> None:
        async with Serving(most_pages=2) as serving:
            kept = [await serving.opened() for _ in range(2)]
            assert all("101" in first for first, _ in kept)
            await until(lambda: len(serving.public.hub.pages) == 2)
            assert "503 Too many pages" in (await serving.opened())[0]
            assert "503 Too many pages" in (await serving.opened("/socket?token=wrong"))[0]
            for _ in range(10):
                assert "101" in (await serving.opened(f"/socket?token={TOKEN}"))[0]
            await until(lambda: len(serving.trusted.hub.pages) == 10)
            assert len(serving.public.hub.pages) == 2
            kept[0][1].close()
            await until(lambda: len(serving.public.hub.pages) == 1)
            assert "101" in (await serving.opened())[0], "the place is free again"

    run(test)


def test_connections_without_the_token_are_limited() -> None:
    """Each has sent a part of a request, so that it waits for no first line any more."""

    async def test() -> None:
        async with Serving(most_connections=4) as serving:
            loop = asyncio.get_running_loop()
            for _ in range(4):
                one = serving.idle()
                await asyncio.sleep(0.01)
                await loop.sock_sendall(one, b"GET / HTTP/1.1\r\nHost: 127")
            await until(lambda: serving.public.open == 4)
            assert "503 Too many connections" in (await serving.opened())[0]
            assert "101" in (await serving.opened(f"/socket?token={TOKEN}"))[0]

    run(test)


def test_connections_are_limited_while_the_loop_that_serves_them_stands_still() -> None:
    """Those that are admitted are served afterwards, and their places are free again when they are closed."""

    async def test() -> None:
        async with Serving(most_connections=4) as serving:
            loop = asyncio.get_running_loop()
            is_still, is_released = threading.Event(), threading.Event()
            serving.public.hub.loop.add_callback(lambda: (is_still.set(), is_released.wait()))
            await asyncio.to_thread(is_still.wait)
            pairs = [socket.socketpair() for _ in range(20)]
            try:
                for page, connection in pairs:
                    page.setblocking(False)
                    serving.door._admit(connection, ("127.0.0.1", 0), with_line(b"GET / HTTP/1.1"))
                assert serving.door.turned_away == 16
            finally:
                is_released.set()
            for page, _ in pairs:
                with suppress(BrokenPipeError):
                    await loop.sock_sendall(page, b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
            replies = [(await loop.sock_recv(page, 64)).partition(b"\r\n")[0] for page, _ in pairs]
            assert [b" 200 " in reply for reply in replies] == [True] * 4 + [False] * 16
            assert all(b"503 Too many connections" in reply for reply in replies[4:])
            for page, _ in pairs:
                page.close()
            await until(lambda: serving.public.open == 0)
            assert "101" in (await serving.opened())[0]

    run(test)


def with_line(line: bytes) -> asyncio.Future:
    """What the door gets when the first line has come."""
    future = asyncio.get_running_loop().create_future()
    future.set_result(line)
    return future


def text_frame(message: dict) -> bytes:
    """As a client sends it, masked by zeros."""
    text = json.dumps(message).encode()
    assert len(text) < 126
    return bytes([0x81, 0x80 | len(text), 0, 0, 0, 0]) + text


PING = bytes([0x89, 0x80 | 125, 0, 0, 0, 0]) + bytes(125)


def test_what_a_page_does_not_read_does_not_pile_up(monkeypatch: pytest.MonkeyPatch) -> None:
    """It asks for the telemetry of two drives again and again, and takes none."""
    monkeypatch.setattr(server, "SLOW_S", PATIENCE_S)
    monkeypatch.setattr(server, "BACKLOG_S", 1)
    size = 100_000

    async def test() -> None:
        async with Serving() as serving:
            hub = serving.public.hub
            _, one = await serving.opened(receive_buffer=4096)
            await until(lambda: hub.pages)
            (page,) = hub.pages
            for number in range(server.FRAMES_HZ):
                for drive_id in (1, 2):
                    hub.deliver(drive_id, bytes([number]) * size)
            loop = asyncio.get_running_loop()
            for _ in range(300):
                for drive_id in (1, 2):
                    await loop.sock_sendall(one, text_frame({"type": "watch", "drive": drive_id}))
            most = 0
            while page.dropped < 100:
                hub.report({"type": "status", "problems": [], "drives": []})
                hub.deliver(1, bytes(size))
                await asyncio.sleep(0.001)
                most = max(most, sum(not sent.done() for _, sent in page._under_way))
            assert most <= server.MOST_UNDER_WAY + 1, "one frame, and so many other messages"
            assert hub.pages == {page}
            monkeypatch.setattr(server, "SLOW_S", 0.01)
            hub.report({"type": "status", "problems": [], "drives": []})
            await until(lambda: not hub.pages)
            assert any("has taken nothing for 0.01 s and is disconnected" in sentence for sentence in serving.said)

    run(test)


def test_replies_to_pings_do_not_pile_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lane, "LARGEST_QUEUE", 100_000)

    async def test() -> None:
        async with Serving() as serving:
            _, one = await serving.opened(receive_buffer=4096)
            await until(lambda: serving.public.hub.pages)
            loop = asyncio.get_running_loop()
            with pytest.raises(OSError):
                while True:
                    await loop.sock_sendall(one, PING * 100)
            await until(lambda: not serving.public.hub.pages)

    run(test)


def test_messages_of_a_page_without_the_token_wait_for_each_other() -> None:
    async def test() -> None:
        async with Serving(pause_s=PATIENCE_S) as serving:
            _, one = await serving.opened()
            loop = asyncio.get_running_loop()
            for drive_id in range(100):
                await loop.sock_sendall(one, text_frame({"type": "watch", "drive": drive_id}))
            hub = serving.public.hub
            await until(lambda: hub.pages and next(iter(hub.pages)).watched is not None)
            await asyncio.sleep(0.3)
            assert next(iter(hub.pages)).watched == 0

    run(test)


def test_pages_without_the_token_cannot_keep_the_others_waiting() -> None:
    """The loop of the lane without the token stands still; a page with the token is served."""

    async def test() -> None:
        async with Serving() as serving:
            await serving.opened()
            page = await websocket.websocket_connect(
                "ws://{}:{}/socket?token={}".format(*serving.address, TOKEN), ping_interval=0
            )
            is_released = threading.Event()
            serving.public.hub.loop.add_callback(is_released.wait)
            try:
                for _ in range(20):
                    await page.write_message('{"type": "demand"}')
                    while json.loads(await page.read_message())["type"] != "refused":
                        pass
            finally:
                is_released.set()
            page.close()

    run(test)


def test_a_request_with_a_large_body_is_refused() -> None:
    async def test() -> None:
        async with Serving() as serving:
            loop = asyncio.get_running_loop()
            one = serving.idle()
            await asyncio.sleep(0.01)
            head = "POST / HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 100000000\r\n\r\n"
            await loop.sock_sendall(one, head.encode())
            assert b" 400 " in (await loop.sock_recv(one, 512)).partition(b"\r\n")[0]

    run(test)
