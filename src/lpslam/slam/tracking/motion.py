"""The motion model: where the frames before say that the next one will be."""

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import inverse_transform
from lpslam.slam.kernels.geometry import exponential, logarithm, orthonormalise

_Matrix = NDArray[np.float64]

FARTHEST_AHEAD = 0.3
"""Seconds for which constant velocity is believed, after which it is a guess."""


class ConstantVelocity:
    """The motion model: the camera goes on as it did from the last frame but one to the last (ORB-SLAM, V-B)."""

    def __init__(self) -> None:
        self._velocity: _Matrix | None = None

    @property
    def is_known(self) -> bool:
        """Whether two frames in a row had poses."""
        return self._velocity is not None

    @property
    def twist(self) -> _Matrix | None:
        """(6,) of the world in the camera frame, a second; None while it is not known."""
        return self._velocity

    def forget(self) -> None:
        """The camera was lost."""
        self._velocity = None

    def note(self, before: _Matrix, now: _Matrix, seconds: float) -> None:
        """Take the camera from world (4×4) of two frames, as the map has them now, so many seconds apart."""
        self._velocity = velocity(before, now, seconds)

    def ahead(self, camera_from_world: _Matrix, seconds: float) -> _Matrix:
        """Camera from world so many seconds after a pose, also over frames that are missing."""
        if self._velocity is None:
            return camera_from_world
        ahead = min(max(seconds, 0.0), FARTHEST_AHEAD)
        predicted: _Matrix = exponential(self._velocity * ahead) @ camera_from_world
        orthonormalise(predicted)
        return predicted


def velocity(before: _Matrix, now: _Matrix, seconds: float) -> _Matrix:
    """(6,) twist a second between two poses, camera from world (4×4), so many seconds apart."""
    twist: _Matrix = logarithm(now @ inverse_transform(before)) / seconds
    return twist
