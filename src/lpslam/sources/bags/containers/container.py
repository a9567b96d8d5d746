"""What every file of timed messages offers: its topics, and their messages in order of time as they are read."""

import logging
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path
from typing import Protocol

logger = logging.getLogger(__name__)

_LARGE = 10**9
"""Bytes that are read in more than a moment."""


class Encoding(Enum):
    """How a message's bytes are laid out."""

    ROS1 = "ros1"
    CDR = "cdr"
    JSON = "json"
    UNKNOWN = "unknown"


@dataclass(frozen=True, slots=True)
class Topic:
    """A named series of messages of one type.

    Attributes:
        name: as recorded, beginning with a slash.
        type: package/msg/Name, as ROS 2 writes it.
        encoding: of its messages.
    """

    name: str
    type: str
    encoding: Encoding


@dataclass(frozen=True, slots=True)
class Message:
    """One message as it lies in the file.

    Attributes:
        topic: its series.
        logged: nanoseconds, when it was recorded; the message's own stamp is inside.
        data: its bytes.
    """

    topic: Topic
    logged: int
    data: bytes


class Container(Protocol):
    """A file of timed messages. Every call opens the file anew, so that any thread may read."""

    path: Path
    topics: tuple[Topic, ...]

    @property
    def damages(self) -> "list[Damage]":
        """Of each of its files."""
        ...

    def messages(self, names: Collection[str], start: int | None = None, end: int | None = None) -> Iterator[Message]:
        """The messages of some topics in the order of the recording, as far as the file can be read.

        Args:
            names: of the topics.
            start, end: nanoseconds of `Message.logged`; the end is left out.
        """
        ...

    def times(self, name: str) -> list[int]:
        """When each message of a topic was recorded, nanoseconds, in order; without reading the messages."""
        ...


@dataclass(slots=True)
class Damage:
    """Where a file ends too early or cannot be read on; said once, and not before it is known that it can be used.

    Attributes:
        path: of the file.
        texts: what was found, in order.
    """

    path: Path
    texts: list[str] = field(default_factory=list)
    _is_heard: bool = False

    def note(self, text: str) -> None:
        """Remember it, and say it if the file is in use; it is used as far as it goes."""
        if text not in self.texts:
            self.texts.append(text)
            if self._is_heard:
                self._say(text)

    def say(self) -> None:
        """Say what was found, and from now on what is found."""
        self._is_heard = True
        for text in self.texts:
            self._say(text)

    def _say(self, text: str) -> None:
        logger.warning("%s: %s; what is before it is used", self.path.name, text)


def say_before_a_pass(path: Path) -> None:
    """Say that a large file is read through once, which takes a while, to be known as one with an index is at once."""
    size = path.stat().st_size
    if size > _LARGE:
        logger.warning("%s: it has no index; its %.1f GB are read through first", path.name, size / 1e9)


def ros2_type(name: str) -> str:
    """A message type as ROS 2 writes it: sensor_msgs/Image is sensor_msgs/msg/Image."""
    parts = name.replace("::", "/").replace("/msg/dds_/", "/msg/").rstrip("_").split("/")
    return "/".join((parts[0], "msg", parts[-1])) if len(parts) == 2 else "/".join(parts)
