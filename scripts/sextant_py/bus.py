"""Opening a CAN bus by its address, and saying what is wrong when it cannot be opened."""

import errno
import fcntl
import ipaddress
import os
import socket
import struct
import tomllib
from dataclasses import dataclass

import can

from .errors import UserError
from .paths import ECU

DEFAULT_PORT = 43113
DEFAULT_MULTICAST = f"udp_multicast:239.74.163.2:{DEFAULT_PORT}"
ADDRESS_FORMS = f"socketcan:INTERFACE (socketcan:vcan0) or udp_multicast:GROUP[:PORT] ({DEFAULT_MULTICAST})"

_SIOCGIFFLAGS = 0x8913
_IFF_UP = 0x1
_SO_RCVBUFFORCE = 33


def _configured(table: str = "can") -> dict:
    """A table of configs/ecu.toml: a VCU and an ECU that are told nothing meet."""
    return tomllib.loads(ECU.read_text(encoding="utf-8"))[table]


def default_address() -> str:
    """The bus that configs/ecu.toml names."""
    try:
        return str(_configured()["bus"])
    except (OSError, ValueError, KeyError) as error:
        raise UserError(f"{ECU} names no CAN bus ({error}); --can names one.") from None


def default_identifier_offset() -> int:
    """The offset of identifiers that configs/ecu.toml names."""
    try:
        return int(_configured().get("identifier_offset", 0))
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise UserError(f"{ECU} names no offset ({error}); --identifier-offset names one.") from None


@dataclass(frozen=True)
class Address:
    """A bus: interface "socketcan" and the channel's name, or "udp_multicast", group and port."""

    interface: str
    channel: str
    port: int = 0

    def __str__(self) -> str:
        tail = f":{self.port}" if self.interface == "udp_multicast" else ""
        return f"{self.interface}:{self.channel}{tail}"


def parse(text: str) -> Address:
    """Reads "socketcan:vcan0" or "udp_multicast:239.74.163.2:43113"."""
    interface, _, rest = text.partition(":")
    if interface == "socketcan" and 0 < len(rest) < 16 and ":" not in rest and "/" not in rest:
        return Address(interface, rest)
    if interface == "udp_multicast" and rest:
        group, _, port = rest.partition(":")
        return Address(interface, _multicast_group(group, text), _port(port or str(DEFAULT_PORT), text))
    raise UserError(f'"{text}" is not the address of a CAN bus; expected {ADDRESS_FORMS}.')


def _multicast_group(group: str, text: str) -> str:
    try:
        if ipaddress.IPv4Address(group).is_multicast:
            return group
    except ipaddress.AddressValueError:
        pass
    raise UserError(f'"{group}" in "{text}" is not an IPv4 multicast group (224.0.0.0 to 239.255.255.255).')


def _port(port: str, text: str) -> int:
    if port.isascii() and port.isdigit() and 0 < int(port) < 65536:
        return int(port)
    raise UserError(f'"{port}" in "{text}" is not a UDP port (1 to 65535).')


def _check_socketcan(channel: str) -> None:
    try:
        socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW).close()
    except OSError:
        raise UserError(
            f"this kernel has no CAN; use {DEFAULT_MULTICAST}, or run the command through scripts/with_vcan."
        ) from None
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        request = struct.pack("16sh14x", channel.encode(), 0)
        try:
            flags = struct.unpack("16sh14x", fcntl.ioctl(probe, _SIOCGIFFLAGS, request))[1]
        except OSError:
            raise UserError(
                f"there is no CAN interface {channel}; a virtual one is made, as root, by"
                f' "ip link add dev {channel} type vcan && ip link set {channel} up".'
            ) from None
    if not flags & _IFF_UP:
        raise UserError(f'the CAN interface {channel} is down; "ip link set {channel} up" as root brings it up.')


def _check_multicast(group: str, port: int) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect((group, port))
        except OSError as error:
            if error.errno not in (errno.ENETUNREACH, errno.EHOSTUNREACH):
                raise UserError(f"the multicast group {group} cannot be used: {error.strerror}.") from None
            raise UserError(
                f"this machine has no route for the multicast group {group};"
                ' "ip route add 239.0.0.0/8 dev lo" as root makes one within the machine.'
            ) from None


def open_bus(address: Address) -> can.BusABC:
    """The opened bus. Frames of other processes are received, and on udp_multicast one's own as well."""
    try:
        if address.interface == "socketcan":
            _check_socketcan(address.channel)
            return can.Bus(interface="socketcan", channel=address.channel, fd=True, ignore_config=True)
        _check_multicast(address.channel, address.port)
        return can.Bus(interface="udp_multicast", channel=address.channel, port=address.port, ignore_config=True)
    except (can.CanError, OSError) as error:
        raise UserError(f"the CAN bus {address} cannot be opened: {error.__cause__ or error}.") from None


def receive(bus: can.BusABC, timeout: float) -> can.Message | None:
    """The next frame within the timeout [s]. What is no CAN frame on a shared multicast port is passed over."""
    try:
        return bus.recv(timeout)
    except can.CanOperationError as error:
        if "unpack" in str(error):
            return None
        raise


def widen(opened: can.BusABC, size: int) -> None:
    """Asks the kernel for so many bytes for frames that wait; it may grant less to a user who is not root."""
    with socket.socket(fileno=os.dup(opened.fileno())) as receiver:
        try:
            receiver.setsockopt(socket.SOL_SOCKET, _SO_RCVBUFFORCE, size)
        except PermissionError:
            receiver.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, size)
