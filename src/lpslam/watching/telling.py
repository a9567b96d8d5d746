"""A run told in Foxglove's messages, whoever takes them: a file, or programs that are connected."""

import json
from abc import ABC, abstractmethod
from collections.abc import Callable
from functools import partial
from typing import Any

from lpslam.camera import PinholeCamera
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
_POINTS = 2.0
"""Seconds between two clouds: each is the whole map."""
_CALIBRATION = 1.0
"""Seconds between two calibrations: who seeks in the file finds one near."""


class Telling(ABC):
    """A `Watcher` but for where its messages go.

    Args:
        camera: of the frames.
    """

    def __init__(self, camera: PinholeCamera) -> None:
        self._camera = camera
        self._calibration_pace, self._points_pace = Pace(_CALIBRATION), Pace(_POINTS)
        self._last = 0
        self._marks: dict[int, Landmark] = {}
        self._taken = Taken()

    @abstractmethod
    def _put(self, topic: str, nanoseconds: int, make: Callable[[], dict[str, Any]]) -> None:
        """Take a message of a topic; it need not be made where nobody wants it."""

    def _is_asked_for(self, topic: str) -> bool:
        """Whether somebody new waits for the newest message of a topic that is told seldom."""
        return False

    def take(self, frame: RgbdFrame, step: Step, session: Session) -> None:
        """See `Watcher`."""
        now = self._last = nanoseconds_of(frame.timestamp)
        self._taken.note(step.index, frame.timestamp)
        if self._is_asked_for("/camera/color/camera_info") or self._calibration_pace.is_due(frame.timestamp):
            self._put("/camera/color/camera_info", now, lambda: foxglove.calibration(self._camera, now))
        self._put("/camera/color/image/compressed", now, lambda: foxglove.image(frame.rgb, now))
        self._put_step(step, frame.timestamp)
        if step.new_landmarks or step.renamed_landmarks or self._is_asked_for("/landmarks"):
            # The session itself would have to wait for a frame that is being read.
            self._marks |= {mark.id: mark for mark in (*step.new_landmarks, *step.renamed_landmarks)}
            marks = list(self._marks.values())
            self._put("/landmarks", now, lambda: foxglove.landmarks(marks, now))
        is_due = step.tracked.is_keyframe and self._points_pace.is_due(frame.timestamp)
        if is_due or self._is_asked_for("/points"):
            self._put("/points", now, lambda: foxglove.points(session.cloud(), now))

    def _put_step(self, step: Step, timestamp: float) -> None:
        now, pose = self._last, step.pose
        if pose is not None:
            self._put("/pose", now, lambda: foxglove.pose(pose, now))
            self._put("/tf", now, lambda: foxglove.transform(pose, now))
        for reading in step.readings:
            seen = nanoseconds_of(self._taken.of(reading.frame, timestamp))
            self._put("/camera/color/boxes", now, partial(foxglove.boxes, reading, seen))
        for event in step.events:
            self._put("/events", now, partial(foxglove.event, event, now))

    def finish(self, world: LanguageMap) -> None:
        """See `Watcher`: the map as it is in the end."""
        now, grid = self._last, world.grid()
        self._put("/landmarks", now, lambda: foxglove.landmarks(world.landmarks(), now))
        self._put("/way", now, lambda: foxglove.way(world.frame_poses().positions, now))
        self._put("/points", now, lambda: foxglove.points(world.cloud(), now))
        if grid is not None:
            self._put("/grid", now, lambda: foxglove.ground(grid, now))


def schema_of(topic: str) -> tuple[str, bytes]:
    """The name of a topic's schema, and the schema."""
    name = TOPICS[topic]
    return name, json.dumps(json_schema(name, foxglove.SCHEMAS[name])).encode()
