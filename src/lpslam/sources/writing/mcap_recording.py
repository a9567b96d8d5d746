"""An MCAP file, written.

The format: https://mcap.dev/spec
"""

from pathlib import Path
from typing import Protocol

from mcap.writer import CompressionType, Writer

from lpslam.frames import RgbdFrame
from lpslam.sources.writing.pixels import nanoseconds_of


class Messages(Protocol):
    """Frames as messages of some family.

    Attributes:
        profile: of the file, as MCAP's registry names it; empty for none.
        encoding: of the messages.
        schema_encoding: of their schemas.
        schemas: of each topic, the name of its type and its definition.
    """

    profile: str
    encoding: str
    schema_encoding: str
    schemas: dict[str, tuple[str, bytes]]

    def of(self, frame: RgbdFrame, nanoseconds: int) -> list[tuple[str, bytes]]:
        """Topics and bytes of a frame's messages."""
        ...


class McapSink:
    """A `Sink` for an MCAP file: each frame's colour, its depth and the calibration.

    Args:
        path: a new file.
        messages: what is written.
    """

    def __init__(self, path: Path, messages: Messages) -> None:
        self._messages = messages
        self._file = path.open("xb")
        # Pictures are compressed already.
        self._writer = Writer(self._file, compression=CompressionType.NONE)
        self._writer.start(messages.profile, "lpslam")
        self._channels = {}
        for topic, (name, definition) in messages.schemas.items():
            schema = self._writer.register_schema(name, messages.schema_encoding, definition)
            self._channels[topic] = self._writer.register_channel(topic, messages.encoding, schema)

    def add(self, frame: RgbdFrame) -> None:
        """See `Sink`."""
        nanoseconds = nanoseconds_of(frame.timestamp)
        for topic, data in self._messages.of(frame, nanoseconds):
            self._writer.add_message(self._channels[topic], nanoseconds, data, nanoseconds)

    def finish(self) -> None:
        """See `Sink`."""
        self._writer.finish()  # type: ignore[no-untyped-call]

    def close(self) -> None:
        """See `Sink`."""
        self._file.close()
