"""What a frame's pose is guessed from: the last frame, what optical flow made of it, and points of the map."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lpslam.slam.association import Estimate
from lpslam.slam.features import Features


@dataclass(frozen=True, slots=True, eq=False)
class LastFrame:
    """The last frame with a pose: what the next one is predicted from.

    Attributes:
        gray: (h, w).
        features, points: its keypoints (n rows) and the map point of each, or -1.
        reference, camera_from_reference: its pose, which follows every correction of the map.
    """

    timestamp: float
    gray: NDArray[np.uint8]
    features: Features
    points: NDArray[np.int32]
    reference: int
    camera_from_reference: NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class FirstGuess:
    """A first guess of a view's pose: what its keypoints are known to see, and map points that are near."""

    camera_from_world: NDArray[np.float64]
    points: NDArray[np.int32]
    near: NDArray[np.int32]

    @classmethod
    def of(cls, estimate: Estimate) -> "FirstGuess":
        """From an estimate: its points are known, and others are near them."""
        return cls(estimate.camera_from_world, estimate.points, estimate.points)


@dataclass(frozen=True, slots=True, eq=False)
class Followed:
    """Keypoints that were followed, and the pose that they give in the world of one version of the map."""

    features: Features
    estimate: Estimate
    version: int
