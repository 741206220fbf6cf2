"""The CAN contract: messages, signals and data IDs as configs/interfaces/sextant.dbc has them.

A drive's `can.identifier_offset` lies between its identifiers and data IDs and those of the file.
"""

import math
from pathlib import Path

import can
import cantools

from . import e2e
from .errors import UserError
from .paths import DBC

OFFSET_STEP = 32
LARGEST_OFFSET = 1728


NOT_AVAILABLE = "NOT_AVAILABLE"  # in a value table of the DBC


def number_of(signal: cantools.database.can.Signal, raw: float) -> float:
    """The physical value of a raw one."""
    if str((signal.choices or {}).get(raw)) == NOT_AVAILABLE:
        return math.nan
    return float(signal.conversion.raw_to_scaled(raw, decode_choices=False))


class Contract:
    """Encodes and decodes the frames of the DBC, end-to-end protection included."""

    PROTECTION_SIGNALS = ("Crc", "Counter", "DataIdNibble")

    def __init__(self, path: Path = DBC, identifier_offset: int = 0) -> None:
        if not 0 <= identifier_offset <= LARGEST_OFFSET or identifier_offset % OFFSET_STEP:
            raise UserError(
                f"the identifier offset {identifier_offset} is not a multiple of {OFFSET_STEP}"
                f" from 0 to {LARGEST_OFFSET}; sextant-ecu has it as can.identifier_offset."
            )
        self.identifier_offset = identifier_offset
        try:
            self.database = cantools.database.load_file(path)
        except FileNotFoundError:
            raise UserError(f"the CAN contract {path} does not exist.") from None
        except cantools.database.UnsupportedDatabaseFormatError as error:
            raise UserError(f"the CAN contract {path} cannot be read: {error}.") from None

    def message(self, name: str) -> cantools.database.can.Message:
        try:
            return self.database.get_message_by_name(name)
        except KeyError:
            raise UserError(f"the CAN contract has no message {name}.") from None

    def faults(self) -> dict[str, int]:
        """The faults by name, each with its bit in the masks of CAN and DDS: the value table of FirstFault."""
        choices = self.message("MCU_Faults").get_signal_by_name("FirstFault").choices
        return {str(name): value for value, name in choices.items() if str(name) != "NONE"}

    def fault_signals(self, message: str) -> dict[str, cantools.database.can.Signal]:
        """The signal of each fault by the fault's name, in MCU_FaultsActive or MCU_FaultsLatched."""
        signals = [signal for signal in self.message(message).signals if signal.length == 1]
        first = min(signal.start for signal in signals)  # the bit of fault 0
        by_bit = {signal.start - first: signal for signal in signals}
        return {name: by_bit[bit] for name, bit in self.faults().items() if bit in by_bit}

    def version(self) -> tuple[int, int]:
        """Major and minor number, as the drive sends them in MCU_Identification."""
        major, minor = self.database.version.split(".")
        return int(major), int(minor)

    def messages_of_the_drive(self) -> dict[str, cantools.database.can.Message]:
        return {message.name: message for message in self.database.messages if "MCU" in message.senders}

    def limits(self, message: str, signal: str) -> tuple[float, float]:
        """Smallest and largest physical value of a signal, in its unit."""
        found = self.message(message).get_signal_by_name(signal)
        return float(found.minimum), float(found.maximum)

    def data_id(self, message: str) -> int | None:
        """The data ID of a protected message; None where the DBC names no profile."""
        attributes = self.message(message).dbc.attributes
        profile = attributes.get("E2EProfile")
        if profile is None or not profile.value:
            return None
        if profile.value != "P11_NIBBLE":
            raise UserError(f"{message} is protected by {profile.value}; only P11_NIBBLE is known here.")
        return int(attributes["E2EDataId"].value) + self.identifier_offset

    def encode(self, name: str, signals: dict[str, float], counter: int = 0) -> can.Message:
        """A frame ready to send. A value outside its range is refused (cantools.database.EncodeError)."""
        message = self.message(name)
        data_id = self.data_id(name)
        if data_id is None:
            data = bytearray(message.encode(signals, strict=True))
        else:
            empty = dict.fromkeys(self.PROTECTION_SIGNALS, 0)
            data = bytearray(message.encode({**empty, **signals}, strict=True))
            e2e.protect(data, data_id, counter)
        return can.Message(arbitration_id=message.frame_id + self.identifier_offset, data=data, is_extended_id=False)

    def decode(self, frame: can.Message) -> tuple[str, dict] | None:
        """Name and signals of a classic data frame of the contract, of the right length; None otherwise."""
        message = self._message_of(frame)
        return (message.name, message.decode(frame.data)) if message else None

    def decode_numbers(self, frame: can.Message) -> tuple[str, list[float]] | None:
        """As decode; physical values in the order of the message's signals, and numbers where the DBC has names; not a
        number for what is not available."""
        message = self._message_of(frame)
        if message is None:
            return None
        raw = message.decode(frame.data, decode_choices=False, scaling=False)
        return message.name, [number_of(signal, raw[signal.name]) for signal in message.signals]

    def _message_of(self, frame: can.Message) -> cantools.database.can.Message | None:
        if frame.is_extended_id or frame.is_remote_frame or frame.is_error_frame or frame.is_fd:
            return None
        try:
            message = self.database.get_message_by_frame_id(frame.arbitration_id - self.identifier_offset)
        except KeyError:
            return None
        return message if len(frame.data) == message.length else None
