"""Recordings as MCAP: compressed chunks of ROS 2 messages, a message a row, with index and summary."""

import json
import time
import zlib
from contextlib import suppress
from pathlib import Path

import numpy as np
import zstandard
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)
from mcap.records import Metadata as MetadataRecord
from mcap.writer import MCAP0_MAGIC

from ..append_file import AppendFile
from .mcap_messages import ENCODING, SCHEMA_ENCODING, MessageCodec, channel_metadata, message_name, schema_text, topic
from .model import Group, Metadata

METADATA = "sextant_recording"
CHUNK_BYTES = 4_000_000
CHUNK_S = 1.0


def bytes_of(*records: McapRecord) -> bytes:
    builder = RecordBuilder()
    for record in records:
        record.write(builder)
    return builder.end()


class McapSink:
    """The library's records, but whole blocks of rows a time, since its writer takes every message by itself."""

    def __init__(self, path: Path, metadata: Metadata) -> None:
        self._file = AppendFile(path)
        self._size = 0
        self._codecs: dict[str, MessageCodec] = {}
        self._schemas: list[Schema] = []
        self._channels: list[Channel] = []
        self._chunks: list[tuple[ChunkIndex, int, dict[int, int]]] = []  # index, begin, rows by channel
        self._metadata: list[MetadataIndex] = []
        self._compressor = zstandard.ZstdCompressor(level=1)
        self._begin_chunk()
        try:
            self._write(MCAP0_MAGIC + bytes_of(Header(profile="ros2", library="sextant")))
            self._write_metadata(metadata)
        except OSError:
            self._file.close()
            raise

    @property
    def kept(self) -> dict[str, int]:
        """Rows that have reached the file."""
        return {
            name: sum(rows.get(codec.channel, 0) for _, _, rows in self._chunks) for name, codec in self._codecs.items()
        }

    def _write(self, data: bytes) -> int:
        """Where it begins."""
        begin = self._size
        self._file.append_bytes(data)
        self._size += len(data)
        return begin

    def _write_metadata(self, metadata: Metadata) -> None:
        record = MetadataRecord(METADATA, {"json": json.dumps(metadata, ensure_ascii=False)})
        data = bytes_of(record)
        self._metadata.append(MetadataIndex(self._write(data), len(data), METADATA))

    def add(self, group: Group) -> None:
        number = len(self._codecs) + 1
        schema = Schema(number, schema_text(group).encode(), SCHEMA_ENCODING, message_name(group))
        channel = Channel(number, topic(group), ENCODING, channel_metadata(group), number)
        self._write(bytes_of(schema, channel))
        self._schemas.append(schema)
        self._channels.append(channel)
        self._codecs[group.name] = MessageCodec(group, number)
        self._taken[number] = 0

    def _begin_chunk(self) -> None:
        self._parts: list[bytes] = []
        self._part_bytes = 0
        self._index: dict[int, list[np.ndarray]] = {}
        self._begin_s = time.monotonic()
        self._taken = getattr(self, "_taken", {})

    def append(self, name: str, block: np.ndarray) -> None:
        if not len(block):
            return
        codec = self._codecs[name]
        data, offsets = codec.encode(block, self._taken[codec.channel])
        times = np.maximum(codec.group.times_ns(block), 0).astype(np.uint64)
        self._taken[codec.channel] += len(block)
        self._index.setdefault(codec.channel, []).append(
            np.column_stack((times, offsets + np.uint64(self._part_bytes)))
        )
        self._parts.append(data)
        self._part_bytes += len(data)
        if self._part_bytes >= CHUNK_BYTES or time.monotonic() - self._begin_s >= CHUNK_S:
            self.flush()

    def flush(self) -> None:
        """Writes the chunk that is begun. A chunk that finds no room is given up."""
        if not self._parts:
            return
        data, index = b"".join(self._parts), {key: np.concatenate(parts) for key, parts in self._index.items()}
        self._begin_chunk()
        compressed = self._compressor.compress(data)
        first = min(int(entries[:, 0].min()) for entries in index.values())
        last = max(int(entries[:, 0].max()) for entries in index.values())
        chunk = bytes_of(Chunk("zstd", compressed, last, first, zlib.crc32(data), len(data)))
        offsets, indexes = {}, b""
        for channel, entries in index.items():
            offsets[channel] = self._size + len(chunk) + len(indexes)
            indexes += index_record(channel, entries)
        begin = self._write(chunk + indexes)
        sizes = {"chunk_length": len(chunk), "compressed_size": len(compressed), "uncompressed_size": len(data)}
        times = {"message_start_time": first, "message_end_time": last}
        where = {"chunk_start_offset": begin, "message_index_length": len(indexes), "message_index_offsets": offsets}
        rows = {channel: len(entries) for channel, entries in index.items()}
        self._chunks.append((ChunkIndex(compression="zstd", **sizes, **times, **where), begin, rows))

    def close(self, metadata: Metadata) -> None:
        """Where the end finds no room, the last chunks make way for it."""
        try:
            with suppress(OSError):
                self.flush()
            while not self._ended(metadata) and self._chunks:
                _, begin, _ = self._chunks.pop()
                self._metadata = [entry for entry in self._metadata if entry.offset < begin]
                self._file.truncate(begin)
                self._size = begin
        finally:
            self._file.close()

    def _ended(self, metadata: Metadata) -> bool:
        begin, known = self._size, list(self._metadata)
        try:
            self._write_metadata({**metadata, "rows": self.kept})
            self._write(bytes_of(DataEnd(0)))
            self._write(self._summary())
        except OSError:
            self._metadata = known
            self._file.truncate(begin)
            self._size = begin
            return False
        return True

    def _statistics(self) -> Statistics:
        counts = {codec.channel: self.kept[name] for name, codec in self._codecs.items()}
        entries = [entry for entry, _, _ in self._chunks]
        return Statistics(
            attachment_count=0,
            channel_count=len(self._channels),
            channel_message_counts=counts,
            chunk_count=len(entries),
            message_count=sum(counts.values()),
            message_start_time=min((entry.message_start_time for entry in entries), default=0),
            message_end_time=max((entry.message_end_time for entry in entries), default=0),
            metadata_count=len(self._metadata),
            schema_count=len(self._schemas),
        )

    def _summary(self) -> bytes:
        begin, data, offsets = self._size, b"", []
        groups = {
            Opcode.SCHEMA: self._schemas,
            Opcode.CHANNEL: self._channels,
            Opcode.STATISTICS: [self._statistics()],
            Opcode.CHUNK_INDEX: [entry for entry, _, _ in self._chunks],
            Opcode.METADATA_INDEX: self._metadata,
        }
        for opcode, records in groups.items():
            part = bytes_of(*records)
            if part:
                offsets.append(SummaryOffset(opcode, begin + len(data), len(part)))
            data += part
        offset_begin = begin + len(data)
        data += bytes_of(*offsets)
        footer = bytes_of(Footer(begin, offset_begin, 0))
        checksum = zlib.crc32(data + footer[:-4])
        return data + bytes_of(Footer(begin, offset_begin, checksum)) + MCAP0_MAGIC


def index_record(channel: int, entries: np.ndarray) -> bytes:
    """A MessageIndex record: time and offset of each message of a chunk."""
    pairs = entries.astype("<u8").tobytes()
    head = channel.to_bytes(2, "little") + len(pairs).to_bytes(4, "little")
    return bytes([Opcode.MESSAGE_INDEX]) + (len(head) + len(pairs)).to_bytes(8, "little") + head + pairs
