"""Opening a container whatever its format, and several that are parts of one recording."""

import heapq
import re
from collections.abc import Collection, Iterator
from pathlib import Path

from lpslam.errors import UserError
from lpslam.sources.bags.containers import mcap_file, ros1, sqlite
from lpslam.sources.bags.containers.container import Container, Message, Topic
from lpslam.sources.bags.containers.whole import ENDINGS, is_compressed, unpacked_whole

SUFFIXES = (".bag", ".db3", ".mcap")


def looks_like_bag(path: Path) -> bool:
    """Whether the path is a file of messages, or a folder with some, as ROS 2 writes it."""
    if path.is_dir():
        return bool(_parts(path))
    return _bare(path.name).endswith(SUFFIXES) or _format(path) is not None


def open_container(path: Path) -> Container:
    """Open a file of messages by what it begins with, or a folder with the parts of one.

    Raises:
        UserError: it is empty, compressed as a whole, or in no format that is known.
    """
    if path.is_dir():
        parts = _parts(path)
        return _opened(parts[0]) if len(parts) == 1 else Split(path, [_opened(part) for part in parts])
    return _opened(path)


class Split:
    """A `Container` over several files, one after the other in time.

    Args:
        path: their folder.
        parts: in the order of their numbers.
    """

    def __init__(self, path: Path, parts: list[Container]) -> None:
        self.path = path
        self.damages = [damage for part in parts for damage in part.damages]
        self._parts = parts
        self.topics: tuple[Topic, ...] = tuple({topic.name: topic for part in parts for topic in part.topics}.values())

    def messages(self, names: Collection[str], start: int | None = None, end: int | None = None) -> Iterator[Message]:
        """See `Container`."""
        for part in self._parts:
            yield from part.messages(names, start, end)

    def times(self, name: str) -> list[int]:
        """See `Container`."""
        return list(heapq.merge(*(part.times(name) for part in self._parts)))


def _parts(folder: Path) -> list[Path]:
    found = [path for path in folder.glob("*") if _bare(path.name).endswith(SUFFIXES[1:]) and path.is_file()]
    # What was unpacked already may lie beside what it came from.
    plain = {path.name.lower() for path in found}
    found = [path for path in found if _bare(path.name) == path.name.lower() or _bare(path.name) not in plain]
    return sorted(found, key=lambda path: [int(word) if word.isdecimal() else word for word in _words(path.name)])


def _bare(name: str) -> str:
    """A name in small letters, without the ending of what compressed the file as a whole."""
    name = name.lower()
    ending = next((ending for ending in ENDINGS if name.endswith(ending)), "")
    return name.removesuffix(ending)


def _words(name: str) -> list[str]:
    return re.split(r"(\d+)", name)


def _format(path: Path) -> type[ros1.Ros1Bag] | type[sqlite.Ros2Database] | type[mcap_file.McapFile] | None:
    try:
        with path.open("rb") as file:
            begin = file.read(16)
    except OSError:
        return None
    if begin.startswith(b"#ROSBAG V"):
        return ros1.Ros1Bag
    if begin.startswith(sqlite.MAGIC):
        return sqlite.Ros2Database
    return mcap_file.McapFile if begin.startswith(mcap_file.MAGIC) else None


def _opened(path: Path) -> Container:
    with path.open("rb") as file:
        begin = file.read(16)
    if not begin:
        raise UserError(f"{path} is empty; record it again, or copy it again")
    kind = _format(path)
    if kind is not None:
        return kind(path)
    if is_compressed(begin):
        inner = unpacked_whole(path, begin)
        kind = _format(inner)
        if kind is None:
            raise UserError(f"{path} holds neither a ROS bag, nor a ROS 2 database, nor MCAP")
        return kind(inner)
    if begin.startswith(b"PK"):
        raise UserError(f"{path} is compressed as a whole; unpack it first (unzip)")
    raise UserError(f"{path} is no recording that is known: neither a ROS bag, nor a ROS 2 database, nor MCAP")
