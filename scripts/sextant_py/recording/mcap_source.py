"""Reading recordings that are MCAP, also those that end in the middle of a record."""

import json
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

import lz4.frame
import numpy as np
import zstandard
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk
from mcap.records import Metadata as MetadataRecord
from mcap.writer import MCAP0_MAGIC

from ..errors import UserError
from .mcap_messages import HEADER_BYTES, RECORD, MessageCodec
from .mcap_sink import METADATA
from .model import BLOCK_ROWS, Group, Metadata, cut_sentence


@dataclass
class ChunkPlace:
    """Where a chunk is, and how many rows of which channel its index counts."""

    offset: int
    length: int
    rows: dict[int, int]


class McapSource:
    """The channels of a recording; the file is read record by record, not by its summary, which a cut removes."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self.metadata: Metadata = {}
        self.groups: dict[str, Group] = {}
        self.cut: str | None = None
        self._codecs: dict[str, MessageCodec] = {}
        self._chunks: list[ChunkPlace] = []
        with path.open("rb") as file:
            if file.read(len(MCAP0_MAGIC)) != MCAP0_MAGIC:
                raise UserError(f"{path} is not an MCAP file.")
            lost_bytes = self._scan(file, path.stat().st_size)
        if not self.groups:
            raise UserError(f"{path} has no channel of a Sextant recording; scripts/record writes them.")
        if lost_bytes is not None:
            kept = {name: self.rows(name) for name in self.groups}
            self.cut = cut_sentence(path, kept, f"its last {lost_bytes} bytes are of an incomplete record")

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
            self._take(file, opcode, begin, length)
            file.seek(begin + HEADER_BYTES + length)

    def _take(self, file: BytesIO, opcode: int, begin: int, length: int) -> None:
        if opcode == Opcode.CHANNEL:
            self._take_channel(Channel.read(ReadDataStream(BytesIO(file.read(length)))))
        elif opcode == Opcode.METADATA:
            record = MetadataRecord.read(ReadDataStream(BytesIO(file.read(length))))
            if record.name == METADATA:
                self.metadata = json.loads(record.metadata["json"])
        elif opcode == Opcode.CHUNK:
            self._chunks.append(ChunkPlace(begin + HEADER_BYTES, length, {}))
        elif opcode == Opcode.MESSAGE_INDEX and self._chunks:
            channel, size = struct.unpack("<HI", file.read(6))
            self._chunks[-1].rows[channel] = size // 16

    def _take_channel(self, channel: Channel) -> None:
        described = channel.metadata.get("sextant_group")
        if described is None:
            return
        group = Group.of(json.loads(described))
        self.groups[group.name] = group
        self._codecs[group.name] = MessageCodec(group, channel.id)

    def _decompressed(self, place: ChunkPlace) -> bytes:
        with self._path.open("rb") as file:
            file.seek(place.offset)
            chunk = Chunk.read(ReadDataStream(BytesIO(file.read(place.length))))
        if chunk.compression == "zstd":
            return zstandard.ZstdDecompressor().decompress(chunk.data, chunk.uncompressed_size)
        return lz4.frame.decompress(chunk.data) if chunk.compression == "lz4" else chunk.data

    def rows(self, name: str) -> int:
        channel = self._codecs[name].channel
        return sum(place.rows.get(channel, 0) for place in self._chunks)

    def blocks(self, name: str, rows: int = BLOCK_ROWS) -> Iterator[np.ndarray]:
        codec = self._codecs[name]
        for place in self._chunks:
            if place.rows and codec.channel not in place.rows:
                continue
            found = [block for block in self._of_chunk(codec, self._decompressed(place)) if len(block)]
            if found:
                whole = np.concatenate(found)
                for begin in range(0, len(whole), rows):
                    yield whole[begin : begin + rows]

    def _of_chunk(self, codec: MessageCodec, data: bytes) -> Iterator[np.ndarray]:
        view, offset = memoryview(data), 0
        others = {other.channel: other for other in self._codecs.values()}
        while offset + RECORD.itemsize <= len(view):
            opcode, length, channel = struct.unpack_from("<BQH", view, offset)
            if opcode == Opcode.MESSAGE and channel in others:
                block, offset = others[channel].decode(view, offset)
                if channel == codec.channel:
                    yield block
            else:
                offset += HEADER_BYTES + length
