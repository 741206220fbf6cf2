"""End-to-end protection against the published vectors and a general CRC."""

import random

import pytest
from crccheck.crc import Crc8GsmA
from frame_checker import Checker, Result
from sextant_py import e2e
from sextant_py.contract import Contract

MESSAGES = [message.name for message in Contract().database.messages]
UNPROTECTED = {"MCU_RealTime", "MCU_Temperatures"}
PROTECTED = [name for name in MESSAGES if name not in UNPROTECTED]


@pytest.mark.parametrize(("counter", "expected"), [(0, "2a10000000000000"), (1, "7711000000000000")])
def test_published_vectors(counter: int, expected: str) -> None:
    frame = bytearray(8)
    e2e.protect(frame, 0x123, counter)
    assert frame.hex() == expected


def test_agrees_with_another_crc() -> None:
    """The CRC by the profile's text: polynomial 0x1D over the data ID's low byte, zero and all bytes but the first."""
    seed = 20240611
    random_source = random.Random(seed)
    for _ in range(2000):
        data_id, counter = random_source.randrange(0x1000), random_source.randrange(e2e.COUNTER_COUNT)
        frame = bytearray(random_source.randbytes(8))
        payload = bytes(frame[2:])
        e2e.protect(frame, data_id, counter)
        header = data_id >> 8 << 4 | counter
        crc = Crc8GsmA.calc(bytes([data_id & 0xFF, 0, header]) + payload)
        assert frame == bytes([crc, header]) + payload, f"seed {seed}, data ID {data_id:#x}, counter {counter}"


def test_a_wrong_nibble_is_found() -> None:
    frame = bytearray(8)
    e2e.protect(frame, 0x110, 0)
    frame[1] ^= 0xF0
    assert not e2e.is_valid(frame, 0x110)


def test_every_flipped_bit_is_found() -> None:
    frame = bytearray(range(8))
    e2e.protect(frame, 0x110, 7)
    assert e2e.is_valid(frame, 0x110)
    for bit in range(64):
        spoilt = bytearray(frame)
        spoilt[bit // 8] ^= 1 << bit % 8
        assert not e2e.is_valid(spoilt, 0x110), f"bit {bit}"


def test_another_data_id_is_found() -> None:
    frame = bytearray(8)
    e2e.protect(frame, 0x110, 0)
    assert not e2e.is_valid(frame, 0x120)
    assert not e2e.is_valid(frame, 0x210)


def test_counter_sequence() -> None:
    expected = [
        (0, Result.OK),
        (1, Result.OK),
        (1, Result.REPEATED),
        (4, Result.SOME_LOST),
        (8, Result.WRONG_SEQUENCE),
        (9, Result.OK),
        (14, Result.WRONG_SEQUENCE),
        (0, Result.OK),
        (14, Result.WRONG_SEQUENCE),
        (2, Result.SOME_LOST),
    ]
    checker = Checker(0x110)
    for index, (counter, result) in enumerate(expected):
        frame = bytearray(8)
        e2e.protect(frame, 0x110, counter)
        assert checker.check(frame) is result, f"frame {index}"


def test_counter_fifteen_is_refused() -> None:
    with pytest.raises(ValueError, match="15"):
        e2e.protect(bytearray(8), 0x110, 15)


def test_every_frame_is_protected_but_these() -> None:
    assert {name for name in MESSAGES if Contract().data_id(name) is None} == UNPROTECTED


@pytest.mark.parametrize("name", PROTECTED)
@pytest.mark.parametrize("offset", [32, 256, 1728])
def test_a_frame_under_another_drives_identifier_is_found(name: str, offset: int) -> None:
    frames = []
    for contract in (Contract(), Contract(identifier_offset=offset)):
        frames.append(contract.encode(name, {s.name: s.minimum for s in contract.message(name).signals}, counter=5))
    own, other = frames
    assert other.arbitration_id - own.arbitration_id == offset
    assert e2e.is_valid(other.data, other.arbitration_id)
    assert not e2e.is_valid(own.data, other.arbitration_id)
    assert Contract().decode(other) is None
    assert Contract(identifier_offset=offset).decode(own) is None


@pytest.mark.parametrize("name", PROTECTED)
def test_frames_of_the_contract_are_protected_where_the_dbc_says(name: str) -> None:
    contract = Contract()
    message = contract.message(name)
    frame = contract.encode(name, {signal.name: 0 for signal in message.signals}, counter=5)
    signals = message.decode(frame.data, decode_choices=False)
    assert signals["Counter"] == 5
    assert signals["DataIdNibble"] == contract.data_id(name) >> 8
    assert e2e.is_valid(bytes(frame.data), contract.data_id(name))
