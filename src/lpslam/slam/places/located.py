"""What is known of a place in the map that explains a view."""

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from lpslam.slam.advice import Anchor
from lpslam.slam.places.fitting import Fitted
from lpslam.slam.places.parts import Parts

_Matrix = NDArray[np.float64]
_Rows = NDArray[np.int32]


class Fit(Protocol):
    """Where a view was taken by its depth."""

    def __call__(
        self, anchor: Anchor | None, camera_from_world: _Matrix | None, points: _Matrix, doubt: float = 1.0
    ) -> Fitted | None:
        """From the signs in a view, or a first pose (4×4), doubtful by so many sigmas, and map points (n, 3) around."""
        ...


class Look(Protocol):
    """What a picture shows of a place."""

    def share(self, located: "Located") -> float:
        """Share of what should be seen that stands where the place has it, at least."""
        ...

    def contradicts(self, located: "Located") -> bool:
        """Whether something of the place, which should be seen as well as all around it, is not there."""
        ...


class Expected(NamedTuple):
    """Map points that should be seen from a place, where nothing hides them.

    Attributes:
        points: (m,) ids.
        pixels: (m, 2) undistorted u, v.
        levels: (m,) the pyramid level at which each should be found.
    """

    points: _Rows
    pixels: NDArray[np.float32]
    levels: _Rows


@dataclass(frozen=True, slots=True, eq=False)
class Located:
    """A place in the map that explains a view.

    Attributes:
        keyframe: the candidate that was looked at.
        camera_from_world: 4×4 of the view, in the world frame of the candidate's sub-map.
        points: (n,) the map point that each keypoint sees, or -1.
        inliers: how many do.
        expected: which map points should be seen from there.
        parts: of these, in every part of the image.
        depth_agreement: share of the inliers with a depth whose depth agrees with the map.
        alike_agreement: share of the keypoints that look like one point of the place, and like no other, that see it:
            so much at least, with 95 %.
        is_told: something else than appearance said where to look.
        is_fitted: that, and what the view's depth shows lies where the map has it.
    """

    keyframe: int
    camera_from_world: _Matrix
    points: _Rows
    inliers: int
    expected: Expected
    parts: Parts
    depth_agreement: float
    alike_agreement: float
    is_told: bool = False
    is_fitted: bool = False

    @property
    def missing_share(self) -> float:
        """Share of what should be seen in parts of the image where none of it is, beyond what chance explains."""
        return self.parts.missing_share

    @property
    def seen_share(self) -> float:
        """Share of the map points that should be seen and are."""
        return self.inliers / max(len(self.expected.points), 1)


def at_least(seen: int, of: int) -> float:
    """The share of which so many are a sample, at least: the lower end of Wilson's interval (1927)."""
    share, spread = seen / of, _SIGMAS**2 / of
    return (share + spread / 2 - float(np.sqrt(share * (1 - share) * spread + spread**2 / 4))) / (1 + spread)


_SIGMAS = 1.64
"""Of a share's lower end: one in twenty lies below."""
