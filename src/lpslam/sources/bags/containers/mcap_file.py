"""MCAP files of any profile, by their index; without one, or cut off, from the first record to the last whole.

The format: https://mcap.dev/spec
"""

import heapq
import struct
from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import BinaryIO

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, ChunkIndex, McapRecord, Schema
from mcap.records import Message as Record
from mcap.stream_reader import StreamReader, breakup_chunk
from mcap.summary import Summary

from lpslam.errors import UserError
from lpslam.sources.bags.containers.container import Damage, Encoding, Message, Topic, ros2_type, say_before_a_pass
from lpslam.sources.bags.containers.unpacking import LARGEST, LARGEST_SHARE, unpacked

MAGIC = b"\x89MCAP0\r\n"
_HEAD, _FOOTER = 9, 29
"""Bytes of a record before what it holds, and of the last record."""
_LARGEST_SUMMARY = 1 << 26
"""Bytes of the index; of a recording of 100 GB it has thirty million."""
_ENTRY = 16
"""Bytes of a message in an index: its time and its place."""
_MOST_HELD = 1 << 29
"""Bytes of messages that wait for their turn; chunks overlap by little, as they were recorded."""


class McapFile:
    """A `Container` over one `.mcap`.

    Args:
        path: the file.

    Raises:
        UserError: it is no MCAP file.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._damage = Damage(path)
        self.damages = [self._damage]
        with path.open("rb") as file:
            if file.read(len(MAGIC)) != MAGIC:
                raise UserError(f"{path} is no MCAP file")
        self._times: dict[str, list[int]] = {}
        summary = self._summary()
        # Read once: of a large file it has tens of thousands of entries.
        self._index = summary if summary is not None and summary.chunk_indexes else None
        self._is_indexed = self._index is not None
        if summary is not None and self._is_indexed:
            self.topics = tuple(_topics(list(summary.channels.values()), summary.schemas))
        else:
            self.topics = self._read_all()

    def messages(self, names: Collection[str], start: int | None = None, end: int | None = None) -> Iterator[Message]:
        """See `Container`."""
        topics = {topic.name: topic for topic in self.topics if topic.name in names}
        if not topics:
            return
        records = self._sought(list(topics), start, end) if self._is_indexed else self._scanned()
        try:
            for channel, record in records:
                if channel.topic in topics and _is_within(record.log_time, start, end):
                    yield Message(topics[channel.topic], record.log_time, record.data)
        except GeneratorExit:
            raise
        except Exception as error:
            self._damage.note(f"a part of it cannot be read ({_said(error)})")

    def times(self, name: str) -> list[int]:
        """See `Container`."""
        if self._is_indexed and name not in self._times:
            self._times[name] = self._read_times(name)
        return self._times.get(name, [])

    def _summary(self) -> Summary | None:
        """The index at the file's end; None where there is none that can be used."""
        size = self.path.stat().st_size
        summary = Summary()
        try:
            with self.path.open("rb") as file:
                file.seek(size - len(MAGIC) - _FOOTER)
                footer = file.read(_FOOTER)
                begun = struct.unpack_from("<Q", footer, _HEAD)[0]
                if footer[0] != Opcode.FOOTER or not size - _LARGEST_SUMMARY < begun < size:
                    return None
                file.seek(begun)
                for record in StreamReader(file, skip_magic=True, emit_chunks=True, record_size_limit=LARGEST).records:
                    if isinstance(record, ChunkIndex):
                        summary.chunk_indexes.append(record)
                    else:
                        _take(record, summary)
        except Exception:
            return None
        if any(
            chunk.chunk_start_offset + chunk.chunk_length > size or chunk.uncompressed_size > LARGEST
            for chunk in summary.chunk_indexes
        ):
            return None
        # Many entries of one chunk would have it unpacked as often.
        is_twice = len({chunk.chunk_start_offset for chunk in summary.chunk_indexes}) < len(summary.chunk_indexes)
        unpacks_to = sum(chunk.uncompressed_size for chunk in summary.chunk_indexes)
        return None if is_twice or unpacks_to > LARGEST + LARGEST_SHARE * size else summary

    def _sought(self, names: list[str], start: int | None, end: int | None) -> Iterator[tuple[Channel, Record]]:
        """Messages in order of time; of chunks that overlap by more than memory has room for, as they come."""
        assert self._index is not None
        channels = {number: each for number, each in self._index.channels.items() if each.topic in names}
        waiting: list[tuple[int, int, int, Record]] = []
        held = 0
        with self.path.open("rb") as file:
            for entry in _reaching(self._index.chunk_indexes, channels.keys(), start, end):
                while waiting and (waiting[0][0] < entry.message_start_time or held > _MOST_HELD):
                    record = heapq.heappop(waiting)[-1]
                    held -= len(record.data)
                    yield channels[record.channel_id], record
                messages = (each for each in _records_of(_chunk_at(file, entry)) if isinstance(each, Record))
                for row, each in enumerate(messages):
                    if each.channel_id in channels and _is_within(each.log_time, start, end):
                        heapq.heappush(waiting, (each.log_time, entry.chunk_start_offset, row, each))
                        held += len(each.data)
        while waiting:
            record = heapq.heappop(waiting)[-1]
            yield channels[record.channel_id], record

    def _read_all(self) -> tuple[Topic, ...]:
        """Topics and times of a file without an index, which one pass over it tells; and an index, if it has chunks."""
        say_before_a_pass(self.path)
        index = Summary()
        is_in_chunks, size = True, self.path.stat().st_size
        begun = count = 0
        with self.path.open("rb") as file:
            try:
                for record in StreamReader(file, emit_chunks=True, record_size_limit=LARGEST).records:
                    inner = _records_of(record) if isinstance(record, Chunk) else [record]
                    count += record.uncompressed_size if isinstance(record, Chunk) else 0
                    if count > LARGEST + LARGEST_SHARE * size:
                        raise ValueError(f"it unpacks to more than {LARGEST_SHARE} times its size")
                    times = self._noted(inner, index)
                    if isinstance(record, Chunk) and times:
                        index.chunk_indexes.append(_entry(record, begun, file.tell() - begun, times))
                    is_in_chunks &= isinstance(record, Chunk) or not times
                    begun = file.tell()
            except Exception as error:
                self._damage.note(
                    f"it is cut off or damaged {file.tell() / 1e6:.3f} MB from its beginning ({_said(error)})"
                )
        for noted in self._times.values():
            noted.sort()
        if is_in_chunks and index.chunk_indexes:
            self._index, self._is_indexed = index, True
        return tuple(_topics(list(index.channels.values()), index.schemas))

    def _noted(self, records: Iterable[McapRecord], index: Summary) -> list[int]:
        """Take schemas, channels and times of messages to the index; the times of these."""
        times = []
        for record in records:
            _take(record, index)
            if isinstance(record, Record) and record.channel_id in index.channels:
                self._times.setdefault(index.channels[record.channel_id].topic, []).append(record.log_time)
                times.append(record.log_time)
        return times

    def _scanned(self) -> Iterator[tuple[Channel, Record]]:
        index = Summary()
        with self.path.open("rb") as file:
            try:
                for outer in StreamReader(file, emit_chunks=True, record_size_limit=LARGEST).records:
                    for record in _records_of(outer) if isinstance(outer, Chunk) else (outer,):
                        _take(record, index)
                        if isinstance(record, Record) and record.channel_id in index.channels:
                            yield index.channels[record.channel_id], record
            except GeneratorExit:
                raise
            except Exception as error:
                self._damage.note(
                    f"it is cut off or damaged {file.tell() / 1e6:.3f} MB from its beginning ({_said(error)})"
                )

    def _read_times(self, name: str) -> list[int]:
        """The indexes of messages lie behind their chunks: one small record for each chunk and channel."""
        assert self._index is not None
        channels = [number for number, channel in self._index.channels.items() if channel.topic == name]
        times: list[int] = []
        most = self.path.stat().st_size // _ENTRY
        with self.path.open("rb") as file:
            for chunk in self._index.chunk_indexes:
                for offset in filter(None, map(chunk.message_index_offsets.get, channels)):
                    file.seek(offset)
                    times += _index_times(file.read(9), file.read)
                    if len(times) > most:
                        self._damage.note("its index lists messages again and again")
                        return sorted(times[:most])
        return sorted(times)


def _take(record: McapRecord, index: Summary) -> None:
    """Note a schema or a channel."""
    if isinstance(record, Schema):
        index.schemas[record.id] = record
    elif isinstance(record, Channel):
        index.channels[record.id] = record


def _chunk_at(file: BinaryIO, entry: ChunkIndex) -> Chunk:
    file.seek(entry.chunk_start_offset + _HEAD)
    chunk: Chunk = Chunk.read(ReadDataStream(BytesIO(file.read(min(entry.chunk_length - _HEAD, LARGEST)))))
    return chunk


def _records_of(chunk: Chunk) -> list[McapRecord]:
    """What lies in a chunk, which unpacks to what it says of itself and to no more."""
    data = unpacked(chunk.compression, chunk.data, chunk.uncompressed_size)
    return breakup_chunk(replace(chunk, compression="", data=data))


def _reaching(
    entries: list[ChunkIndex], channels: Collection[int], start: int | None, end: int | None
) -> list[ChunkIndex]:
    """Chunks with messages of some channels between two times, by their first message."""
    reaching = [
        each
        for each in entries
        if (start is None or each.message_end_time >= start)
        and (end is None or each.message_start_time < end)
        and (not each.message_index_offsets or any(number in each.message_index_offsets for number in channels))
    ]
    return sorted(reaching, key=lambda each: (each.message_start_time, each.chunk_start_offset))


def _entry(chunk: Chunk, begun: int, length: int, times: list[int]) -> ChunkIndex:
    """A chunk's entry in an index; which channels it has is not stated."""
    return ChunkIndex(
        chunk_length=length,
        chunk_start_offset=begun,
        compression=chunk.compression,
        compressed_size=len(chunk.data),
        message_end_time=max(times),
        message_index_length=0,
        message_index_offsets={},
        message_start_time=min(times),
        uncompressed_size=chunk.uncompressed_size,
    )


def _index_times(head: bytes, read: Callable[[int], bytes]) -> list[int]:
    if len(head) != 9 or head[0] != 0x07:
        return []
    body = read(min(struct.unpack("<Q", head[1:])[0], LARGEST))
    entries = (len(body) - 6) // _ENTRY
    return [struct.unpack_from("<Q", body, 6 + _ENTRY * row)[0] for row in range(entries)]


def _topics(channels: list[Channel], schemas: dict[int, Schema]) -> Iterator[Topic]:
    seen: set[str] = set()
    for channel in channels:
        schema = schemas.get(channel.schema_id)
        if channel.topic in seen or schema is None:
            continue
        seen.add(channel.topic)
        try:
            encoding = Encoding(channel.message_encoding)
        except ValueError:
            encoding = Encoding.UNKNOWN
        kind = schema.name if encoding is Encoding.JSON else ros2_type(schema.name)
        yield Topic(channel.topic, kind, encoding)


def _is_within(logged: int, start: int | None, end: int | None) -> bool:
    return (start is None or logged >= start) and (end is None or logged < end)


def _said(error: Exception) -> str:
    kind = "its end is missing" if isinstance(error, EOFError | McapError) else ""
    return kind or " ".join(str(error).split())[:80] or type(error).__name__
