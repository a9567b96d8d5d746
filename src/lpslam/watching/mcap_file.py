"""A run as an MCAP file with Foxglove's messages, written while it goes.

The file is written in pieces of a quarter of a megabyte, each whole: what was written before the power failed is read.
"""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from mcap.writer import CompressionType, Writer

from lpslam.camera import PinholeCamera
from lpslam.errors import UserError
from lpslam.frames import RgbdFrame
from lpslam.session.session import Session
from lpslam.session.step import Step
from lpslam.watching.telling import TOPICS, Telling, schema_of

_PIECE = 256 << 10
"""Bytes of a chunk: what is lost when the power fails."""


class McapWatcher(Telling):
    """A `Watcher` that writes MCAP.

    Args:
        path: a new file, or one that is replaced.
        camera: of the frames.

    Raises:
        UserError: it cannot be written.
    """

    def __init__(self, path: Path, camera: PinholeCamera) -> None:
        super().__init__(camera)
        self.name = str(path)
        try:
            self._file = path.open("wb")
        except OSError as error:
            raise UserError(f"{path} cannot be written ({error.strerror}); choose another place") from error
        self._writer = Writer(self._file, chunk_size=_PIECE, compression=CompressionType.ZSTD)
        self._writer.start("", "lpslam")
        self._channels: dict[str, int] = {}
        schemas: dict[str, int] = {}
        for topic in TOPICS:
            name, definition = schema_of(topic)
            if name not in schemas:
                schemas[name] = self._writer.register_schema(name, "jsonschema", definition)
            self._channels[topic] = self._writer.register_channel(topic, "json", schemas[name])

    def take(self, frame: RgbdFrame, step: Step, session: Session) -> None:
        """See `Watcher`."""
        super().take(frame, step, session)
        self._file.flush()

    def close(self) -> None:
        """See `Watcher`."""
        if self._file.closed:
            return
        try:
            self._writer.finish()  # type: ignore[no-untyped-call]
        finally:
            self._file.close()

    def _put(self, topic: str, nanoseconds: int, make: Callable[[], dict[str, Any]]) -> None:
        data = json.dumps(make(), ensure_ascii=False).encode()
        self._writer.add_message(self._channels[topic], nanoseconds, data, nanoseconds)
