"""Levelling the map by the floor: which way is up, from one depth image."""

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from lpslam.camera import PinholeCamera
from lpslam.config import LevellingConfig

_SAMPLES_ACROSS = 80
"""Samples of a depth image from its left to its right, and as densely from top to bottom, whatever its size."""

_BAND = 7
"""Samples: wider than the slab of tolerance looks where it cuts an upright wall, at any distance."""

_HOLE = 5
"""Samples: holes narrower than this are closed where readings all around agree."""

_REFINEMENTS = 3
"""Times the plane is fitted anew to the samples that agree with it."""


def floor_normal(
    depth: NDArray[np.float32],
    camera: PinholeCamera,
    up_in_camera: NDArray[np.float64],
    config: LevellingConfig,
) -> NDArray[np.float64] | None:
    """The upward unit normal (3,) of the floor, or of another large level surface below the camera.

    Args:
        depth: (h, w) metres, 0 where there is none.
        camera: its calibration.
        up_in_camera: (3,) a first idea of which way is up, in the optical frame.
        config: how far it may be wrong, and what counts as a surface.

    Returns:
        The normal in the optical frame; None where no surface is large and flat enough to trust.
    """
    stride = max(1, round(depth.shape[1] / _SAMPLES_ACROSS))
    points, rows, columns = _sample(depth, camera, stride)
    up = up_in_camera / np.linalg.norm(up_in_camera)
    is_below = points @ up < -config.min_height
    below = points[is_below]
    grid = np.zeros((depth.shape[0] // stride + 1, depth.shape[1] // stride + 1), np.bool_)
    least = config.min_share * grid.size
    if len(below) < max(least, 3):
        return None
    tolerance = config.thickness + config.thickness_quadratic * below[:, 2] ** 2

    # Planes through three samples; only those that could be level are worth counting.
    random = np.random.default_rng(len(below))
    corners = below[random.integers(0, len(below), (config.hypotheses, 3))]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normals, axis=1)
    level = np.abs(normals @ up) > np.cos(config.max_tilt) * length
    usable = level & (length > config.min_spread**2)
    if not usable.any():
        return None
    normals = normals[usable] / length[usable, None]
    normals *= np.sign(normals @ up)[:, None]
    offsets = np.einsum("ij,ij->i", normals, corners[usable, 0])
    agreeing = np.abs(below @ normals.T - offsets) < tolerance[:, None]
    best = int(np.argmax(agreeing.sum(axis=0)))
    normal, offset = normals[best], offsets[best]

    for _ in range(_REFINEMENTS):
        inlier = np.abs(below @ normal - offset) < tolerance
        if inlier.sum() < least:
            return None
        normal, offset = _fit_plane(below[inlier], 1.0 / tolerance[inlier])
        normal, offset = (normal, offset) if normal @ up > 0 else (-normal, -offset)
    # A slanted plane cuts walls and shelves in bands, thin for how far they are; a floor is whole.
    # Small holes are the sensor's, and no evidence against one.
    floor = rows[is_below][inlier], columns[is_below][inlier]
    grid[floor] = True
    closed = ndimage.binary_closing(grid, np.ones((_HOLE, _HOLE), np.bool_))
    closed[rows, columns] = grid[rows, columns]
    upright, across = np.ones((_BAND, 1), np.bool_), np.ones((1, _BAND), np.bool_)
    whole = (ndimage.binary_erosion(closed, upright) & ndimage.binary_erosion(closed, across))[floor]
    if whole.sum() < config.min_whole_share * inlier.sum():
        return None
    return normal if normal @ up > np.cos(config.max_tilt) else None


def level_rotation(up_in_world: NDArray[np.float64]) -> NDArray[np.float64]:
    """The 4×4 smallest rotation that takes a unit direction of the old world to the new world's z axis."""
    up = up_in_world / np.linalg.norm(up_in_world)
    axis = np.cross(up, [0.0, 0.0, 1.0])
    cosine = up[2]
    skew = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    rotation = np.eye(4)
    rotation[:3, :3] += skew + skew @ skew / (1.0 + cosine)
    return rotation


def _sample(
    depth: NDArray[np.float32], camera: PinholeCamera, stride: int
) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.int64]]:
    """(n, 3) points in the camera frame of a grid of pixels so far apart, with their rows and columns in it."""
    z = np.nan_to_num(depth[::stride, ::stride].astype(np.float64), nan=0.0, posinf=0.0, neginf=0.0)
    v, u = np.mgrid[0 : depth.shape[0] : stride, 0 : depth.shape[1] : stride]
    points = np.stack([(u - camera.cx) / camera.fx * z, (v - camera.cy) / camera.fy * z, z], axis=-1)
    rows, columns = np.nonzero(z > 0)
    return points[rows, columns], rows, columns


def _fit_plane(points: NDArray[np.float64], weights: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
    """Weighted least-squares plane: unit normal (3,) and its offset n·p."""
    centre = np.average(points, axis=0, weights=weights**2)
    _, _, axes = np.linalg.svd((points - centre) * weights[:, None], full_matrices=False)
    normal: NDArray[np.float64] = axes[2]
    return normal, float(normal @ centre)
