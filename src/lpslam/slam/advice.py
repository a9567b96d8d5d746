"""The seam between SLAM and what knows places by something else than keypoints: text, for one."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray


class KeyframeMap(Protocol):
    """What an advisor is told of the map: where its keyframes are. `SlamMap` is one."""

    def submaps(self) -> NDArray[np.int32]:
        """(K,) the sub-map of every keyframe by id, removed ones too; each has a world frame of its own."""
        ...

    def living_keyframes(self) -> NDArray[np.int32]:
        """Ids of the keyframes that were not removed, rising."""
        ...

    def camera_from_world(self, keyframe: int) -> NDArray[np.float64]:
        """4×4 pose of a keyframe, also of a removed one."""
        ...

    def world_from_keyframe(self, keyframe: int) -> NDArray[np.float64]:
        """4×4, the inverse of `camera_from_world`."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class Anchor:
    """Signs that are seen and whose places are known.

    Attributes:
        corners: (n, 4, 3) metres, world frame: top left, top right, bottom right, bottom left of each.
        directions: (n, 4, 3) of the corners, in the camera's frame.
        timestamp: seconds at which they were seen so.
    """

    corners: NDArray[np.float64]
    directions: NDArray[np.float64]
    timestamp: float = -np.inf

    @property
    def middles(self) -> NDArray[np.float64]:
        """(n, 3) metres, world frame."""
        middles: NDArray[np.float64] = self.corners.mean(axis=1)
        return middles

    def pixels(self, intrinsics: NDArray[np.float64]) -> NDArray[np.float64]:
        """(n, 4, 2) where the corners are seen, undistorted."""
        fx, fy, cx, cy = intrinsics[:4]
        pixels: NDArray[np.float64] = self.directions[..., :2] / self.directions[..., 2:] * (fx, fy) + (cx, cy)
        return pixels

    def pixels_per_metre(self, intrinsics: NDArray[np.float64]) -> NDArray[np.float64]:
        """(n,) of the image, where each is seen: by its height, which turning shortens least."""
        return _heights(self.pixels(intrinsics)) / np.maximum(_heights(self.corners), 1e-6)


@dataclass(frozen=True, slots=True, eq=False)
class Recalled:
    """A place that a camera may be in.

    Attributes:
        keyframe: that is near it.
        camera_from_world: the camera's 4×4 pose in that one's world; None where it is not known.
        anchor: what is in view and has a known place in that world.
    """

    keyframe: int
    camera_from_world: NDArray[np.float64] | None = None
    anchor: Anchor | None = None


def _heights(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n,) of signs (n, 4, …)."""
    down = corners[:, 3] - corners[:, 0] + corners[:, 2] - corners[:, 1]
    heights: NDArray[np.float64] = np.linalg.norm(down, axis=1) / 2
    return heights


class LoopAdvisor(Protocol):
    """Who proposes and refuses places.

    Called in the thread that closes loops, which holds the map's lock meanwhile: answers must come in milliseconds.
    """

    def propose(self, keyframes: KeyframeMap, keyframe: int) -> Sequence[Recalled]:
        """Older places that a keyframe may show, likeliest first; each is verified like any other."""
        ...

    def vetoes(
        self, keyframes: KeyframeMap, keyframe: int, candidate: int, camera_from_world: NDArray[np.float64]
    ) -> str | None:
        """Why a keyframe cannot be where it was located, in a few words that are always the same; or None.

        Args:
            keyframes: of the map.
            keyframe, candidate: the new one, and the old one around which it was located.
            camera_from_world: 4×4 of the new one, in the world frame of the candidate's sub-map.
        """
        ...

    def recalls(self, keyframes: KeyframeMap) -> Sequence[Recalled]:
        """Where a lost camera may be, likeliest first; each is verified like any other place.

        Called in the tracking thread for every frame that is lost, or whose place is doubted. What was given last is
        given again, itself, until something else is in view.
        """
        ...

    def knows(self, keyframes: KeyframeMap, keyframe: int) -> bool:
        """Whether anything is known that may tell the place of a keyframe from its like."""
        ...

    def judges(self, keyframes: KeyframeMap, keyframe: int, since: float) -> bool | None:
        """Whether what was seen since a time, in seconds, is of the place of a keyframe; None while nothing tells.

        Called in the tracking thread after a relocalisation.
        """
        ...


class _NoAdvice:
    def propose(self, keyframes: KeyframeMap, keyframe: int) -> Sequence[Recalled]:
        return ()

    def vetoes(
        self, keyframes: KeyframeMap, keyframe: int, candidate: int, camera_from_world: NDArray[np.float64]
    ) -> str | None:
        return None

    def recalls(self, keyframes: KeyframeMap) -> Sequence[Recalled]:
        return ()

    def knows(self, keyframes: KeyframeMap, keyframe: int) -> bool:
        return False

    def judges(self, keyframes: KeyframeMap, keyframe: int, since: float) -> bool | None:
        return None


NO_ADVICE: LoopAdvisor = _NoAdvice()
