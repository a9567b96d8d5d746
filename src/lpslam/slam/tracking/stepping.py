"""The step from the last frame to the next as whole pictures tell it, where blur may spoil corners."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import inverse_transform
from lpslam.config import PictureConfig
from lpslam.frames import RgbdFrame
from lpslam.slam.kernels.geometry import logarithm
from lpslam.slam.map import SlamMap
from lpslam.slam.tracking.guesses import LastFrame
from lpslam.slam.tracking.surfaces import Surfaces

_Matrix = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Step:
    """From the last frame to the next.

    Attributes:
        last, next: timestamps, seconds.
        image_from_last: 4×4.
        information: (6, 6) of a twist (translation, rotation vector) from the left, as far as it is believed.
    """

    last: float
    next: float
    image_from_last: _Matrix
    information: _Matrix

    def leads(self, last: float, timestamp: float) -> bool:
        """Whether it is the step from one time to the other."""
        return self.last == last and self.next == timestamp


class Stepping:
    """Aligns frames with the ones before them as whole pictures.

    A corner that moves while it is exposed becomes a streak, and lies anywhere on it: that every pixel moves alike
    tells the step several times better. How far this is believed the map's keyframes say (`RelativePoses.excess`).

    Args:
        slam_map: knows that.
        surfaces: aligns small pictures.
        config: thresholds.
    """

    def __init__(self, slam_map: SlamMap, surfaces: Surfaces, config: PictureConfig) -> None:
        self._map = slam_map
        self._surfaces = surfaces
        self._config = config
        self._newest: tuple[float, NDArray[np.float32]] | None = None

    def told(self, last: LastFrame, frame: RgbdFrame, gray: NDArray[np.uint8], expected: _Matrix) -> Step | None:
        """The step to a frame with its grey values (h, w), near an expected one (4×4); None where pictures fail."""
        with self._map.lock:
            excess = self._map.relative_poses.excess
        if not self._config.enabled or excess >= self._config.largest_excess:
            return None
        images, newest = self._surfaces.images, self._newest
        is_known = newest is not None and newest[0] == last.timestamp
        reference = newest[1] if newest is not None and is_known else images.reference(last.gray, last.depth)
        image = images.reference(gray, frame.depth)
        self._newest = frame.timestamp, image
        seconds = frame.timestamp - last.timestamp
        aligned = self._surfaces.align(reference, image, expected, seconds)
        if aligned is None or not aligned.holds:
            return None
        surprise = logarithm(aligned.image_from_reference @ inverse_transform(expected))
        if (np.abs(surprise) > self._config.most_surprise * self._surfaces.guess_sigmas(seconds)).any():
            # Somebody who walks by takes the picture along; the camera cannot have changed its way so much.
            return None
        return Step(last.timestamp, frame.timestamp, aligned.image_from_reference, aligned.information / excess)
