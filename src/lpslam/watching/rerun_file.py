"""A run as a file of Rerun's viewer, written while it goes.

Only the next version of Rerun promises to read it: it is to look at, and no archive.
"""

from pathlib import Path

import numpy as np
import rerun as rr
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from lpslam.camera import PinholeCamera
from lpslam.errors import UserError
from lpslam.frames import RgbdFrame
from lpslam.language.sanitise import clean_text
from lpslam.mapfile.board_poses import board_colour, board_pose, board_size, placed
from lpslam.mapfile.language_map import LanguageMap
from lpslam.session.pace import Pace
from lpslam.session.session import Session
from lpslam.session.step import Step
from lpslam.sources.writing.pixels import packed
from lpslam.text.types import FrameReading, Landmark
from lpslam.watching.foxglove import FATE_COLOURS
from lpslam.watching.watchers import Taken

CLOCK = "seconds"
_POINTS = 2.0
"""Seconds between two clouds: each is the whole map."""


class RerunWatcher:
    """A `Watcher` that writes Rerun's format.

    Args:
        path: a new file, or one that is replaced.
        camera: of the frames.
        name: of the recording.

    Raises:
        UserError: it cannot be written.
    """

    def __init__(self, path: Path, camera: PinholeCamera, name: str = "lpslam") -> None:
        self.name = str(path)
        try:
            # Rerun writes in a thread of its own, which tells nobody when it cannot.
            path.open("wb").close()
        except OSError as error:
            raise UserError(f"{path} cannot be written ({error.strerror}); choose another place") from error
        self._stream = rr.RecordingStream("lpslam")
        self._stream.save(path)
        self._stream.send_recording_name(clean_text(name) or "lpslam")
        self._points_pace, self._taken = Pace(_POINTS), Taken()
        self._marks: dict[int, Landmark] = {}
        self._stream.log("map", rr.ViewCoordinates.FLU, static=True)
        pinhole = rr.Pinhole(
            image_from_camera=camera.matrix,
            width=camera.width,
            height=camera.height,
            camera_xyz=rr.ViewCoordinates.RDF,
        )
        self._stream.log("map/camera/image", pinhole, static=True)

    def take(self, frame: RgbdFrame, step: Step, session: Session) -> None:
        """See `Watcher`."""
        stream = self._stream
        self._taken.note(step.index, frame.timestamp)
        for reading in step.readings:
            self._set_time(self._taken.of(reading.frame, frame.timestamp))
            self._log_boxes(reading)
        self._set_time(frame.timestamp)
        contents = packed(".jpg", frame.rgb[:, :, ::-1])
        stream.log("map/camera/image", rr.EncodedImage(contents=contents, media_type="image/jpeg"))
        stream.log("tracking/matches", rr.Scalars([float(step.tracked.matches)]))
        if step.pose is not None:
            pose = step.pose
            stream.log("map/camera", rr.Transform3D(translation=pose[:3, 3], mat3x3=pose[:3, :3]))
        for event in step.events:
            stream.log("tracking/events", rr.TextLog(clean_text(f"{event.kind}: {event.reason}"), level="INFO"))
        if step.new_landmarks or step.renamed_landmarks:
            # The session itself would have to wait for a frame that is being read.
            self._marks |= {mark.id: mark for mark in (*step.new_landmarks, *step.renamed_landmarks)}
            self._log_landmarks(list(self._marks.values()))
        if step.tracked.is_keyframe and self._points_pace.is_due(frame.timestamp):
            stream.log("map/points", rr.Points3D(session.cloud().astype(np.float32), radii=0.01))

    def finish(self, world: LanguageMap) -> None:
        """See `Watcher`: the map as it is in the end."""
        positions = world.frame_poses().positions
        positions = positions[np.isfinite(positions).all(axis=1)].astype(np.float32)
        if len(positions):
            self._stream.log("map/way", rr.LineStrips3D([positions], colors=[(50, 180, 80)]))
        self._stream.log("map/points", rr.Points3D(world.cloud().astype(np.float32), radii=0.01))
        self._log_landmarks(world.landmarks())

    def close(self) -> None:
        """See `Watcher`."""
        self._stream.flush()
        self._stream.disconnect()

    def _set_time(self, seconds: float) -> None:
        self._stream.set_time(CLOCK, duration=seconds)

    def _log_boxes(self, reading: FrameReading) -> None:
        """Boxes with their fates, and what was read in those that were kept."""
        outlines = [np.vstack([box, box[:1]]).astype(np.float32) for box in reading.boxes]
        colours = [tuple(round(255 * part) for part in FATE_COLOURS[fate]) for fate in reading.fates]
        labels = [str(fate) for fate in reading.fates]
        self._stream.log(
            "map/camera/image/boxes", rr.LineStrips2D(outlines, colors=colours, labels=labels, show_labels=False)
        )
        corners = reading.texts.boxes[:, 0].astype(np.float32)
        told = [clean_text(spelling) for spelling in reading.texts.spellings]
        self._stream.log("map/camera/image/texts", rr.Points2D(corners, labels=told, show_labels=True))

    def _log_landmarks(self, marks: list[Landmark]) -> None:
        shown = placed(marks)
        poses = [board_pose(mark) for mark in shown]
        boxes = rr.Boxes3D(
            centers=np.array([pose[:3, 3] for pose in poses]).reshape(-1, 3),
            sizes=np.array([board_size(mark) for mark in shown]).reshape(-1, 3),
            quaternions=[rr.Quaternion(xyzw=_quaternion(pose)) for pose in poses],
            colors=[tuple(round(255 * part) for part in board_colour(mark)) for mark in shown],
            labels=[clean_text(mark.name) for mark in shown],
        )
        self._stream.log("map/landmarks", boxes)


def _quaternion(pose: NDArray[np.float64]) -> list[float]:
    return [float(part) for part in Rotation.from_matrix(pose[:3, :3]).as_quat()]
