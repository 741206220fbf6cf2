"""CAN buses that nobody else uses."""

import socket


def free_udp_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("", 0))
        return probe.getsockname()[1]


def multicast_address(port: int) -> str:
    return f"udp_multicast:239.74.163.2:{port}"


def reason_against(address: str) -> str | None:
    """Why the bus cannot be opened on this machine."""
    # Here, not above: what opens a bus is slow to import, and most tests need none.
    from sextant_py import bus
    from sextant_py.errors import UserError

    try:
        bus.open_bus(bus.parse(address)).shutdown()
    except UserError as error:
        return str(error)
    return None
