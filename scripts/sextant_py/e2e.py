"""AUTOSAR E2E profile 11 in data-ID mode NIBBLE, by the package autosar-e2e.

Byte 0 holds the CRC, the low nibble of byte 1 the counter, its high nibble the low nibble of the data ID's high byte.
"""

from e2e import p11

COUNTER_COUNT = 15
"""The counter runs from 0 to 14; 15 is invalid."""


def crc(frame: bytes, data_id: int) -> int:
    """The CRC that byte 0 of the frame should hold."""
    signed = bytearray(frame)
    p11.e2e_p11_protect(signed, data_id, data_id_mode=p11.E2E_P11_DATAID_NIBBLE, increment_counter=False)
    return signed[0]


def protect(frame: bytearray, data_id: int, counter: int) -> None:
    """Writes counter, data-ID nibble and CRC into the frame."""
    if not 0 <= counter < COUNTER_COUNT:
        raise ValueError(f"counter {counter} is not within 0 and {COUNTER_COUNT - 1}")
    frame[1] = ((data_id >> 8) & 0x0F) << 4 | counter
    frame[0] = crc(frame, data_id)


def is_valid(frame: bytes, data_id: int) -> bool:
    """Whether CRC and data-ID nibble are those of the frame, and its counter is one."""
    counter, nibble = frame[1] & 0x0F, frame[1] >> 4
    return counter < COUNTER_COUNT and nibble == (data_id >> 8) & 0x0F and frame[0] == crc(frame, data_id)
