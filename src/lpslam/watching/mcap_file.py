"""A run as an MCAP file with Foxglove's messages, written while it goes.

The file is written in pieces of a quarter of a megabyte, each whole: what was written before the power failed is read.
"""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from mcap.writer import CompressionType, Writer

from lpslam.camera import PinholeCamera
from lpslam.errors import UserError
from lpslam.frames import RgbdFrame
from lpslam.mapfile.language_map import LanguageMap
from lpslam.session.pace import Pace
from lpslam.session.session import Session
from lpslam.session.step import Step
from lpslam.sources.writing.messages import json_schema
from lpslam.sources.writing.pixels import nanoseconds_of
from lpslam.text.types import Landmark
from lpslam.watching import foxglove
from lpslam.watching.watchers import Taken

TOPICS = {
    "/camera/color/image/compressed": "foxglove.CompressedImage",
    "/camera/color/camera_info": "foxglove.CameraCalibration",
    "/camera/color/boxes": "foxglove.ImageAnnotations",
    "/pose": "foxglove.PoseInFrame",
    "/tf": "foxglove.FrameTransform",
    "/landmarks": "foxglove.SceneUpdate",
    "/way": "foxglove.SceneUpdate",
    "/points": "foxglove.PointCloud",
    "/grid": "foxglove.Grid",
    "/events": "foxglove.Log",
}
_PIECE = 256 << 10
"""Bytes of a chunk: what is lost when the power fails."""
_POINTS = 2.0
"""Seconds between two clouds: each is the whole map."""
_CALIBRATION = 1.0
"""Seconds between two calibrations: who seeks in the file finds one near."""


class McapWatcher:
    """A `Watcher` that writes MCAP.

    Args:
        path: a new file, or one that is replaced.
        camera: of the frames.

    Raises:
        UserError: it cannot be written.
    """

    def __init__(self, path: Path, camera: PinholeCamera) -> None:
        self.name = str(path)
        self._camera = camera
        try:
            self._file = path.open("wb")
        except OSError as error:
            raise UserError(f"{path} cannot be written ({error.strerror}); choose another place") from error
        self._writer = Writer(self._file, chunk_size=_PIECE, compression=CompressionType.ZSTD)
        self._writer.start("", "lpslam")
        self._channels: dict[str, int] = {}
        schemas: dict[str, int] = {}
        for topic, name in TOPICS.items():
            if name not in schemas:
                fields = foxglove.SCHEMAS[name]
                definition = json.dumps(json_schema(name, fields)).encode()
                schemas[name] = self._writer.register_schema(name, "jsonschema", definition)
            self._channels[topic] = self._writer.register_channel(topic, "json", schemas[name])
        self._calibration_pace, self._points_pace = Pace(_CALIBRATION), Pace(_POINTS)
        self._last = 0
        self._marks: dict[int, Landmark] = {}
        self._taken = Taken()

    def take(self, frame: RgbdFrame, step: Step, session: Session) -> None:
        """See `Watcher`."""
        now = self._last = nanoseconds_of(frame.timestamp)
        self._taken.note(step.index, frame.timestamp)
        if self._calibration_pace.is_due(frame.timestamp):
            self._put("/camera/color/camera_info", now, foxglove.calibration(self._camera, now))
        self._put("/camera/color/image/compressed", now, foxglove.image(frame.rgb, now))
        if step.pose is not None:
            self._put("/pose", now, foxglove.pose(step.pose, now))
            self._put("/tf", now, foxglove.transform(step.pose, now))
        for reading in step.readings:
            seen = nanoseconds_of(self._taken.of(reading.frame, frame.timestamp))
            self._put("/camera/color/boxes", now, foxglove.boxes(reading, seen))
        for event in step.events:
            self._put("/events", now, foxglove.event(event, now))
        if step.new_landmarks or step.renamed_landmarks:
            # The session itself would have to wait for a frame that is being read.
            self._marks |= {mark.id: mark for mark in (*step.new_landmarks, *step.renamed_landmarks)}
            self._put_landmarks(list(self._marks.values()))
        if step.tracked.is_keyframe and self._points_pace.is_due(frame.timestamp):
            self._put("/points", now, foxglove.points(session.cloud(), now))
        self._file.flush()

    def finish(self, world: LanguageMap) -> None:
        """See `Watcher`: the map as it is in the end."""
        now = self._last
        self._put_landmarks(world.landmarks())
        self._put("/way", now, foxglove.way(world.frame_poses().positions, now))
        self._put("/points", now, foxglove.points(world.cloud(), now))
        grid = world.grid()
        if grid is not None:
            self._put("/grid", now, foxglove.ground(grid, now))

    def close(self) -> None:
        """See `Watcher`."""
        if self._file.closed:
            return
        try:
            self._writer.finish()  # type: ignore[no-untyped-call]
        finally:
            self._file.close()

    def _put_landmarks(self, marks: Sequence[Landmark]) -> None:
        self._put("/landmarks", self._last, foxglove.landmarks(marks, self._last))

    def _put(self, topic: str, nanoseconds: int, message: dict[str, Any]) -> None:
        data = json.dumps(message, ensure_ascii=False).encode()
        self._writer.add_message(self._channels[topic], nanoseconds, data, nanoseconds)
