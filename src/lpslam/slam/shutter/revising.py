"""The poses of early frames once more, when it has become known how the camera bent them."""

from collections import deque
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import inverse_transform
from lpslam.slam.association import Associator
from lpslam.slam.map import SlamMap
from lpslam.slam.ranges.curve import DepthChange
from lpslam.slam.shutter.straightening import RollingShutter
from lpslam.slam.tracking.guesses import LastFrame, without_images
from lpslam.slam.tracking.motion import velocity

_Matrix = NDArray[np.float64]


@dataclass(slots=True, eq=False)
class _Kept:
    """A tracked frame without its image; its pose is revised in place."""

    index: int
    frame: LastFrame
    is_keyframe: bool


class EarlyFrames:
    """Frames tracked before the readout was known, to be straightened and optimised again.

    Args:
        slam_map: in which they were tracked.
        associator: optimises their poses.
        shutter: straightens what they saw.
        count: latest frames that are kept.
        longest_gap: seconds between two frames that tell a velocity.
    """

    def __init__(
        self, slam_map: SlamMap, associator: Associator, shutter: RollingShutter, count: int, longest_gap: float
    ) -> None:
        self._map = slam_map
        self._associator = associator
        self._shutter = shutter
        self._longest_gap = longest_gap
        self._kept: deque[_Kept] = deque(maxlen=count)
        self._readout = shutter.readout
        self._curve = slam_map.depth_curve

    def keep(self, index: int, frame: LastFrame, is_keyframe: bool) -> None:
        """Take a tracked frame, while the readout may still change."""
        if not self._shutter.is_settled:
            self._kept.append(_Kept(index, without_images(frame), is_keyframe))

    def revise(self) -> dict[int, _Matrix]:
        """Frames by index with the keyframe-from-camera (4×4) that they have now; none if the readout is as it was."""
        if self._shutter.readout == self._readout and self._map.depth_curve is self._curve:
            return {}
        self._readout = self._shutter.readout
        with self._map.lock:
            self._read_again()
            # The second time, velocities come from poses that are straight already.
            for _ in range(2):
                self._optimise([self._twist(k) for k in range(len(self._kept))])
        revised = {
            kept.index: inverse_transform(kept.frame.camera_from_reference)
            for kept in self._kept
            if not kept.is_keyframe
        }
        if self._shutter.is_settled:
            self._kept.clear()
        return revised

    def _read_again(self) -> None:
        """Take the depths that the map takes now."""
        change = DepthChange(self._curve, self._map.depth_curve)
        self._curve = self._map.depth_curve
        if change.before is not change.after:
            for kept in self._kept:
                kept.frame = replace(kept.frame, seen=change.of(kept.frame.seen, self._shutter.sensor))

    def _optimise(self, twists: list[_Matrix | None]) -> None:
        alive = self._map.columns.point_alive
        for kept, twist in zip(self._kept, twists, strict=True):
            frame = kept.frame
            points = np.where((frame.points >= 0) & alive[frame.points], frame.points, -1).astype(np.int32)
            if kept.is_keyframe or twist is None:
                continue
            straight = self._shutter.straighten(frame.seen, twist)
            found = self._associator.optimise_on_map(straight, frame.camera_from_world(self._map), points)
            if found is not None and found.matches >= _LEAST_SHARE * np.count_nonzero(points >= 0):
                reference = self._map.world_from_keyframe(frame.reference)
                kept.frame = replace(frame, camera_from_reference=found.camera_from_world @ reference)

    def _twist(self, k: int) -> _Matrix | None:
        """(6,) velocity a second over the neighbours of the k-th frame."""
        first, last = self._kept[max(k - 1, 0)].frame, self._kept[min(k + 1, len(self._kept) - 1)].frame
        seconds = last.timestamp - first.timestamp
        if not 0.0 < seconds <= 2.0 * self._longest_gap:
            return None
        return velocity(first.camera_from_world(self._map), last.camera_from_world(self._map), seconds)


_LEAST_SHARE = 0.5
"""Of the points that a frame saw; where fewer agree with its new pose, the old one stays."""
