"""The camera's way since the last frame with a place in the map, as surfaces, shades and corners tell it."""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import inverse_transform
from lpslam.slam.kernels.geometry import exponential, logarithm, orthonormalise
from lpslam.slam.tracking.guesses import LastFrame
from lpslam.slam.tracking.motion import FARTHEST_AHEAD, ConstantVelocity
from lpslam.slam.tracking.picture import Picture
from lpslam.slam.tracking.surfaces import Aligned, Surfaces
from lpslam.slam.tracking.turning import Glance, Turning

_Matrix = NDArray[np.float64]


class Told(IntEnum):
    """How much of the camera's way is told, and not guessed from its motion before."""

    NOTHING = 0
    TURN = 1
    WAY = 2


@dataclass(frozen=True, slots=True)
class Doubtful:
    """What is not told of the way since the last frame with a place.

    Attributes:
        metres: by which the position may be wrong, since only the motion says how the camera stepped.
        seconds: in which only the motion says how it turned as well.
    """

    metres: float = 0.0
    seconds: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class _Sight:
    """A small image (2, h, w) whose pose was told, its pose (4×4, image from reference), and how doubtful it is."""

    image: NDArray[np.float32]
    from_reference: _Matrix
    doubtful: Doubtful


class CarryingOn:
    """Follows the camera frame by frame against a reference image, which is renewed when it leaves the view.

    Args:
        surfaces: aligns images.
        turning: finds turns from corners.
        motion: how the camera has moved while the map told it.
        renewed_share: of the reference in view; less, and the next image is taken for it.

    Attributes:
        told: how the newest frame has got its pose.
        doubtful: what is not told of the way to it.
    """

    def __init__(self, surfaces: Surfaces, turning: Turning, motion: ConstantVelocity, renewed_share: float) -> None:
        self._surfaces = surfaces
        self._turning = turning
        self._motion = motion
        self._renewed_share = renewed_share
        self._from: LastFrame | None = None
        self._before: Glance | None = None
        self._timestamp = self._told_at = 0.0
        self._reference = self._newest = _Sight(_NOTHING, np.eye(4), Doubtful())
        self._reference_from_keyframe = np.eye(4)
        self._image_from_reference = np.eye(4)
        self._newest_image = _NOTHING
        self._twist = np.zeros(6)
        self.told = Told.NOTHING
        self.doubtful = Doubtful()

    def is_told(self, within: Doubtful) -> bool:
        """Whether the way since the last frame with a place is told, all but so much of it."""
        return self.told is Told.WAY and self.is_turn_told(within) and self.doubtful.metres <= within.metres

    def is_turn_told(self, within: Doubtful) -> bool:
        """Whether the turn since then is told, all but so much of it."""
        return self.doubtful.seconds <= within.seconds

    def follow(self, last: LastFrame, picture: Picture) -> _Matrix:
        """The pose of the next frame (4×4, camera from the reference keyframe of `last`, the last with a place).

        Where nothing tells it, the camera goes on as it did; an image from before may tell it again.
        """
        if self._from is not last:
            self._begin(last)
        seconds = max(picture.timestamp - self._timestamp, 0.0)
        image = self._surfaces.images.reference(picture.gray, picture.frame.depth)
        step = self._step(seconds)
        guess, aligned = self._aligned(image, step, picture.timestamp)
        glance, before, moved = self._turning.glance(picture.gray, picture.frame.depth), self._before, None
        if before is not None and (aligned is None or not aligned.holds):
            moved = self._turning.told(before, glance, step, picture.timestamp - self._told_at)
        pose, self.told = guess, Told.NOTHING
        is_aligned = aligned is not None and aligned.holds
        if aligned is not None and (is_aligned or moved is None):
            pose, self.told = aligned.image_from_reference, Told.WAY if is_aligned else Told.TURN
        elif moved is not None:
            pose = moved.motion @ self._image_from_reference
            self.told = Told.WAY if moved.is_step_told else Told.TURN
        # Else what rounding adds to a rotation doubles with every renewal.
        pose = pose.copy()
        orthonormalise(pose)
        since = picture.timestamp - self._told_at
        if self.told and since > 0.0:
            # From the last pose that was told: what was guessed since would look like a jump.
            twist = logarithm(pose @ inverse_transform(self._newest.from_reference)) / since
            self._twist += (1.0 - np.exp(-since / _SETTLING)) * (twist - self._twist)
        if self.told is not Told.WAY:
            # What nothing tells comes to rest.
            self._twist *= np.exp(-seconds / _COMING_TO_REST)
        self._image_from_reference, self._timestamp = pose, picture.timestamp
        self._before, self._newest_image = glance, image
        self._doubt(seconds, is_aligned)
        if self.told:
            self._newest, self._told_at = _Sight(image, pose, self.doubtful), picture.timestamp
            if not is_aligned or aligned is None or aligned.shared < self._renewed_share:
                self._renew()
        camera_from_keyframe: _Matrix = self._image_from_reference @ self._reference_from_keyframe
        return camera_from_keyframe

    def mend(self, camera_from_keyframe: _Matrix) -> None:
        """Take another pose (4×4) for the newest frame's, by which the map has it where its depth shows."""
        orthonormalise(self._reference_from_keyframe)
        pose = camera_from_keyframe @ inverse_transform(self._reference_from_keyframe)
        orthonormalise(pose)
        self._newest = _Sight(self._newest_image, pose, self.doubtful)
        self._image_from_reference, self._told_at = pose, self._timestamp
        self._renew()

    def _aligned(self, image: NDArray[np.float32], step: _Matrix, timestamp: float) -> tuple[_Matrix, Aligned | None]:
        """Where an image is expected (4×4, image from reference), and how it lies there if that tells its turn."""
        seconds = timestamp - self._told_at
        guess = step @ self._image_from_reference
        aligned = self._surfaces.align(self._reference.image, image, guess, seconds, self._image_from_reference)
        if (aligned is None or not aligned.holds) and self._newest is not self._reference:
            # What the reference tells no more, the image before may.
            self._renew()
            guess = step @ self._image_from_reference
            aligned = self._surfaces.align(self._reference.image, image, guess, seconds, self._image_from_reference)
        return guess, aligned if aligned is not None and aligned.tells_turn else None

    def _doubt(self, seconds: float, is_aligned: bool) -> None:
        """Say how doubtful the way is after a step of so many seconds, aligned with the reference or not."""
        if self.told is Told.WAY:
            self.doubtful = self._reference.doubtful if is_aligned else self.doubtful
            return
        speed = max(float(np.linalg.norm(self._twist[:3])), _LEAST_SPEED)
        untold = seconds if self.told is Told.NOTHING else 0.0
        self.doubtful = Doubtful(self.doubtful.metres + speed * seconds, self.doubtful.seconds + untold)

    def _renew(self) -> None:
        """Take the newest image whose pose was told for the reference."""
        newest = self._newest
        self._reference_from_keyframe = newest.from_reference @ self._reference_from_keyframe
        self._image_from_reference = self._image_from_reference @ inverse_transform(newest.from_reference)
        self._reference = self._newest = _Sight(newest.image, np.eye(4), newest.doubtful)

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
        self._from, self._timestamp, self._told_at = last, last.timestamp, last.timestamp
        self._before, self.doubtful = self._turning.glance(last.gray, last.depth), Doubtful()
        image = self._surfaces.images.reference(last.gray, last.depth)
        self._reference = self._newest = _Sight(image, np.eye(4), self.doubtful)
        self._reference_from_keyframe, self._image_from_reference = last.camera_from_reference.copy(), np.eye(4)
        self._twist = np.zeros(6) if self._motion.twist is None else self._motion.twist.copy()


_NOTHING = np.empty((2, 0, 0), np.float32)

_SETTLING = 0.05
"""Seconds over which the camera's motion is averaged."""

_COMING_TO_REST = 0.3
"""Seconds in which a camera's motion fades that nothing tells: as long as a hand or a wheel keeps its way."""

_LEAST_SPEED = 0.05
"""Metres a second by which a camera that stood may move unseen: a hand's sway."""
