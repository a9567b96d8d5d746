"""What a frame's pose is guessed from: the last frame, what optical flow made of it, and points of the map."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lpslam.slam.association import Estimate
from lpslam.slam.features import Features
from lpslam.slam.map import SlamMap


@dataclass(frozen=True, slots=True, eq=False)
class LastFrame:
    """The last frame with a pose: what the next one is predicted from.

    Attributes:
        gray, depth: (h, w), the depth in metres.
        features: its keypoints (n rows), straightened.
        seen: the same as they are in the image.
        points: the map point of each, or -1.
        reference, camera_from_reference: its pose, which follows every correction of the map.
    """

    timestamp: float
    gray: NDArray[np.uint8]
    depth: NDArray[np.float32]
    features: Features
    seen: Features
    points: NDArray[np.int32]
    reference: int
    camera_from_reference: NDArray[np.float64]

    def camera_from_world(self, slam_map: SlamMap) -> NDArray[np.float64]:
        """4×4 pose as the map has it now."""
        pose: NDArray[np.float64] = self.camera_from_reference @ slam_map.camera_from_world(self.reference)
        return pose


def without_images(frame: LastFrame) -> LastFrame:
    """A frame that is kept for its keypoints."""
    return replace(frame, gray=np.empty((0, 0), np.uint8), depth=np.empty((0, 0), np.float32))


@dataclass(frozen=True, slots=True, eq=False)
class FirstGuess:
    """A first guess of a view's pose: what its keypoints are known to see, and map points nearby.

    Attributes:
        agreement: share of what led to the pose that agrees with it.
        loose: (n, 4) as in `Estimate`.
    """

    camera_from_world: NDArray[np.float64]
    points: NDArray[np.int32]
    nearby: NDArray[np.int32]
    agreement: float = 1.0
    loose: NDArray[np.float64] | None = None

    @classmethod
    def of(cls, estimate: Estimate) -> "FirstGuess":
        """From an estimate: its points are known, and others are near them."""
        return cls(estimate.camera_from_world, estimate.points, estimate.points, estimate.agreement, estimate.loose)

    @classmethod
    def at(cls, camera_from_world: NDArray[np.float64], rows: int, nearby: NDArray[np.int32]) -> "FirstGuess":
        """A pose without a match: of so many rows none is known yet."""
        return cls(camera_from_world, np.full(rows, -1, np.int32), nearby)

    @classmethod
    def near(cls, estimate: Estimate, rows: int) -> "FirstGuess":
        """From an estimate by other keypoints: of these rows none is known yet."""
        nothing = np.full(rows, -1, np.int32)
        return cls(estimate.camera_from_world, nothing, estimate.points, estimate.agreement)


@dataclass(frozen=True, slots=True, eq=False)
class Sighted:
    """Keypoints of the last frame whose place is known, m of them.

    Attributes:
        rows: (m,) of its keypoints.
        points: (m,) ids of map points, or -1.
        positions: (m, 3) world frame.
        spread: (m,) pixels² by which their projections into the next frame are uncertain.
    """

    rows: NDArray[np.int64]
    points: NDArray[np.int32]
    positions: NDArray[np.float64]
    spread: NDArray[np.float64]

    def kept(self, chosen: NDArray[np.int64]) -> "Sighted":
        """Some of them."""
        return Sighted(self.rows[chosen], self.points[chosen], self.positions[chosen], self.spread[chosen])


@dataclass(frozen=True, slots=True, eq=False)
class Followed:
    """Keypoints that were followed, and the pose that they give in the world of one version of the map.

    Attributes:
        features, seen: as in `LastFrame`.
        asked: how many were looked for.
    """

    features: Features
    seen: Features
    estimate: Estimate
    version: int
    asked: int


@dataclass(frozen=True, slots=True, eq=False)
class Search:
    """What a search of the local map came to.

    Attributes:
        estimate: the view's pose with all matches.
        reference: the keyframe that shares most points with it.
        expected: ids of the map points that should be in view.
        is_sure: whether it began from a pose on which most of what the last view saw agreed, or pictures tell the same.
    """

    estimate: Estimate
    reference: int
    expected: NDArray[np.int32]
    is_sure: bool
