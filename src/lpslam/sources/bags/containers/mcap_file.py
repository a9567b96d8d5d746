"""MCAP files of any profile, by their index; without one, or cut off, from the first record to the last whole.

The format: https://mcap.dev/spec
"""

from collections.abc import Collection, Iterable, Iterator
from pathlib import Path
from typing import BinaryIO

from mcap.exceptions import McapError
from mcap.reader import SeekingReader
from mcap.records import Channel, Chunk, ChunkIndex, McapRecord, Schema
from mcap.records import Message as Record
from mcap.stream_reader import StreamReader, breakup_chunk
from mcap.summary import Summary

from lpslam.errors import UserError
from lpslam.sources.bags.containers.container import Damage, Encoding, Message, Topic, ros2_type, say_before_a_pass

MAGIC = b"\x89MCAP0\r\n"
_LARGEST_RECORD = 1 << 30
"""Bytes; a chunk of a recording is some megabytes, and one record that claims more than this is damage."""


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
        records = self._sought(list(topics), start, end) if self._is_indexed else self._scanned({}, {})
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
        try:
            with self.path.open("rb") as file:
                summary = SeekingReader(file, record_size_limit=_LARGEST_RECORD).get_summary()
        except Exception:
            return None
        size = self.path.stat().st_size
        if summary is None or any(
            chunk.chunk_start_offset + chunk.chunk_length > size or chunk.uncompressed_size > _LARGEST_RECORD
            for chunk in summary.chunk_indexes
        ):
            return None
        return summary

    def _sought(self, names: list[str], start: int | None, end: int | None) -> Iterator[tuple[Channel, Record]]:
        with self.path.open("rb") as file:
            reader = _Indexed(file, self._index)
            for _, channel, record in reader.iter_messages(names, starting_at=start, ending_before=end):
                yield channel, record

    def _read_all(self) -> tuple[Topic, ...]:
        """Topics and times of a file without an index, which one pass over it tells; and an index, if it has chunks."""
        say_before_a_pass(self.path)
        index = Summary()
        is_in_chunks = True
        with self.path.open("rb") as file:
            begun = 0
            try:
                for record in StreamReader(file, emit_chunks=True, record_size_limit=_LARGEST_RECORD).records:
                    inner = breakup_chunk(record) if isinstance(record, Chunk) else [record]
                    times = self._noted(inner, index)
                    if isinstance(record, Chunk) and times:
                        index.chunk_indexes.append(_entry(record, begun, times))
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
            if isinstance(record, Schema):
                index.schemas[record.id] = record
            elif isinstance(record, Channel):
                index.channels[record.id] = record
            elif isinstance(record, Record) and record.channel_id in index.channels:
                self._times.setdefault(index.channels[record.channel_id].topic, []).append(record.log_time)
                times.append(record.log_time)
        return times

    def _scanned(self, channels: dict[int, Channel], schemas: dict[int, Schema]) -> Iterator[tuple[Channel, Record]]:
        with self.path.open("rb") as file:
            try:
                for record in StreamReader(file, record_size_limit=_LARGEST_RECORD).records:
                    if isinstance(record, Schema):
                        schemas[record.id] = record
                    elif isinstance(record, Channel):
                        channels[record.id] = record
                    elif isinstance(record, Record) and record.channel_id in channels:
                        yield channels[record.channel_id], record
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
        with self.path.open("rb") as file:
            for chunk in self._index.chunk_indexes:
                for offset in filter(None, map(chunk.message_index_offsets.get, channels)):
                    file.seek(offset)
                    times += _index_times(file.read(9), file.read)
        return sorted(times)


class _Indexed(SeekingReader):
    """A reader that knows the file's index."""

    def __init__(self, file: BinaryIO, summary: Summary | None) -> None:
        super().__init__(file, record_size_limit=_LARGEST_RECORD)
        self._known = summary

    def get_summary(self) -> Summary | None:
        """As it was read before."""
        return self._known


def _entry(chunk: Chunk, begun: int, times: list[int]) -> ChunkIndex:
    """A chunk's entry in an index; which channels it has is not stated."""
    return ChunkIndex(
        chunk_length=0,
        chunk_start_offset=begun,
        compression=chunk.compression,
        compressed_size=len(chunk.data),
        message_end_time=max(times),
        message_index_length=0,
        message_index_offsets={},
        message_start_time=min(times),
        uncompressed_size=chunk.uncompressed_size,
    )


def _index_times(head: bytes, read: "object") -> list[int]:
    import struct

    if len(head) != 9 or head[0] != 0x07:
        return []
    length = min(struct.unpack("<Q", head[1:])[0], _LARGEST_RECORD)
    body: bytes = read(length)  # type: ignore[operator]
    entries = (len(body) - 6) // 16
    return [struct.unpack_from("<Q", body, 6 + 16 * row)[0] for row in range(entries)]


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
