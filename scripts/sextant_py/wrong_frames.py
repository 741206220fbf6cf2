"""Commands that a vehicle control unit should not send, one kind for each check of docs/can.md."""

from collections.abc import Callable
from dataclasses import dataclass

import can

from . import e2e
from .contract import Contract
from .errors import UserError

COMMAND = "VCU_TorqueCommand"
JUMP = 8  # counter values: more than the check lets pass as lost

Alter = Callable[[Contract, bytearray, int], bytearray]


@dataclass(frozen=True)
class Wrong:
    """What is wrong with a frame, and how the counter goes on."""

    meaning: str
    skip: int = 0  # values of the counter left out before the frame
    advance: int = 1  # values of the counter from this frame to the next
    is_sent: bool = True
    alter: Alter | None = None

    def frame(self, contract: Contract, right: can.Message, counter: int) -> can.Message | None:
        """What is sent in place of the right frame with this counter; None: nothing."""
        if not self.is_sent:
            return None
        data = bytearray(right.data)
        if self.alter is not None:
            data = self.alter(contract, data, counter)
        return can.Message(arbitration_id=right.arbitration_id, data=data, is_extended_id=False)


def _other_crc(_contract: Contract, data: bytearray, _counter: int) -> bytearray:
    data[0] ^= 0xFF
    return data


def _other_data_id(contract: Contract, data: bytearray, counter: int) -> bytearray:
    e2e.protect(data, contract.data_id("MCU_TorqueStatus"), counter)
    return data


def _reserved_counter(contract: Contract, data: bytearray, _counter: int) -> bytearray:
    data[1] |= 0x0F
    data[0] = e2e.crc(bytes(data), contract.data_id(COMMAND))
    return data


def _beyond_range(contract: Contract, data: bytearray, counter: int) -> bytearray:
    """The largest torque that the signal's bits can hold."""
    message = contract.message(COMMAND)
    torque = message.get_signal_by_name("TorqueRequest")
    largest_nm = (2 ** (torque.length - torque.is_signed) - 1) * torque.scale + torque.offset
    if largest_nm <= torque.maximum:
        raise UserError("TorqueRequest of the CAN contract can hold no torque beyond its range.")
    signals = message.decode(bytes(data), decode_choices=False) | {"TorqueRequest": largest_nm}
    data = bytearray(message.encode(signals, strict=False))
    e2e.protect(data, contract.data_id(COMMAND), counter)
    return data


def _short(_contract: Contract, data: bytearray, _counter: int) -> bytearray:
    return data[:-1]


WRONG = {
    "crc": Wrong("wrong CRC", alter=_other_crc),
    "data_id": Wrong("CRC and nibble of another message's data ID", alter=_other_data_id),
    "repeated": Wrong("the counter of the frame before", skip=-1),
    "jumped": Wrong(f"a counter {JUMP} values too far, from which the next frames go on", skip=JUMP),
    "reserved": Wrong("the invalid counter 15, with a right CRC", alter=_reserved_counter),
    "range": Wrong("a torque request beyond the contract's range", alter=_beyond_range),
    "length": Wrong("a byte too short", alter=_short),
    "lost": Wrong("not sent, and its counter left out", is_sent=False),
    "late": Wrong("sent a period later", is_sent=False, advance=0),
}
