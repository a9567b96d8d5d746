"""ROS 1 bags (format 2.0), by their index; without one, or with a broken one, from the first record to the last whole.

The format: http://wiki.ros.org/Bags/Format/2.0
"""

import struct
from bisect import bisect_left
from collections.abc import Collection, Iterator
from contextlib import contextmanager, suppress
from copy import copy
from io import SEEK_CUR, BytesIO
from pathlib import Path
from typing import BinaryIO

from rosbags.rosbag1 import Reader
from rosbags.rosbag1.reader import Chunk, Header, IndexData, ReaderError, RecordType

from lpslam.errors import UserError
from lpslam.sources.bags.containers.container import Damage, Encoding, Message, Topic, ros2_type, say_before_a_pass
from lpslam.sources.bags.containers.unpacking import LARGEST, LARGEST_SHARE, unpacked

MAGIC = b"#ROSBAG V2.0\n"


class _Indexed(Reader):
    """A reader of rosbags that unpacks no more than a recording has, nor reads its index more than once."""

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self._left = self._size = path.stat().st_size

    def read_chunk(self) -> Chunk:
        """Where a chunk lies, and how it is unpacked."""
        assert self.bio
        header = Header.read(self.bio, RecordType.CHUNK)
        length = struct.unpack("<I", self.bio.read(4))[0]
        begun = self.bio.tell()
        self.bio.seek(length, SEEK_CUR)
        compression, most = header.get_string("compression"), header.get_uint32("size")
        return Chunk(length, begun, lambda data: unpacked(compression, data, most))

    def read_index_data(self, pos: int, indexes: dict[int, list[IndexData]]) -> None:
        """Which messages of a connection a chunk has."""
        assert self.bio
        begun = self.bio.tell()
        super().read_index_data(pos, indexes)
        self._left -= self.bio.tell() - begun
        if self._left < 0:
            raise ReaderError("its index lists itself again and again")


class Ros1Bag:
    """A `Container` over one `.bag`.

    Args:
        path: the file.

    Raises:
        UserError: it is no bag of this format, or encrypted, or holds nothing that can be read.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._damage = Damage(path)
        self.damages = [self._damage]
        with path.open("rb") as file:
            magic = file.read(len(MAGIC))
            if magic != MAGIC:
                raise UserError(f"{path} is no ROS 1 bag of format 2.0")
            try:
                if Header.read(file, RecordType.BAGHEADER).get("encryptor"):
                    raise UserError(f"{path} is encrypted; decrypt it with 'rosbag decrypt' first")
            except UserError:
                raise
            except Exception as error:
                raise UserError(f"{path} ends within its first record; nothing can be read") from error
        self._times: dict[str, list[int]] = {}
        self._is_indexed = self._read_index()
        if not self._is_indexed:
            self._read_all()

    def messages(self, names: Collection[str], start: int | None = None, end: int | None = None) -> Iterator[Message]:
        """See `Container`."""
        topics = {topic.name: topic for topic in self.topics if topic.name in names}
        if not self._is_indexed:
            for name, logged, data in self._within(start, end):
                if name in topics and _is_within(logged, start, end):
                    yield Message(topics[name], logged, data)
            return
        with self._reader(start) as reader:
            connections = [each for each in reader.connections if each.topic in topics]
            if not connections:
                return
            try:
                for connection, logged, data in reader.messages(connections, start, end):
                    yield Message(topics[connection.topic], logged, data)
            except GeneratorExit:
                raise
            except Exception as error:
                self._damage.note(f"a part of it cannot be read ({_said(error)})")

    @contextmanager
    def _reader(self, start: int | None) -> Iterator[Reader]:
        """A reader of its own that begins at a time; the index was read once, which takes a second of a large bag."""
        reader = copy(self._index)
        if start is not None:
            reader.indexes = {
                number: entries[bisect_left(entries, start, key=lambda entry: entry.time) :]
                for number, entries in reader.indexes.items()
            }
        with self.path.open("rb") as file:
            reader.bio = file
            reader.current_chunk = (-1, BytesIO())
            yield reader

    def times(self, name: str) -> list[int]:
        """See `Container`."""
        return self._times.get(name, [])

    def _read_index(self) -> bool:
        try:
            self._index = reader = _Indexed(self.path)
            reader.open()
            # Closing it would drop its index.
            file, reader.bio = reader.bio, None
            if file is not None:
                file.close()
            by_name = {each.topic: _topic(each.topic, each.msgtype) for each in reader.connections}
            self.topics = tuple(by_name.values())
            for each in reader.connections:
                self._times.setdefault(each.topic, []).extend(entry.time for entry in reader.indexes[each.id])
        except Exception:
            self._times.clear()
            return False
        for times in self._times.values():
            times.sort()
        return bool(self.topics)

    def _read_all(self) -> None:
        """Topics and times of a bag without an index, which one pass over it tells."""
        say_before_a_pass(self.path)
        self._types: dict[str, str] = {}
        self._names: dict[int, str] = {}
        self._spans: dict[int, tuple[int, int]] = {}
        self._unpacked_bytes = 0
        for begun, name, logged in self._scanned():
            self._times.setdefault(name, []).append(logged)
            first, last = self._spans.get(begun, (logged, logged))
            self._spans[begun] = min(first, logged), max(last, logged)
        for times in self._times.values():
            times.sort()
        self.topics = tuple(_topic(name, kind) for name, kind in self._types.items())

    def _within(self, start: int | None, end: int | None) -> Iterator[tuple[str, int, bytes]]:
        """Topic, time and bytes of the messages of all records that reach between two times."""
        with self.path.open("rb") as file:
            for begun, (first, last) in self._spans.items():
                if (start is None or last >= start) and (end is None or first < end):
                    file.seek(begun)
                    # The last one may be damaged further on.
                    with suppress(Exception):
                        yield from self._unpacked(*_record(file), self._names)

    def _scanned(self) -> Iterator[tuple[int, str, int]]:
        """Place of the record, topic and time of every message from the beginning to where the file breaks off."""
        size = self.path.stat().st_size
        with self.path.open("rb") as file:
            file.seek(len(MAGIC))
            while file.tell() < size:
                begun = file.tell()
                try:
                    header, data = _record(file)
                    if self._unpacked_bytes > LARGEST + LARGEST_SHARE * size:
                        raise ValueError(f"it unpacks to more than {LARGEST_SHARE} times its size")
                    for name, logged, _ in self._unpacked(header, data, self._names):
                        yield begun, name, logged
                except GeneratorExit:
                    raise
                except Exception as error:
                    self._damage.note(
                        f"it is cut off or damaged {_megabytes(begun)} from its beginning ({_said(error)})"
                    )
                    return
        self._damage.note("it has no index, as after a power failure")

    def _unpacked(
        self, header: Header, data: bytes, names: dict[int, str], *, inside: bool = False
    ) -> Iterator[tuple[str, int, bytes]]:
        kind = header.get_uint8("op")
        if kind == RecordType.CHUNK:
            if inside:
                raise ValueError("a chunk lies in another one")
            found = unpacked(header.get_string("compression"), data, header.get_uint32("size"))
            self._unpacked_bytes += len(found)
            inner, end = BytesIO(found), len(found)
            while inner.tell() < end:
                yield from self._unpacked(*_record(inner), names, inside=True)
        elif kind == RecordType.CONNECTION:
            names[header.get_uint32("conn")] = name = header.get_string("topic")
            fields = BytesIO(struct.pack("<I", len(data)) + data)
            self._types[name] = Header.read(fields).get_string("type")
        elif kind == RecordType.MSGDATA and (number := header.get_uint32("conn")) in names:
            yield names[number], header.get_time("time"), data


def _record(file: BinaryIO | BytesIO) -> tuple[Header, bytes]:
    header = Header.read(file)
    prefix = file.read(4)
    length = struct.unpack("<I", prefix)[0]
    if length > LARGEST:
        raise ValueError(f"a record of {length} bytes")
    data = file.read(length)
    if len(data) != length:
        raise ValueError("it ends within a record")
    return header, data


def _topic(name: str, kind: str) -> Topic:
    return Topic(name, ros2_type(kind), Encoding.ROS1)


def _is_within(logged: int, start: int | None, end: int | None) -> bool:
    return (start is None or logged >= start) and (end is None or logged < end)


def _said(error: Exception) -> str:
    return " ".join(str(error).split())[:80] or type(error).__name__


def _megabytes(count: int) -> str:
    return f"{count / 1e6:.3f} MB"
