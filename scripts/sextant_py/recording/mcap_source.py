"""Reading recordings that are MCAP, also those that end in the middle of a record."""

import json
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

import lz4.frame
import numpy as np
import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk
from mcap.records import Metadata as MetadataRecord
from mcap.writer import MCAP0_MAGIC

from ..errors import UserError
from .mcap_messages import HEADER_BYTES, RECORD, MessageCodec
from .mcap_sink import METADATA
from .model import BLOCK_ROWS, Group, Metadata, cut_sentence

ENTRY = np.dtype([("time", "<u8"), ("offset", "<u8")])  # of a chunk's index
RECENT_CHUNKS = 4
# What the libraries raise where a record is not what it should be; lz4 raises RuntimeError.
UNREADABLE = (ValueError, KeyError, TypeError, struct.error, RuntimeError, McapError, zstandard.ZstdError, MemoryError)


@dataclass
class ChunkPlace:
    """Where a chunk is, and by channel where its index is or, where the file is cut behind the chunk, what it says."""

    offset: int
    length: int
    indexes: dict[int, tuple[int, int]]  # place in the file and entries
    offsets: dict[int, np.ndarray]

    def rows(self, channel: int) -> int:
        if channel in self.offsets:
            return len(self.offsets[channel])
        return self.indexes.get(channel, (0, 0))[1]


class McapSource:
    """The channels of a recording; the file is read record by record, not by its summary, which a cut removes."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self.paths = [path]
        self.metadata: Metadata = {}
        self.groups: dict[str, Group] = {}
        self.cut: str | None = None
        self._codecs: dict[str, MessageCodec] = {}
        self._chunks: list[ChunkPlace] = []
        self._recent: dict[int, bytes] = {}
        with path.open("rb") as file:
            if file.read(len(MCAP0_MAGIC)) != MCAP0_MAGIC:
                raise UserError(f"{path} is not an MCAP file.")
            lost_bytes = self._scan(file, path.stat().st_size)
        if not self.groups:
            raise UserError(f"{path} has no channel of a Sextant recording; scripts/record writes them.")
        if lost_bytes is not None:
            self._index_last_chunk()
            kept = {name: self.rows(name) for name in self.groups}
            lost = f"its last {lost_bytes} bytes are of an incomplete record" if lost_bytes else "it lacks its end"
            self.cut = cut_sentence(path, kept, lost)

    def _scan(self, file: BytesIO, size: int) -> int | None:
        """Bytes of the incomplete record at the end; None where the file ends as it should."""
        has_end = False
        while True:
            begin = file.tell()
            head = file.read(HEADER_BYTES)
            if head == MCAP0_MAGIC and has_end:
                return None
            if len(head) < HEADER_BYTES:
                return size - begin
            opcode, length = struct.unpack("<BQ", head)
            if begin + HEADER_BYTES + length > size:
                return size - begin
            has_end = opcode == Opcode.FOOTER
            try:
                self._take(file, opcode, begin, length)
            except UNREADABLE as error:
                raise self._damaged(begin, f"the record there cannot be read ({error})") from None
            file.seek(begin + HEADER_BYTES + length)

    def _take(self, file: BytesIO, opcode: int, begin: int, length: int) -> None:
        if opcode == Opcode.CHANNEL:
            self._take_channel(Channel.read(ReadDataStream(BytesIO(file.read(length)))))
        elif opcode == Opcode.METADATA:
            record = MetadataRecord.read(ReadDataStream(BytesIO(file.read(length))))
            if record.name == METADATA:
                self.metadata = json.loads(record.metadata["json"])
        elif opcode == Opcode.CHUNK:
            self._chunks.append(ChunkPlace(begin + HEADER_BYTES, length, {}, {}))
        elif opcode == Opcode.MESSAGE_INDEX and self._chunks:
            channel, size = struct.unpack("<HI", file.read(6))
            if size != length - 6:
                raise ValueError("an index of another length than its record")
            self._chunks[-1].indexes[channel] = (begin + HEADER_BYTES + 6, size // ENTRY.itemsize)

    def _take_channel(self, channel: Channel) -> None:
        described = channel.metadata.get("sextant_group")
        if described is None:
            return
        group = Group.of(json.loads(described))
        self.groups[group.name] = group
        self._codecs[group.name] = MessageCodec(group, channel.id)

    def _index_last_chunk(self) -> None:
        """What stands behind the chunk may be of its index or not: the chunk itself tells."""
        if not self._chunks:
            return
        data, found, offset = self._data(len(self._chunks) - 1), {}, 0
        while offset + RECORD.itemsize <= len(data):
            opcode, length, channel = struct.unpack_from("<BQH", data, offset)
            if opcode == Opcode.MESSAGE:
                found.setdefault(channel, []).append(offset)
            offset += HEADER_BYTES + length
        self._chunks[-1].offsets = {channel: np.array(offsets) for channel, offsets in found.items()}

    def _data(self, number: int) -> bytes:
        """A chunk, decompressed. Readers of several groups come for it one after the other."""
        if number not in self._recent:
            self._recent[number] = self._decompressed(self._chunks[number])
            while len(self._recent) > RECENT_CHUNKS:
                self._recent.pop(next(iter(self._recent)))
        return self._recent[number]

    def _damaged(self, offset: int, reason: str) -> UserError:
        return UserError(f"{self._path} is damaged at byte {offset}: {reason}.")

    def _decompressed(self, place: ChunkPlace) -> bytes:
        """UserError where the chunk does not match its checksum; 0 is none."""
        begin = place.offset - HEADER_BYTES
        with self._path.open("rb") as file:
            file.seek(place.offset)
            stored = file.read(place.length)
        try:
            chunk = Chunk.read(ReadDataStream(BytesIO(stored)))
            data = decompressed(chunk)
        except UNREADABLE as error:
            raise self._damaged(begin, f"the chunk there cannot be decompressed ({error})") from None
        if chunk.uncompressed_crc and chunk.uncompressed_crc != zlib.crc32(data):
            raise self._damaged(begin, "the chunk there does not match its checksum")
        return data

    def _offsets(self, place: ChunkPlace, channel: int) -> np.ndarray:
        if channel in place.offsets:
            return place.offsets[channel]
        begin, count = place.indexes[channel]
        return np.fromfile(self._path, ENTRY, count, offset=begin)["offset"].astype(np.int64)

    def rows(self, name: str) -> int:
        channel = self._codecs[name].channel
        return sum(place.rows(channel) for place in self._chunks)

    def blocks(self, name: str, rows: int = BLOCK_ROWS) -> Iterator[np.ndarray]:
        codec = self._codecs[name]
        for number, place in enumerate(self._chunks):
            if place.rows(codec.channel):
                offsets = self._offsets(place, codec.channel)
                data = memoryview(self._data(number))
                try:
                    whole = codec.decode(data, offsets)
                except UNREADABLE as error:
                    raise self._damaged(place.offset - HEADER_BYTES, f"index or rows of a chunk: {error}") from None
                for begin in range(0, len(whole), rows):
                    yield whole[begin : begin + rows]


def decompressed(chunk: Chunk) -> bytes:
    if chunk.compression == "zstd":
        return zstandard.ZstdDecompressor().decompress(chunk.data, chunk.uncompressed_size)
    return lz4.frame.decompress(chunk.data) if chunk.compression == "lz4" else chunk.data
