"""Reading recordings that are MCAP, also those that end in the middle of a record."""

import json
import struct
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from io import BytesIO
from pathlib import Path

import numpy as np
import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Statistics
from mcap.records import Metadata as MetadataRecord
from mcap.stream_reader import CRCValidationError, get_chunk_data_stream
from mcap.writer import MCAP0_MAGIC

from ..errors import UserError
from .mcap_messages import ENCODING, HEADER_BYTES, MessageCodec
from .mcap_sink import CHUNK_BYTES, METADATA
from .model import BLOCK_ROWS, Group, Metadata, cut_sentence, metadata_of, of_sextant

ENTRY = np.dtype([("time", "<u8"), ("offset", "<u8")])  # of a chunk's index
RECENT_CHUNKS = 4
# What the libraries raise where a record is not what it should be; lz4 raises RuntimeError.
UNREADABLE = (ValueError, KeyError, TypeError, struct.error, RuntimeError, McapError, zstandard.ZstdError, MemoryError)


@dataclass
class ChunkPlace:
    """Where a chunk is, and by channel where its index is or, where it has none, where its messages begin in it."""

    offset: int
    length: int
    is_bare: bool = False  # no chunk: messages that stand in the file one behind the other
    indexes: dict[int, tuple[int, int]] = field(default_factory=dict)  # place in the file and entries
    offsets: dict[int, list[int]] = field(default_factory=dict)

    def rows(self, channel: int) -> int:
        if channel in self.offsets:
            return len(self.offsets[channel])
        return self.indexes.get(channel, (0, 0))[1]


class McapSource:
    """The channels of a recording, those of one group together; the file is read record by record, not by its summary,
    which a cut removes, nor by the indexes of its chunks alone, which a file need not have."""

    unverified = None  # its chunks have checksums

    def __init__(self, path: Path) -> None:
        self._path = path
        self.paths = [path]
        self.metadata: Metadata = {}
        self.groups: dict[str, Group] = {}
        self.cut: str | None = None
        self._codecs: dict[str, MessageCodec] = {}
        self._channels: set[int] = set()  # that have been taken
        self._stated: dict[int, int] | None = None  # messages by channel, as the file counts them itself
        self._chunks: list[ChunkPlace] = []
        self._recent: dict[int, bytes] = {}
        with path.open("rb") as file:
            if file.read(len(MCAP0_MAGIC)) != MCAP0_MAGIC:
                raise UserError(f"{path} is not an MCAP file.")
            lost_bytes = self._scan(file, path.stat().st_size)
        self._index_chunks(is_cut=lost_bytes is not None)
        if not self.groups and lost_bytes is not None:
            raise UserError(f"{path} is truncated, and nothing of it is readable.")
        if not self.groups:
            raise UserError(f"{path} has no channel of a Sextant recording; scripts/record writes them.")
        if lost_bytes is not None:
            kept = {name: self.rows(name) for name in self.groups}
            lost = f"its last {lost_bytes} bytes are of an incomplete record" if lost_bytes else "it lacks its end"
            self.cut = cut_sentence(path, kept, lost)
        elif self._stated:  # a file that leaves its counts empty tells none
            self._check_counts(self._stated)

    def _check_counts(self, stated: dict[int, int]) -> None:
        """The file's own count of messages and those that are there."""
        for name in self.groups:
            expected = sum(stated.get(channel, 0) for channel in self._codecs[name].channels)
            found = self.rows(name)
            if expected != found:
                counts = f"it counts {expected} messages of {name}, and {found} are there"
                raise UserError(f"{self._path} is damaged: {counts}.")

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
                with of_sextant(self._path, f"the metadata {METADATA}"):
                    text = record.metadata["json"]
                parsed = json.loads(text)
                with of_sextant(self._path, f"the metadata {METADATA}"):
                    self.metadata = metadata_of(parsed)
        elif opcode == Opcode.STATISTICS:
            self._stated = Statistics.read(ReadDataStream(BytesIO(file.read(length)))).channel_message_counts
        elif opcode == Opcode.CHUNK:
            self._chunks.append(ChunkPlace(begin + HEADER_BYTES, length))
        elif opcode == Opcode.MESSAGE:
            self._take_bare(int.from_bytes(file.read(2), "little"), begin, HEADER_BYTES + length)
        elif opcode == Opcode.MESSAGE_INDEX and self._chunks:
            channel, size = struct.unpack("<HI", file.read(6))
            if size != length - 6:
                raise ValueError("an index of another length than its record")
            self._chunks[-1].indexes[channel] = (begin + HEADER_BYTES + 6, size // ENTRY.itemsize)

    def _take_bare(self, channel: int, begin: int, length: int) -> None:
        """A message outside of a chunk. Those that follow each other are read together, as a chunk is."""
        last = self._chunks[-1] if self._chunks else None
        if last is None or not last.is_bare or last.offset + last.length != begin or last.length >= CHUNK_BYTES:
            last = ChunkPlace(begin, 0, is_bare=True)
            self._chunks.append(last)
        last.offsets.setdefault(channel, []).append(begin - last.offset)
        last.length += length

    def _take_channel(self, channel: Channel) -> None:
        """A channel of a group that another one has too, as merged files have, adds its rows to it."""
        described = channel.metadata.get("sextant_group")
        if described is None or channel.id in self._channels:
            return
        self._channels.add(channel.id)
        parsed = json.loads(described)
        with of_sextant(self._path, f"the description of the channel {channel.topic}"):
            group = Group.of(parsed)
            if channel.message_encoding != ENCODING:
                raise ValueError("messages of another encoding")
        number, name = 1, group.name
        while group.name in self.groups and self.groups[group.name] != group:
            number += 1
            group = replace(group, name=f"{name}_{number}")
        if group.name in self.groups:
            self._codecs[group.name].channels.append(channel.id)
            return
        self.groups[group.name] = group
        self._codecs[group.name] = MessageCodec(group, channel.id)

    def _index_chunks(self, is_cut: bool) -> None:
        """Chunks without an index tell themselves what is in them; so does the last one of a file that is cut, since
        what stands behind it may be of its index or not, and every one where no channel stands outside of them."""
        has_channels = bool(self.groups)
        for number, place in enumerate(self._chunks):
            is_last = number == len(self._chunks) - 1
            if not place.is_bare and (not place.indexes or not has_channels or (is_cut and is_last)):
                self._index(number, place)

    def _index(self, number: int, place: ChunkPlace) -> None:
        data, offset = self._data(number), 0
        place.offsets = {}
        while offset + HEADER_BYTES <= len(data):
            opcode, length = struct.unpack_from("<BQ", data, offset)
            body = offset + HEADER_BYTES
            try:
                if opcode == Opcode.MESSAGE:
                    place.offsets.setdefault(struct.unpack_from("<H", data, body)[0], []).append(offset)
                elif opcode == Opcode.CHANNEL:
                    self._take_channel(Channel.read(ReadDataStream(BytesIO(data[body : body + length]))))
            except UNREADABLE as error:
                raise self._damaged(place.offset - HEADER_BYTES, f"a record of a chunk: {error}") from None
            offset = body + length

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
        if place.is_bare:
            return stored
        try:
            chunk = Chunk.read(ReadDataStream(BytesIO(stored)))
            data, length = get_chunk_data_stream(chunk, validate_crc=True)
        except CRCValidationError:
            raise self._damaged(begin, "the chunk there does not match its checksum") from None
        except UNREADABLE as error:
            raise self._damaged(begin, f"the chunk there cannot be decompressed ({error})") from None
        return data.read(length)

    def _offsets(self, place: ChunkPlace, channels: list[int]) -> np.ndarray:
        """Where the messages of some channels begin in a chunk, in their order."""
        found = [np.empty(0, np.int64)]
        for channel in channels:
            if channel in place.offsets:
                found.append(np.array(place.offsets[channel], np.int64))
            elif channel in place.indexes:
                begin, count = place.indexes[channel]
                found.append(np.fromfile(self._path, ENTRY, count, offset=begin)["offset"].astype(np.int64))
        return found[1] if len(found) == 2 else np.sort(np.concatenate(found))

    def rows(self, name: str) -> int:
        return sum(place.rows(channel) for place in self._chunks for channel in self._codecs[name].channels)

    def blocks(self, name: str, rows: int = BLOCK_ROWS) -> Iterator[np.ndarray]:
        codec = self._codecs[name]
        for number, place in enumerate(self._chunks):
            offsets = self._offsets(place, codec.channels)
            if not len(offsets):
                continue
            data = memoryview(self._data(number))
            try:
                whole = codec.decode(data, offsets)
            except UNREADABLE as error:
                raise self._damaged(place.offset - HEADER_BYTES, f"index or rows of a chunk: {error}") from None
            for begin in range(0, len(whole), rows):
                yield whole[begin : begin + rows]
