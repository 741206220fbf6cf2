"""The web server: the page's files, one WebSocket a page, and what they are sent."""

import json
import tempfile
from collections import deque
from pathlib import Path
from typing import Any

from tornado import ioloop, web, websocket

from ..contract import Contract
from ..errors import UserError
from ..scope import files, quantities
from ..scope.capture import Capture
from ..scope.scope import MODES
from ..scope.trigger_text import FORMS
from ..telemetry_contract import enumerators
from . import layout, scope_feed
from .access import Access
from .command_desk import CommandDesk, RefusedError
from .frames import columns
from .scope_feed import ScopeFeed
from .source import FRAMES_HZ

PAGE = Path(__file__).with_name("page")
LARGEST_MESSAGE = 65536  # bytes, of a page
LONGEST_INTEGER = 18  # characters, of a message
BACKLOG_S = 30  # of telemetry that a page is sent at first
MOST_UNDER_WAY = FRAMES_HZ  # messages that a page has not taken yet
PING_S = 10  # a page without a reply for so long is disconnected
KEPT_CAPTURES = 16
HEADERS = {
    "Cache-Control": "no-cache",
    "Content-Security-Policy": "default-src 'self'; frame-ancestors 'none'; base-uri 'none'",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}


def fault_texts() -> dict[str, str]:
    """What each fault means, from the CAN contract."""
    contract = Contract()
    signals = [signal for signal in contract.message("MCU_FaultsActive").signals if signal.length == 1]
    first = min(signal.start for signal in signals)  # the bit of fault 0
    by_bit = {signal.start - first: signal.comment or "" for signal in signals}
    return {name: by_bit.get(bit, "") for name, bit in contract.faults().items()}


class Hub:
    """Everything that the pages are shown, and the pages."""

    def __init__(self, domain: int, access: Access, desk: CommandDesk) -> None:
        self.access, self.desk = access, desk
        self.loop = ioloop.IOLoop.current()
        self.pages: set[PageSocket] = set()
        self.status: dict[str, Any] = {"type": "status", "problems": [], "drives": []}
        self._backlog: dict[int, deque[bytes]] = {}
        self._numbers = 0
        self._captures: dict[int, tuple[int, Capture]] = {}  # the newest, by number, with their drive
        self._capture_numbers = 0
        self.scopes = ScopeFeed(domain, self.show_scope)
        self._hello = {
            "type": "hello",
            "domain": domain,
            "columns": columns(),
            "panels": layout.described(),
            "states": enumerators("DriveStateKind"),
            "faults": fault_texts(),
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
        self._backlog.setdefault(drive_id, deque(maxlen=BACKLOG_S * FRAMES_HZ)).append(frame)
        for page in self.pages:
            if page.watched == drive_id:
                page.offer(frame)

    def _report(self, status: dict[str, Any]) -> None:
        self.status = status
        text = json.dumps(status)
        for page in self.pages:
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
        self._capture_numbers += 1
        number = self._capture_numbers
        self._captures[number] = (message["drive"], capture)
        self._captures.pop(number - KEPT_CAPTURES, None)
        page.send_capture(json.dumps({**message, "number": number}), scope_feed.frame_of(number, capture))

    def capture(self, number: int) -> tuple[int, Capture] | None:
        return self._captures.get(number)

    def _report_vehicle(self, report: dict[str, Any] | None) -> None:
        self.desk.take_report(report)
        self.report_command()

    def report_command(self) -> None:
        for page in self.pages:
            page.send(json.dumps(self.desk.described(page)))

    def greet(self, page: "PageSocket") -> None:
        self._numbers += 1
        page.name = f"page {self._numbers} ({page.request.remote_ip})"
        self.pages.add(page)
        for message in ({**self._hello, "name": page.name}, self.status, self.desk.described(page)):
            page.send(json.dumps(message))

    def watch(self, page: "PageSocket", drive_id: int) -> None:
        """From now on the page gets this drive's telemetry, beginning with what there is of it."""
        page.watched = drive_id
        for frame in self._backlog.get(drive_id, ()):
            page.send(frame)

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
    """The connection of one page."""

    def initialize(self, hub: Hub) -> None:
        self._hub = hub
        self.name = ""
        self.watched: int | None = None
        self.unshown = 0  # captures that the page was too slow for, since its scope was armed
        self._under_way: list[Any] = []
        self._capture: Any = None  # the newest one sent

    def prepare(self) -> None:
        require_own_host(self, self._hub.access)

    def check_origin(self, origin: str) -> bool:
        return self._hub.access.is_own_origin(origin, self.request.host)

    def open(self, *_: str) -> None:
        self.set_nodelay(True)
        self._hub.greet(self)

    def on_close(self) -> None:
        self._hub.leave(self)

    def on_message(self, text: str | bytes) -> None:
        try:
            self._act(parsed(text))
        except RefusedError as refusal:
            self.send(json.dumps({"type": "refused", "text": str(refusal)}))
        except UserError as error:
            self.send(json.dumps({"type": "scope_refused", "text": str(error)}))

    def _act(self, message: dict[str, Any]) -> None:
        desk, kind = self._hub.desk, message.get("type")
        if kind == "demand":
            desk.demand(self, message)
            return
        if kind == "watch":
            drive_id = message.get("drive")
            if isinstance(drive_id, bool) or not isinstance(drive_id, int):
                raise RefusedError("drive must be a number.")
            self._hub.watch(self, drive_id)
            return
        if kind == "scope":
            self._set_scope(message)
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

    def send(self, message: str | bytes) -> Any:
        try:
            return self.write_message(message, binary=isinstance(message, bytes))
        except websocket.WebSocketClosedError:
            return None

    def is_behind(self) -> bool:
        """Whether many messages are still under way."""
        self._under_way = [sent for sent in self._under_way if not sent.done()]
        return len(self._under_way) >= MOST_UNDER_WAY

    def offer(self, message: str | bytes) -> None:
        """Sends it unless the page is behind: a slow page misses samples, which it counts itself, and reports."""
        if not self.is_behind() and (sent := self.send(message)) is not None:
            self._under_way.append(sent)

    def has_room_for_capture(self) -> bool:
        """Whether the capture before has left, and the page is not behind."""
        return not self.is_behind() and (self._capture is None or self._capture.done())

    def send_capture(self, description: str, frame: bytes) -> None:
        self.send(description)
        self._capture = self.send(frame)


def whole_number(text: str) -> int | float:
    """An integer; a long one as a float, which is infinity beyond the range of a float."""
    return int(text) if len(text) <= LONGEST_INTEGER else float(text)


def parsed(text: str | bytes) -> dict[str, Any]:
    """A page's message."""
    try:
        message = json.loads(text, parse_int=whole_number)
    except (ValueError, RecursionError):
        message = None
    if not isinstance(message, dict):
        raise RefusedError("a message must be one JSON object.")
    return message


class PageFile(web.StaticFileHandler):
    """A file of the page."""

    def initialize(self, path: str, access: Access) -> None:
        super().initialize(path, default_filename="index.html")
        self._access = access

    def prepare(self) -> None:
        require_own_host(self, self._access)

    def set_extra_headers(self, _path: str) -> None:
        for name, value in HEADERS.items():
            self.set_header(name, value)


class CaptureFile(web.RequestHandler):
    """A capture as a recording."""

    def initialize(self, hub: Hub) -> None:
        self._hub = hub

    def prepare(self) -> None:
        require_own_host(self, self._hub.access)

    async def get(self, number: str) -> None:
        found = self._hub.capture(int(number))
        if found is None:
            raise web.HTTPError(404, reason=f"Only the newest {KEPT_CAPTURES} captures are kept")
        content = await self._hub.loop.run_in_executor(None, recording_of, *found)
        self.set_header("Content-Type", "application/x-hdf5")
        self.set_header("Content-Disposition", f'attachment; filename="capture_{int(number):03}.h5"')
        self.finish(content)


def recording_of(drive_id: int, capture: Capture) -> bytes:
    """The bytes of the file."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "capture.h5")
        files.write(path, capture, drive_id)
        return path.read_bytes()


def application(hub: Hub) -> web.Application:
    routes = [
        (r"/socket", PageSocket, {"hub": hub}),
        (r"/captures/(\d+)\.h5", CaptureFile, {"hub": hub}),
        (r"/(.*)", PageFile, {"path": str(PAGE), "access": hub.access}),
    ]
    options = {"websocket_max_message_size": LARGEST_MESSAGE, "websocket_ping_interval": PING_S}
    return web.Application(routes, **options, log_function=lambda _: None)
