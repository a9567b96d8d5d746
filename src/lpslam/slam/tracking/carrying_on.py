"""The camera's way since the last frame with a place in the map, as surfaces and shades tell it."""

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import inverse_transform
from lpslam.slam.kernels.geometry import exponential, logarithm
from lpslam.slam.tracking.guesses import LastFrame
from lpslam.slam.tracking.motion import FARTHEST_AHEAD, ConstantVelocity
from lpslam.slam.tracking.picture import Picture
from lpslam.slam.tracking.surfaces import Surfaces

_Matrix = NDArray[np.float64]


class CarryingOn:
    """Follows the camera frame by frame against a reference image, which is renewed when it leaves the view.

    Args:
        surfaces: aligns images.
        motion: how the camera has moved while the map told it.
        renewed_share: of the reference in view; less, and the next image is taken for it.
    """

    def __init__(self, surfaces: Surfaces, motion: ConstantVelocity, renewed_share: float) -> None:
        self._surfaces = surfaces
        self._motion = motion
        self._renewed_share = renewed_share
        self._from: LastFrame | None = None
        self._timestamp = 0.0
        self._reference = self._newest = _NOTHING
        self._shared = 1.0
        self._reference_from_keyframe = np.eye(4)
        self._image_from_reference = np.eye(4)
        self._twist = np.zeros(6)
        self.is_held = False

    def follow(self, last: LastFrame, picture: Picture) -> _Matrix:
        """The pose of the next frame (4×4, camera from the reference keyframe of `last`, the last with a place).

        Where the images do not tell it, the camera goes on as it did; `is_held` until that has happened.
        """
        if self._from is not last:
            self._begin(last)
        seconds = picture.timestamp - self._timestamp
        step = self._step(seconds)
        pose = self._told(picture, step, seconds) if self.is_held else None
        self.is_held = pose is not None
        if pose is None:
            pose = step @ self._image_from_reference
        elif seconds > 0.0:
            self._twist = logarithm(pose @ inverse_transform(self._image_from_reference)) / seconds
        self._image_from_reference, self._timestamp = pose, picture.timestamp
        if self._shared < self._renewed_share:
            self._renew(self._newest)
        camera_from_keyframe: _Matrix = self._image_from_reference @ self._reference_from_keyframe
        return camera_from_keyframe

    def _told(self, picture: Picture, step: _Matrix, seconds: float) -> _Matrix | None:
        """The pose (4×4, image from reference) if the images hold; `step` is the camera's as it is expected."""
        image = self._surfaces.images.reference(picture.gray, picture.frame.depth)
        aligned = self._surfaces.align(self._reference, image, step @ self._image_from_reference, seconds)
        if (aligned is None or not aligned.holds) and self._newest is not self._reference:
            # What the reference tells no more, the image before may.
            self._renew(self._newest)
            aligned = self._surfaces.align(self._reference, image, step, seconds)
        if aligned is None or not aligned.holds:
            return None
        self._newest, self._shared = image, aligned.shared
        return aligned.image_from_reference

    def _renew(self, image: NDArray[np.float32]) -> None:
        """Take the image at the newest pose for the reference."""
        self._reference_from_keyframe = self._image_from_reference @ self._reference_from_keyframe
        self._reference, self._image_from_reference, self._shared = image, np.eye(4), 1.0

    def ahead(self, last: LastFrame, timestamp: float) -> _Matrix | None:
        """Where a frame should be (4×4, as above) if the camera goes on as it did; None before the first step."""
        if self._from is not last:
            return None
        step = self._step(timestamp - self._timestamp)
        ahead: _Matrix = step @ self._image_from_reference @ self._reference_from_keyframe
        return ahead

    def _step(self, seconds: float) -> _Matrix:
        """How the camera moves (4×4) in so many seconds, if it goes on as it did."""
        step: _Matrix = exponential(self._twist * min(max(seconds, 0.0), FARTHEST_AHEAD))
        return step

    def _begin(self, last: LastFrame) -> None:
        self._from, self._timestamp, self.is_held = last, last.timestamp, True
        self._shared = 1.0
        self._reference = self._newest = self._surfaces.images.reference(last.gray, last.depth)
        self._reference_from_keyframe, self._image_from_reference = last.camera_from_reference, np.eye(4)
        self._twist = np.zeros(6) if self._motion.twist is None else self._motion.twist


_NOTHING = np.empty((2, 0, 0), np.float32)
