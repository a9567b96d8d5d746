"""What else of the map looks like what a view shows: fronts all alike, tiles that repeat."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from lpslam.config import LocatingConfig
from lpslam.slam.consensus import largest_consensus
from lpslam.slam.features import Features
from lpslam.slam.kernels import matching
from lpslam.slam.map import SlamMap


class Twins:
    """Looks for points of the map elsewhere that look like matched ones."""

    def __init__(self, slam_map: SlamMap, config: LocatingConfig) -> None:
        self._map = slam_map
        self._config = config

    def of(
        self,
        features: Features,
        keypoints: NDArray[np.intp],
        points: NDArray[np.int32],
        keyframe: int,
        allowed: NDArray[np.bool_] | None = None,
    ) -> NDArray[np.int32]:
        """(n,) ids of points elsewhere that look as much like keypoints (n,) as their matches (n,) do; -1 where none.

        Args:
            features: of the view.
            keypoints, points: rows of the view, and the points that they are matched with.
            keyframe: in whose sub-map is looked.
            allowed: (K,) keyframes whose points count; all without.
        """
        slam_map, m = self._map, self._map.columns
        submaps = slam_map.submaps()
        here = submaps == submaps[keyframe]
        here = here if allowed is None else here & allowed
        count = slam_map.point_count
        among = np.flatnonzero(m.point_alive[:count] & here[m.first_keyframe[:count]]).astype(np.int32)
        twins: NDArray[np.int32] = matching.twins(
            features.descriptor[keypoints], points, among, m.point_descriptor, m.position, self._config.rival_distance
        )
        return twins

    def places(
        self, features: Features, points: NDArray[np.int32], keyframe: int, intrinsics: NDArray[np.float64]
    ) -> Iterator[tuple[int, NDArray[np.float64]]]:
        """Where else a view may have been taken: keyframes, and 4×4 poses, camera from world, by what looks the same.

        Args:
            features: of the view.
            points: (rows,) that its keypoints see at the place where it was located, or -1.
            keyframe: by which it was located.
            intrinsics: of the camera.
        """
        config = self._config
        keypoints = spread_over(np.flatnonzero(points >= 0), _MOST_PLACED)
        twins = self.of(features, keypoints, points[keypoints], keyframe)
        for _ in range(config.rivals_tried):
            keypoints, twins = keypoints[twins >= 0], twins[twins >= 0]
            if len(twins) < config.min_trial_inliers:
                return
            positions, pixels = self._map.columns.position[twins], features.pixels[keypoints]
            found = largest_consensus(positions, pixels, intrinsics, config.trials, config.trial_pixels)
            if found is None or len(found.rows) < config.min_trial_inliers:
                return
            yield self._seeing_most(twins[found.rows]), found.camera_from_world
            twins[found.rows] = -1

    def _seeing_most(self, points: NDArray[np.int32]) -> int:
        """The keyframe that sees most of some points."""
        slam_map, m = self._map, self._map.columns
        # A row that sees no point is -1, which is the last: not one of these.
        is_one = np.zeros(slam_map.point_count + 1, np.bool_)
        is_one[points] = True
        living = slam_map.living_keyframes()
        return int(living[is_one[m.point[m.keyframe_slot[living]]].sum(axis=1).argmax()])


def spread_over(rows: NDArray[np.intp], most: int) -> NDArray[np.intp]:
    """Some of many rows (n,), evenly."""
    at = np.unique(np.linspace(0, len(rows) - 1, min(len(rows), most)).astype(int))
    some: NDArray[np.intp] = rows[at]
    return some


_MOST_PLACED = 200
"""Keypoints whose twins say where else a view may be: of four places alike, each has 50."""
