"""What the frames before say about the next one: where it will be, and how sharp it should be."""

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.camera import inverse_transform
from lpslam.frames import RgbdFrame
from lpslam.slam.kernels.geometry import exponential, logarithm, orthonormalise

_Matrix = NDArray[np.float64]

_FARTHEST_AHEAD = 0.3
"""Seconds for which constant velocity is believed, after which it is a guess."""

_SHARPNESS_RATE = 0.03
"""Share of its difference by which a frame changes the usual sharpness: a second's worth, longer than a jerk."""

_DARK = 0.7
"""Share of the usual brightness below which missing sharpness is the light's fault: half of it is left then."""


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
        ahead = min(max(seconds, 0.0), _FARTHEST_AHEAD)
        predicted: _Matrix = exponential(self._velocity * ahead) @ camera_from_world
        orthonormalise(predicted)
        return predicted


def velocity(before: _Matrix, now: _Matrix, seconds: float) -> _Matrix:
    """(6,) twist a second between two poses, camera from world (4×4), so many seconds apart."""
    twist: _Matrix = logarithm(now @ inverse_transform(before)) / seconds
    return twist


class UsualSharpness:
    """How sharp frames are here, slowly forgotten: by which a blurred one is known."""

    def __init__(self) -> None:
        self._usual = 0.0
        self._brightness = 0.0

    def begin(self, frame: RgbdFrame) -> None:
        """Take a first frame for the measure."""
        self._usual, self._brightness = _sharpness(frame), _brightness(frame)

    def share(self, frame: RgbdFrame) -> float:
        """Sharpness of a frame as a share of the usual one; 1 where that is not known yet."""
        return _sharpness(frame) / self._usual if self._usual else 1.0

    def note(self, frame: RgbdFrame) -> float:
        """Take a frame that was tracked, and return its share."""
        if not self._usual:
            # Where a saved map goes on, its first frame is the only measure.
            self.begin(frame)
        share = self.share(frame)
        self._usual *= 1.0 + (share - 1.0) * _SHARPNESS_RATE
        self._brightness += (_brightness(frame) - self._brightness) * _SHARPNESS_RATE
        return share

    def fault(self, frame: RgbdFrame) -> str:
        """In words why a frame is less sharp than usual: it is blurred, unless it is dark."""
        why = "dark or blurred" if _brightness(frame) < _DARK * self._brightness else "blurred"
        return f"{why} (sharpness {self.share(frame):.0%} of the usual)"


def _sharpness(frame: RgbdFrame) -> float:
    """Mean squared difference of neighbouring grey values at half resolution; falls with blur."""
    green = frame.rgb[::2, ::2, 1]
    return float(np.square(cv2.subtract(green[:, 1:], green[:, :-1]), dtype=np.float32).mean())


def _brightness(frame: RgbdFrame) -> float:
    return float(frame.rgb[::8, ::8, 1].mean())
