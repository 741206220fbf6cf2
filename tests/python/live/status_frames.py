"""What the drive sends on the CAN bus."""

import time

from sextant_py import bus
from sextant_py.contract import Contract

ANSWER_S = 60.0  # nothing is judged by time


class StatusFrames:
    """The drive's frames, decoded, in the order in which they come."""

    def __init__(self, address: str) -> None:
        self._contract = Contract()
        self._bus = bus.open_bus(bus.parse(address))

    def __enter__(self) -> "StatusFrames":
        return self

    def __exit__(self, *_: object) -> None:
        self._bus.shutdown()

    def next(self, name: str, seen: set[str] | None = None) -> dict:
        """The signals of the next message of this name; the names of all that came before go to `seen`."""
        deadline_s = time.monotonic() + ANSWER_S
        while time.monotonic() < deadline_s:
            frame = bus.receive(self._bus, 0.5)
            decoded = frame and self._contract.decode(frame)
            if decoded and seen is not None:
                seen.add(decoded[0])
            if decoded and decoded[0] == name:
                return decoded[1]
        raise AssertionError(f"no {name} for {ANSWER_S:g} s")

    def forget(self) -> None:
        """Drops what has piled up unread."""
        while bus.receive(self._bus, 0.0) is not None:
            pass
