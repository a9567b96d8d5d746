"""What a frame with a pose leaves to the next one: itself, and the camera's velocity."""

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import inverse_transform
from lpslam.slam.association import Estimate
from lpslam.slam.shutter.revising import EarlyFrames
from lpslam.slam.shutter.straightening import RollingShutter
from lpslam.slam.tracking.anchoring import Anchoring
from lpslam.slam.tracking.delay_watch import DelayWatch
from lpslam.slam.tracking.guesses import LastFrame
from lpslam.slam.tracking.guessing import Guesser
from lpslam.slam.tracking.picture import Picture
from lpslam.slam.tracking.whereabouts import Whereabouts

_Matrix = NDArray[np.float64]


class MovingOn:
    """Tells all who follow the camera's motion of each frame with a pose.

    Args:
        where: the camera is; gets the frame as its last.
        guesser: knows which frames tell a velocity.
        anchoring, shutter, early_frames, delay: told of the frame.
    """

    def __init__(
        self,
        where: Whereabouts,
        guesser: Guesser,
        anchoring: Anchoring,
        shutter: RollingShutter,
        early_frames: EarlyFrames,
        delay: DelayWatch,
    ) -> None:
        self._where = where
        self._guesser = guesser
        self._anchoring = anchoring
        self._shutter = shutter
        self._early_frames = early_frames
        self._delay = delay

    def keep(self, picture: Picture, estimate: Estimate, *, is_matched: bool, is_keyframe: bool) -> _Matrix:
        """Keep a frame as the one that the next is predicted from.

        Args:
            picture, estimate: of the frame.
            is_matched: whether its pose comes from a match with the map that is sure.
            is_keyframe: whether it is the reference.

        Returns:
            4×4, the camera in the reference keyframe's frame.
        """
        where = self._where
        twist = self._moved(picture, estimate.camera_from_world)
        reference_from_world = where.map.camera_from_world(where.reference)
        keyframe_from_camera: _Matrix = reference_from_world @ inverse_transform(estimate.camera_from_world)
        where.last = LastFrame(
            picture.timestamp,
            picture.gray,
            picture.frame.depth,
            picture.features,
            picture.seen,
            estimate.points,
            where.reference,
            inverse_transform(keyframe_from_camera),
        )
        self._shutter.note(where.last, twist, is_matched, is_keyframe)
        self._early_frames.keep(picture.frame.index, where.last, is_keyframe)
        if is_matched and twist is not None:
            self._delay.note(picture, estimate, twist)
        return keyframe_from_camera

    def _moved(self, picture: Picture, camera_from_world: _Matrix) -> _Matrix | None:
        """Take the way from the last frame; the (6,) velocity a second, if the last frame is near enough to tell it."""
        where, last = self._where, self._where.last
        if last is None or picture.timestamp <= last.timestamp:
            return None
        before, predicted = self._guesser.pose(last), self._guesser.predicted(last, picture.timestamp)
        seconds = picture.timestamp - last.timestamp
        self._anchoring.moved(before, camera_from_world, predicted, seconds)
        where.motion.note(before, camera_from_world, seconds)
        return where.motion.twist if self._guesser.tells_velocity(last, picture.frame) else None
