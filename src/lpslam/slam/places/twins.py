"""What else of the map looks like what a view shows: fronts all alike, tiles that repeat."""

import numpy as np
from numpy.typing import NDArray

from lpslam.slam.kernels import matching
from lpslam.slam.map import SlamMap


def twins(
    slam_map: SlamMap,
    descriptors: NDArray[np.uint64],
    points: NDArray[np.int32],
    keyframe: int,
    distance: float,
    allowed: NDArray[np.bool_] | None = None,
) -> NDArray[np.int32]:
    """(n,) ids of points elsewhere that look as much like keypoints as their matches do; -1 where there are none.

    Args:
        slam_map: the map; the caller holds its lock.
        descriptors: (n, 4) of the keypoints.
        points: (n,) ids of the points that they are matched with.
        keyframe: in whose sub-map is looked.
        distance: metres from a match from which on is elsewhere.
        allowed: (K,) keyframes whose points count; all without.
    """
    m, submaps = slam_map.columns, slam_map.submaps()
    here = submaps == submaps[keyframe]
    here = here if allowed is None else here & allowed
    count = slam_map.point_count
    among = np.flatnonzero(m.point_alive[:count] & here[m.first_keyframe[:count]]).astype(np.int32)
    found: NDArray[np.int32] = matching.twins(descriptors, points, among, m.point_descriptor, m.position, distance)
    return found


def spread_over(rows: NDArray[np.intp], most: int) -> NDArray[np.intp]:
    """Some of many rows (n,), evenly."""
    at = np.unique(np.linspace(0, len(rows) - 1, min(len(rows), most)).astype(int))
    some: NDArray[np.intp] = rows[at]
    return some
