"""The rows of a group as MCAP message records: a ROS 2 message a row, whole blocks at once."""

import json
import re
import struct

import numpy as np
from mcap.opcode import Opcode

from .model import Column, Group

ENCODING, SCHEMA_ENCODING = "cdr", "ros2msg"
RECORD = np.dtype(
    [("opcode", "u1"), ("length", "<u8"), ("channel", "<u2"), ("sequence", "<u4"), ("log", "<u8"), ("publish", "<u8")]
)
HEADER_BYTES = 9  # opcode and length, which the length does not count
CDR_LITTLE_ENDIAN = 0x00000100  # the four bytes before the values, as a little-endian number
_ROS_TYPES = {
    **{"|u1": "uint8", "<u2": "uint16", "<u4": "uint32", "<u8": "uint64"},
    **{"|i1": "int8", "<i2": "int16", "<i4": "int32", "<i8": "int64"},
    **{"<f4": "float32", "<f8": "float64"},
}


def field_name(name: str) -> str:
    """A name that a ROS 2 message allows: lower case and underscores."""
    spaced = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name)
    return re.sub(r"_+", "_", re.sub(r"[^A-Za-z0-9]", "_", spaced)).strip("_").lower()


def message_name(group: Group) -> str:
    words = re.findall(r"[A-Za-z0-9]+", group.name)
    return "sextant_msgs/msg/" + "".join(word[0].upper() + word[1:] for word in words)


def schema_text(group: Group) -> str:
    """The group as a ROS 2 message definition, with units and descriptions as comments."""
    lines = [f"# {group.text}"] if group.text else []
    for column in group.columns:
        kind = "string" if column.is_text else _ROS_TYPES[column.kind]
        lines.append(f"{kind} {field_name(column.name)}  # [{column.unit}] {column.text}")
    return "\n".join(lines) + "\n"


def topic(group: Group) -> str:
    return f"/{group.name}"


def channel_metadata(group: Group) -> dict[str, str]:
    return {"sextant_group": json.dumps(group.described(), ensure_ascii=False)}


def aligned(offset: int, size: int) -> int:
    return -(-offset // size) * size


class MessageCodec:
    """Message records of a group, to bytes of one channel, and back from all channels that have it."""

    def __init__(self, group: Group, channel: int) -> None:
        self.group = group
        self.channel = channel
        self.channels = [channel]
        self._fixed = self._layout() if not any(column.is_text for column in group.columns) else None

    def _layout(self) -> np.dtype:
        """A whole record of fixed size: CDR aligns each value to its size, counted behind the four bytes."""
        names = [*RECORD.names, "encapsulation"]
        kinds = [*(RECORD[name] for name in RECORD.names), np.dtype("<u4")]
        offsets = [*(RECORD.fields[name][1] for name in RECORD.names), RECORD.itemsize]
        start, end = RECORD.itemsize + 4, 0
        for column in self.group.columns:
            kind = np.dtype(column.kind)
            end = aligned(end, kind.itemsize)
            names.append(f"value {column.name}")
            kinds.append(kind)
            offsets.append(start + end)
            end += kind.itemsize
        return np.dtype({"names": names, "formats": kinds, "offsets": offsets, "itemsize": start + end})

    def encode(self, block: np.ndarray, sequence: int) -> tuple[bytes, np.ndarray]:
        """The records of a block, and where each begins."""
        times = self.group.times_ns(block)
        if self._fixed is None:
            return self._encode_rows(block, times, sequence)
        records = np.zeros(len(block), self._fixed)
        records["opcode"], records["channel"] = Opcode.MESSAGE, self.channel
        records["length"] = self._fixed.itemsize - HEADER_BYTES
        records["sequence"] = (sequence + np.arange(len(block))) & 0xFFFFFFFF
        records["log"] = records["publish"] = np.maximum(times, 0)
        records["encapsulation"] = CDR_LITTLE_ENDIAN
        for column in self.group.columns:
            records[f"value {column.name}"] = block[column.name]
        return records.tobytes(), np.arange(len(block), dtype=np.uint64) * np.uint64(self._fixed.itemsize)

    def _encode_rows(self, block: np.ndarray, times: np.ndarray, sequence: int) -> tuple[bytes, np.ndarray]:
        records, offsets = bytearray(), []
        for number, (row, time) in enumerate(zip(block, times, strict=True)):
            data = struct.pack("<I", CDR_LITTLE_ENDIAN) + self._encode_row(row)
            head = (Opcode.MESSAGE, RECORD.itemsize - HEADER_BYTES + len(data), self.channel)
            offsets.append(len(records))
            when = max(int(time), 0)
            records += struct.pack("<BQHIQQ", *head, (sequence + number) & 0xFFFFFFFF, when, when) + data
        return bytes(records), np.array(offsets, np.uint64)

    def _encode_row(self, row: np.void) -> bytes:
        data = bytearray()
        for column in self.group.columns:
            value = row[column.name]
            if column.is_text:
                data += bytes(aligned(len(data), 4) - len(data))
                data += struct.pack("<I", len(value) + 1) + bytes(value) + b"\0"
            else:
                data += bytes(aligned(len(data), value.itemsize) - len(data)) + value.tobytes()
        return bytes(data)

    def decode(self, chunk: memoryview, offsets: np.ndarray) -> np.ndarray:
        """The rows of the records that begin at these offsets of a chunk."""
        if self._fixed is None:
            heads = [struct.unpack_from("<BQH", chunk, offset)[::2] for offset in offsets.tolist()]
            if any(opcode != Opcode.MESSAGE or channel not in self.channels for opcode, channel in heads):
                raise self._misplaced()
            rows = [self._decode_row(chunk[offset + RECORD.itemsize + 4 :]) for offset in offsets.tolist()]
            return np.concatenate([np.empty(0, self.group.dtype), *rows])
        block, done = np.empty(len(offsets), self.group.dtype), 0
        for run in np.split(offsets, np.flatnonzero(np.diff(offsets) != self._fixed.itemsize) + 1):
            records = np.frombuffer(chunk, self._fixed, len(run), int(run[0]) if len(run) else 0)
            self._check(records)
            for column in self.group.columns:
                block[column.name][done : done + len(run)] = records[f"value {column.name}"]
            done += len(run)
        return block

    def _check(self, records: np.ndarray) -> None:
        """The index of a chunk has no checksum: what it points at must be a record of the group."""
        length = self._fixed.itemsize - HEADER_BYTES
        heads = (records["opcode"] == Opcode.MESSAGE) & np.isin(records["channel"], self.channels)
        if not np.all(heads & (records["length"] == length)):
            raise self._misplaced()

    def _misplaced(self) -> ValueError:
        return ValueError(f"no row of {self.group.name} is where the index says")

    def _decode_row(self, data: memoryview) -> np.ndarray:
        block, at = np.zeros(1, self.group.dtype), 0
        for column in self.group.columns:
            block[column.name], at = self._decode_value(column, data, at)
        return block

    @staticmethod
    def _decode_value(column: Column, data: memoryview, at: int) -> tuple[object, int]:
        if column.is_text:
            at = aligned(at, 4)
            length = struct.unpack_from("<I", data, at)[0]
            return bytes(data[at + 4 : at + 3 + length]), at + 4 + length
        kind = np.dtype(column.kind)
        at = aligned(at, kind.itemsize)
        return np.frombuffer(data, kind, 1, at)[0], at + kind.itemsize
