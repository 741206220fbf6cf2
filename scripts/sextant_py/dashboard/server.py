"""The web server: the page's files, one WebSocket a page, and what they are sent."""

import asyncio
import itertools
import json
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from tornado import ioloop, web, websocket

from ..contract import Contract
from ..errors import UserError
from ..scope import quantities
from ..scope.capture import Capture
from ..scope.scope import MODES
from ..scope.trigger_text import FORMS
from ..telemetry_contract import enumerators, rejections
from . import layout, scope_feed
from .access import Access
from .backlog import Backlog, Reader
from .captures import KEPT, Captures
from .command_desk import CommandDesk, RefusedError
from .fault_desk import FaultDesk
from .frames import columns
from .scope_feed import ScopeFeed
from .source import FRAMES_HZ

PAGE = Path(__file__).with_name("page")
LARGEST_MESSAGE = 65536  # bytes, of a page
LONGEST_INTEGER = 18  # characters, of a message
BACKLOG_S = 30  # of telemetry that a page is sent at first
MOST_BEHIND = FRAMES_HZ  # frames that a page may be late by
MOST_UNDER_WAY = FRAMES_HZ  # messages that a page has not taken yet
PING_S = 10  # a page without a reply for so long is disconnected
SLOW_S = 10.0  # and so is one that has not taken a message for so long
HEADERS = {
    "Cache-Control": "no-cache",
    "Content-Security-Policy": "default-src 'self'; frame-ancestors 'none'; base-uri 'none'",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}


def fault_texts() -> dict[str, str]:
    """What each fault means, from the CAN contract."""
    return {name: signal.comment or "" for name, signal in Contract().fault_signals("MCU_FaultsActive").items()}


class Hub:
    """Everything that the pages of a lane are shown, and the pages.

    What a page costs is limited whatever it sends and however slowly it reads: of telemetry one frame is under way, of
    other messages so many; what has no room is left out and counted. `most_pages` and `pause_s` limit pages without the
    token: their number, and how soon the next message of one is read.
    """

    def __init__(
        self,
        domain: int,
        access: Access,
        desk: CommandDesk,
        captures: Captures | None = None,
        numbers: Iterator[int] | None = None,
        say: Callable[[str], None] = lambda _: None,
        show_others: Callable[[dict[str, Any]], None] = lambda _: None,
        most_pages: int | None = None,
        pause_s: float = 0.0,
        faults: FaultDesk | None = None,
    ) -> None:
        """captures, numbers: those of all lanes; say: is told a page that is disconnected, in one sentence;
        show_others: is told the standing of the desk whenever the pages are; faults: for the page that commands.
        """
        self.access, self.desk, self.say, self._show_others = access, desk, say, show_others
        self.pause_s, self._faults = pause_s, faults
        self.loop = ioloop.IOLoop.current()
        self.pages: set[PageSocket] = set()
        self.status: dict[str, Any] = {"type": "status", "problems": [], "drives": []}
        self.backlogs: dict[int, Backlog] = {}
        self.captures = captures or Captures()
        self._numbers = numbers or itertools.count(1)
        self._most_pages = most_pages
        self.scopes = ScopeFeed(domain, self.show_scope)
        self._hello = {
            "type": "hello",
            "domain": domain,
            "columns": columns(),
            "panels": layout.described(),
            "states": enumerators("DriveStateKind"),
            "faults": fault_texts(),
            "rejections": rejections(),
            "scope": {
                "columns": scope_feed.columns(),
                "panels": layout.described(layout.WAVEFORM),
                "triggers": FORMS,
                "modes": MODES,
                "signals": {name: unit for name, (unit, _) in quantities.known().items()},
            },
        }

    def deliver(self, drive_id: int, frame: bytes) -> None:
        """A frame of telemetry, from any thread."""
        self.loop.add_callback(self._deliver, drive_id, frame)

    def report(self, status: dict[str, Any]) -> None:
        """The state of affairs, from any thread."""
        self.loop.add_callback(self._report, status)

    def report_vehicle(self, report: dict[str, Any] | None) -> None:
        """A report of the process that commands, from any thread."""
        self.loop.add_callback(self._report_vehicle, report)

    def _deliver(self, drive_id: int, frame: bytes) -> None:
        if drive_id not in self.backlogs:
            self.backlogs[drive_id] = Backlog(BACKLOG_S * FRAMES_HZ)
        self.backlogs[drive_id].append(frame)
        for page in self.pages:
            if page.watched == drive_id:
                page.news.set()

    def _report(self, status: dict[str, Any]) -> None:
        self.status = status
        text = json.dumps(status)
        for page in tuple(self.pages):
            page.offer(text)

    def show_scope(self, page: Any, message: dict[str, Any], capture: Capture | None) -> None:
        """What the scope of a page has to show, from any thread."""
        self.loop.add_callback(self._show_scope, page, message, capture)

    def _show_scope(self, page: "PageSocket", message: dict[str, Any], capture: Capture | None) -> None:
        if page not in self.pages:
            return
        if capture is None:
            page.offer(json.dumps({**message, "unshown": page.unshown} if message["type"] == "scope" else message))
        elif not page.has_room_for_capture():
            page.unshown += 1
        else:
            self._show_capture(page, message, capture)

    def _show_capture(self, page: "PageSocket", message: dict[str, Any], capture: Capture) -> None:
        number = self.captures.add(message["drive"], capture)
        page.send_capture(json.dumps({**message, "number": number}), scope_feed.frame_of(number, capture))

    def _report_vehicle(self, report: dict[str, Any] | None) -> None:
        self.desk.take_report(report)
        self.report_command()

    def report_command(self) -> None:
        for page in tuple(self.pages):
            page.offer(json.dumps(self.desk.described(page)))
        self._show_others(self.desk.described(None))

    def show_command(self, standing: dict[str, Any]) -> None:
        """What onlookers are shown of the desk of another lane, from any thread."""
        self.loop.add_callback(self._show_command, standing)

    def _show_command(self, standing: dict[str, Any]) -> None:
        self.desk.standing = standing
        self.report_command()

    def ask_plant(self, page: "PageSocket", message: dict[str, Any]) -> None:
        """The reply follows; meanwhile the page renews its demand."""
        self.desk.check_holder(page)
        if self._faults is None:
            raise RefusedError("this dashboard gives no faults; it was started without --fault-socket.")
        asked = asyncio.ensure_future(self.loop.run_in_executor(None, self._faults.question(message)))
        asked.add_done_callback(lambda done: page.offer(json.dumps(done.result())))

    def is_full(self) -> bool:
        return self._most_pages is not None and len(self.pages) >= self._most_pages

    def greet(self, page: "PageSocket") -> None:
        page.name = f"page {next(self._numbers)} ({page.request.remote_ip})"
        self.pages.add(page)
        for message in ({**self._hello, "name": page.name}, self.status, self.desk.described(page)):
            page.offer(json.dumps(message))

    def leave(self, page: "PageSocket") -> None:
        self.pages.discard(page)
        self.scopes.turn_off(page)
        self.desk.leave(page)
        self.report_command()


def require_own_host(handler: web.RequestHandler, access: Access) -> None:
    """Refuses a request whose Host header has a name that is not one of this machine."""
    if not access.is_own_host(handler.request.host):
        raise web.HTTPError(403, reason="This name is not one of this dashboard")


class PageSocket(websocket.WebSocketHandler):
    def initialize(self, hub: Hub) -> None:
        self._hub = hub
        self.name = ""
        self.watched: int | None = None
        self.unshown = 0  # captures that the page was too slow for, since its scope was armed
        self.dropped = 0  # messages that were not sent because the page had not taken those before
        self.news = asyncio.Event()  # there may be a frame to send
        self._under_way: list[tuple[float, Any]] = []  # messages, and since when
        self._capture: Any = None  # the newest one sent
        self._telemetry: asyncio.Task | None = None

    def prepare(self) -> None:
        require_own_host(self, self._hub.access)
        if self._hub.is_full():
            raise web.HTTPError(503, reason="Too many pages without the token")

    def check_origin(self, origin: str) -> bool:
        return self._hub.access.is_own_origin(origin, self.request.host)

    def open(self, *_: str) -> None:
        if self._hub.is_full():  # several have come at once
            self.close(1013, "too many pages")
            return
        self.set_nodelay(True)
        self._hub.greet(self)
        self._telemetry = asyncio.get_running_loop().create_task(self._send_telemetry())

    def on_close(self) -> None:
        if self._telemetry:
            self._telemetry.cancel()
        self._hub.leave(self)

    async def on_message(self, text: str | bytes) -> None:
        """The next message is read when this one has been handled."""
        try:
            self._act(parsed(text))
        except RefusedError as refusal:
            self.offer(json.dumps({"type": "refused", "text": str(refusal)}))
        except UserError as error:
            self.offer(json.dumps({"type": "scope_refused", "text": str(error)}))
        if self._hub.pause_s:
            await asyncio.sleep(self._hub.pause_s)

    def _act(self, message: dict[str, Any]) -> None:
        desk, kind = self._hub.desk, message.get("type")
        if kind == "demand":
            desk.demand(self, message)
            return
        if kind == "spoil":
            desk.spoil(self, message)
            return
        if kind == "watch":
            drive_id = message.get("drive")
            if isinstance(drive_id, bool) or not isinstance(drive_id, int):
                raise RefusedError("drive must be a number.")
            self.watched = drive_id
            self.news.set()
            return
        if kind == "scope":
            self._set_scope(message)
            return
        if kind in ("fault_keys", "fault"):
            self._hub.ask_plant(self, message)
            return
        if kind == "take":
            desk.take(self, message.get("token"))
        elif kind == "release":
            desk.release(self)
        else:
            raise RefusedError(f'"{kind}" is no type of a message.')
        self._hub.report_command()

    def _set_scope(self, message: dict[str, Any]) -> None:
        if not message.get("on"):
            self._hub.scopes.turn_off(self)
            return
        if self.watched is None:
            raise UserError("there is no drive yet whose waveform could be captured.")
        settings = scope_feed.settings_of(message)
        self.unshown = 0
        self._hub.scopes.arm(self, self.watched, settings)

    async def _send_telemetry(self) -> None:
        """Of the drive that is watched: what there is, then each new frame. One is under way at a time."""
        drive_id, reader = None, None
        while True:
            if self.watched != drive_id:
                drive_id, reader = self.watched, None
            if reader is None and drive_id in self._hub.backlogs:
                reader = Reader(self._hub.backlogs[drive_id], MOST_BEHIND)
            frame = reader.next() if reader else None
            if frame is None:
                self.news.clear()
                await self.news.wait()
            elif not await self._is_taken(frame):
                return
            else:
                self.dropped += reader.dropped
                reader.dropped = 0

    async def _is_taken(self, frame: bytes) -> bool:
        if (sent := self._send(frame)) is None:
            return False
        try:
            await asyncio.shield(sent)
        except websocket.WebSocketClosedError:
            return False
        return True

    def _send(self, message: str | bytes) -> Any:
        """What is done once the page's connection has taken it; None where it takes nothing more."""
        try:
            sent = asyncio.ensure_future(self.write_message(message, binary=isinstance(message, bytes)))
        except websocket.WebSocketClosedError:
            return None
        sent.add_done_callback(lambda done: done.cancelled() or done.exception())  # a closed connection is no error
        self._under_way.append((time.monotonic(), sent))
        return sent

    def is_behind(self) -> bool:
        """Whether many messages are still under way. One that is for too long ends the connection."""
        self._under_way = [(since_s, sent) for since_s, sent in self._under_way if not sent.done()]
        if self._under_way and time.monotonic() - self._under_way[0][0] > SLOW_S:
            self._disconnect()
        return len(self._under_way) >= MOST_UNDER_WAY

    def _disconnect(self) -> None:
        if self not in self._hub.pages:
            return
        dropped = f"{self.dropped} messages were not sent to it"
        self._hub.say(f"{self.name} has taken nothing for {SLOW_S:g} s and is disconnected; {dropped}.")
        self.close(1008, "too slow")  # by Tornado at the latest 5 s later, because nothing more is read
        self.on_close()

    def offer(self, message: str | bytes) -> None:
        """Sends it unless the page is behind."""
        if self.is_behind():
            self.dropped += 1
        else:
            self._send(message)

    def has_room_for_capture(self) -> bool:
        """Whether the capture before has left, and the page is not behind."""
        return not self.is_behind() and (self._capture is None or self._capture.done())

    def send_capture(self, description: str, frame: bytes) -> None:
        self._send(description)
        self._capture = self._send(frame)


def whole_number(text: str) -> int | float:
    """An integer; a long one as a float, which is infinity beyond the range of a float."""
    return int(text) if len(text) <= LONGEST_INTEGER else float(text)


def parsed(text: str | bytes) -> dict[str, Any]:
    try:
        message = json.loads(text, parse_int=whole_number)
    except (ValueError, RecursionError):
        message = None
    if not isinstance(message, dict):
        raise RefusedError("a message must be one JSON object.")
    return message


class PageFile(web.StaticFileHandler):
    def initialize(self, path: str, access: Access) -> None:
        super().initialize(path, default_filename="index.html")
        self._access = access

    def prepare(self) -> None:
        require_own_host(self, self._access)

    def set_extra_headers(self, _path: str) -> None:
        for name, value in HEADERS.items():
            self.set_header(name, value)


class CaptureFile(web.RequestHandler):
    def initialize(self, hub: Hub) -> None:
        self._hub = hub

    def prepare(self) -> None:
        require_own_host(self, self._hub.access)

    async def get(self, number: str) -> None:
        content = await self._hub.loop.run_in_executor(None, self._hub.captures.recording, whole_number(number))
        if content is None:
            raise web.HTTPError(404, reason=f"Only the newest {KEPT} captures are kept")
        self.set_header("Content-Type", "application/x-hdf5")
        self.set_header("Content-Disposition", f'attachment; filename="capture_{int(number):03}.h5"')
        self.finish(content)


def application(hub: Hub) -> web.Application:
    routes = [
        (r"/socket", PageSocket, {"hub": hub}),
        (r"/captures/(\d+)\.h5", CaptureFile, {"hub": hub}),
        (r"/(.*)", PageFile, {"path": str(PAGE), "access": hub.access}),
    ]
    options = {"websocket_max_message_size": LARGEST_MESSAGE, "websocket_ping_interval": PING_S}
    return web.Application(routes, **options, log_function=lambda _: None)
