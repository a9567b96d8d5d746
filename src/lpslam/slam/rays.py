"""Points of which the direction alone is known, as a camera sees them (inverse depth; Civera et al. 2008)."""

import numpy as np
from numpy.typing import NDArray

from lpslam.slam.carrying import inverses
from lpslam.slam.kernels.rays import NO_RAYS, RaySights
from lpslam.slam.map import SlamMap

_Matrix = NDArray[np.float64]
_Rows = NDArray[np.int32]


def is_unsure(slam_map: SlamMap, points: _Rows) -> NDArray[np.bool_]:
    """(n,) of which points (ids, -1 for none) the distance is not known."""
    unsure: NDArray[np.bool_] = (points >= 0) & (slam_map.columns.inverse_sigma[points] > 0)
    return unsure


def without_unsure(slam_map: SlamMap, points: _Rows) -> _Rows:
    """Those points (ids) that stand somewhere."""
    sure: _Rows = points[slam_map.columns.inverse_sigma[points] == 0]
    return sure


def ray_sights(
    slam_map: SlamMap, points: _Rows, pixels: NDArray[np.float32], information: NDArray[np.float32]
) -> RaySights:
    """Observations of points (n ids) at pixels (n, 2), each with its information (n,), 1/pixel²."""
    if not len(points):
        return NO_RAYS
    origin, direction, inverse = rays_of(slam_map, points)
    return RaySights(
        origin,
        direction,
        inverse,
        slam_map.columns.inverse_sigma[points].astype(np.float64),
        np.ascontiguousarray(pixels),
        np.ascontiguousarray(information, np.float32),
    )


def rays_of(slam_map: SlamMap, points: _Rows) -> tuple[_Matrix, _Matrix, _Matrix]:
    """Points (n ids) as seen by their first keyframes: origins (n, 3), directions (n, 3) and inverse depths (n,), 1/m.

    Origins and directions lie in the world frame; a direction is one metre deep in the keyframe.
    """
    m = slam_map.columns
    anchors = m.camera_from_world[m.first_keyframe[points]]
    origin = np.ascontiguousarray(inverses(anchors)[:, :3, 3])
    offset = m.position[points] - origin
    depth = np.maximum(np.einsum("ni,ni->n", offset, anchors[:, 2, :3]), _NEAREST)
    return origin, offset / depth[:, None], 1.0 / depth


def sway(slam_map: SlamMap, points: _Rows, camera_from_world: _Matrix, focal: float) -> _Matrix:
    """(n,) pixels, about, by which points (ids) may stand beside their projections into a camera (4×4)."""
    pixels = np.zeros(len(points))
    unsure = np.flatnonzero(slam_map.columns.inverse_sigma[points])
    if len(unsure):
        m = slam_map.columns
        centres = inverses(m.camera_from_world[m.first_keyframe[points[unsure]]])[:, :3, 3]
        shift = np.linalg.norm(centres @ camera_from_world[:3, :3].T + camera_from_world[:3, 3], axis=1)
        pixels[unsure] = focal * shift * slam_map.columns.inverse_sigma[points[unsure]]
    return pixels


_NEAREST = 0.1
"""Metres before the camera that saw it first; no point is nearer."""
