"""scripts/dashboard: its arguments, and what it prints."""

import argparse
import asyncio
import errno
import ipaddress
import itertools
import secrets
import signal
import socket
import sys
import webbrowser
from pathlib import Path
from typing import Any

from tornado import netutil

from .. import bus as can_bus
from .. import dds, vendor
from ..commander import COMMAND
from ..contract import Contract
from ..errors import UserError
from ..program_arguments import parser_of
from .access import Access
from .captures import Captures
from .command_desk import CommandDesk
from .door import Door
from .fault_desk import FaultDesk
from .lane import Lane
from .onlookers import Onlookers
from .server import PAGE, Hub
from .source import Source
from .vehicle import DEMAND_TIMEOUT_S, Vehicle

DEFAULT_PORT = 8150
MOST_PAGES = 16  # without the token
MOST_CONNECTIONS = 64  # for files and captures of all pages, and for requests of a WebSocket without the token
PAUSE_S = 0.05  # between two messages of a page without the token
SWITCH_S = 0.001  # after which a thread that runs Python yields to one of another lane
DESCRIPTION = "Serves a page with the live telemetry of the drives of a DDS domain, until Ctrl-C."
EXAMPLES = """examples:
  scripts/dashboard --open                        # domain 0, http://127.0.0.1:8150/
  scripts/dashboard --domain 7 --port 0           # any free port
  scripts/dashboard --allow-command               # the page may command torque over the bus of configs/ecu.toml
  scripts/dashboard --allow-command --can socketcan:can0 --torque-limit 20
  scripts/dashboard --allow-command --fault-socket /tmp/faults    # and give the plant of sextant-ecu faults
  scripts/dashboard --host 0.0.0.0                # for other machines of the network too
"""


def parse_arguments(arguments: list[str]) -> argparse.Namespace:
    parser = parser_of("dashboard", DESCRIPTION, EXAMPLES)
    parser.add_argument("--domain", type=int, default=0, metavar="N", help="DDS domain (default: 0)")
    parser.add_argument(
        "--host", default="127.0.0.1", help="address to listen at (default: 127.0.0.1, this machine alone)"
    )
    port = f"port to listen at (default: {DEFAULT_PORT}; 0: any free one)"
    parser.add_argument("--port", type=int, default=DEFAULT_PORT, metavar="N", help=port)
    parser.add_argument("--open", action="store_true", help="open the page in the browser")
    command = parser.add_argument_group("commands to a drive over CAN")
    command.add_argument("--allow-command", action="store_true", help="pages with the token may command torque")
    command.add_argument("--can", metavar="BUS", help="default: the bus that configs/ecu.toml names")
    offset = "the drive's can.identifier_offset; default: that of configs/ecu.toml"
    command.add_argument("--identifier-offset", type=int, metavar="N", help=offset)
    limit = "largest torque that a page may request, within what the drive reports (default: that of the contract)"
    command.add_argument("--torque-limit", type=float, metavar="NM", help=limit)
    timeout = f"no commands without a page's demand for this long (default: {DEMAND_TIMEOUT_S:g})"
    command.add_argument("--demand-timeout", type=float, metavar="S", help=timeout)
    command.add_argument("--token", metavar="TEXT", help="what a page has to present (default: a random one, printed)")
    faults = "--fault-socket of the sextant-ecu or sextant-plant whose plant the page that commands may give faults"
    command.add_argument("--fault-socket", type=Path, metavar="FILE", help=faults)
    return parser.parse_args(arguments)


def check(options: argparse.Namespace) -> None:
    if not 0 <= options.port <= 65535:
        raise UserError(f"--port {options.port} is not a port (0 to 65535).")
    dds.check_domain(options.domain)
    names = ("can", "identifier_offset", "torque_limit", "demand_timeout", "token", "fault_socket")
    given = [name for name in names if getattr(options, name) is not None]
    if given and not options.allow_command:
        raise UserError(f"--{given[0].replace('_', '-')} has a meaning only with --allow-command.")
    if options.token is not None and len(options.token) < 8:
        raise UserError("--token must have at least 8 characters; without --token a random one is made.")


def vehicle_of(options: argparse.Namespace) -> Vehicle | None:
    if not options.allow_command:
        return None
    offset = can_bus.default_identifier_offset() if options.identifier_offset is None else options.identifier_offset
    largest_nm = Contract(identifier_offset=offset).limits(COMMAND, "TorqueLimit")[1]
    limit_nm = largest_nm if options.torque_limit is None else options.torque_limit
    timeout_s = DEMAND_TIMEOUT_S if options.demand_timeout is None else options.demand_timeout
    return Vehicle(options.can or can_bus.default_address(), offset, limit_nm, timeout_s)


def listen(host: str, port: int) -> list[socket.socket]:
    try:
        return netutil.bind_sockets(port, host)
    except socket.gaierror:
        raise UserError(f"--host {host} is no address of this machine and no name of one.") from None
    except OSError as error:
        if port and error.errno == errno.EADDRINUSE:
            raise UserError(
                f"port {port} of {host} is taken; --port names another, and --port 0 takes any free one."
            ) from None
        raise UserError(f"{host}:{port} cannot be listened at: {error.strerror}.") from None


def address_of(host: str, sockets: list[socket.socket], token: str | None) -> str:
    """The page's address. The token follows the #, which a browser keeps to itself."""
    port = sockets[0].getsockname()[1]
    try:
        address = ipaddress.ip_address(host)
        name = "127.0.0.1" if address.is_unspecified else f"[{host}]" if address.version == 6 else host
    except ValueError:
        name = host
    return f"http://{name}:{port}/" + (f"#token={token}" if token else "")


class Terminal:
    """Prints what changes: problems, and drives whose telemetry comes, times out and returns."""

    def __init__(self) -> None:
        self._problems: list[str] = []
        self._timed_out: dict[int, bool] = {}

    def show(self, status: dict) -> None:
        for problem in status["problems"]:
            if problem not in self._problems:
                print(f"dashboard: {problem}", flush=True)
        self._problems = status["problems"]
        for drive in status["drives"]:
            timed_out = drive["timed_out"]
            if self._timed_out.get(drive["drive_id"]) != bool(timed_out) and drive["received"]:
                text = f"no telemetry; {timed_out['reason']}" if timed_out else "telemetry arrives"
                print(f"dashboard: drive {drive['drive_id']}: {text}.", flush=True)
            self._timed_out[drive["drive_id"]] = bool(timed_out)


class Lanes:
    """The WebSockets of pages with the token, which may command, and the public lane, for everything else.

    A page that commands waits for nothing of the public lane. The files of every page and its captures are in the
    public lane: loading them waits for other pages, and is refused while these have taken all of its connections.
    """

    def __init__(self, domain: int, access: Access, vehicle: Vehicle | None, faults: FaultDesk | None) -> None:
        captures, numbers, self._hub = Captures(), itertools.count(1), (domain, access)
        self._common: dict[str, Any] = {"captures": captures, "numbers": numbers, "say": self._say}
        self._desk, self._faults = CommandDesk(access, vehicle, faults is not None), faults
        self.public = Lane("public", self._public_hub, MOST_CONNECTIONS)
        self.trusted = Lane("trusted", self._trusted_hub) if vehicle else None

    @staticmethod
    def _say(sentence: str) -> None:
        print(f"dashboard: {sentence}", flush=True)

    def _public_hub(self) -> Hub:
        onlookers = Onlookers(self._desk.described(None))
        return Hub(*self._hub, onlookers, **self._common, most_pages=MOST_PAGES, pause_s=PAUSE_S)

    def _trusted_hub(self) -> Hub:
        show = self.public.hub.show_command
        return Hub(*self._hub, self._desk, **self._common, show_others=show, faults=self._faults)

    @property
    def hubs(self) -> list[Hub]:
        return [lane.hub for lane in (self.trusted, self.public) if lane]

    def start(self) -> None:
        sys.setswitchinterval(SWITCH_S)
        for lane in filter(None, (self.public, self.trusted)):
            lane.start()
            lane.hub.scopes.start()

    def stop(self) -> None:
        for lane in filter(None, (self.trusted, self.public)):
            lane.hub.scopes.stop()
            lane.stop()


async def serve(options: argparse.Namespace, sockets: list[socket.socket], vehicle: Vehicle | None) -> None:
    token = (options.token or secrets.token_urlsafe(16)) if vehicle else None
    access = Access(options.host, token)
    faults = FaultDesk(options.fault_socket) if options.fault_socket else None
    lanes = Lanes(options.domain, access, vehicle, faults)
    terminal = Terminal()

    def report(status: dict) -> None:
        terminal.show(status)
        for hub in lanes.hubs:
            hub.report(status)

    def deliver(drive_id: int, frame: bytes) -> None:
        for hub in lanes.hubs:
            hub.deliver(drive_id, frame)

    lanes.start()
    source = Source(options.domain, deliver, report)
    Door(access, lanes.public, lanes.trusted).open(sockets)
    ended = asyncio.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        asyncio.get_running_loop().add_signal_handler(number, ended.set)
    if vehicle:
        vehicle.start(lanes.trusted.hub.report_vehicle)
    source.start()
    address = address_of(options.host, sockets, token)
    print(f"dashboard: DDS domain {options.domain} at {address}", flush=True)
    if vehicle:
        print(f"dashboard: a page with the token may command the drive on {vehicle.address}.", flush=True)
    if options.open and not webbrowser.open(address):
        print("dashboard: no browser could be opened; open the address by hand.", flush=True)
    try:
        await ended.wait()
    finally:
        if vehicle:
            vehicle.end()
        source.stop()
        lanes.stop()


def main(arguments: list[str]) -> int:
    options = parse_arguments(arguments)
    check(options)
    vendor.need("the dashboard's page", PAGE / "vendor")
    vehicle = vehicle_of(options)
    sockets = listen(options.host, options.port)
    asyncio.run(serve(options, sockets, vehicle))
    return 0
