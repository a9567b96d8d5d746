"""Levelling the map by the floor: which way is up, from one depth image."""

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.config import LevellingConfig

_STRIDE = 6
"""Pixels between the samples of a depth image; normals come from neighbouring samples."""


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
    points, valid = _sample(depth, camera)
    right = points[:-1, 1:] - points[:-1, :-1]
    down = points[1:, :-1] - points[:-1, :-1]
    normals = np.cross(down, right)
    length = np.linalg.norm(normals, axis=-1)
    near = np.abs(right[..., 2]) + np.abs(down[..., 2]) < config.max_step * points[:-1, :-1, 2]
    usable = valid[:-1, :-1] & valid[:-1, 1:] & valid[1:, :-1] & near & (length > 0)
    normals = normals[usable] / length[usable][:, None]
    positions = points[:-1, :-1][usable]
    normals *= np.sign(-np.einsum("ij,ij->i", normals, positions))[:, None]

    up = up_in_camera / np.linalg.norm(up_in_camera)
    cosine = np.cos(config.max_tilt)
    # Narrow the cone step by step onto the normals that agree; walls and clutter fall out of it.
    for cone in (cosine, np.cos(config.max_tilt / 3), np.cos(config.inlier_angle)):
        chosen = (normals @ up > cone) & (positions @ up < -config.min_height)
        if chosen.sum() < config.min_share * usable.size:
            return None
        up = np.median(normals[chosen], axis=0)
        up /= np.linalg.norm(up)

    heights = positions[chosen] @ up
    level = _densest(heights, config.thickness)
    surface = positions[chosen][np.abs(heights - level) < config.thickness]
    if len(surface) < config.min_share * usable.size:
        return None
    _, _, axes = np.linalg.svd(surface - surface.mean(axis=0), full_matrices=False)
    normal: NDArray[np.float64] = axes[2] * np.sign(axes[2] @ up)
    return normal if normal @ up > np.cos(config.inlier_angle) else None


def level_rotation(up_in_world: NDArray[np.float64]) -> NDArray[np.float64]:
    """The 4×4 smallest rotation that takes a unit direction of the old world to the new world's z axis."""
    up = up_in_world / np.linalg.norm(up_in_world)
    axis = np.cross(up, [0.0, 0.0, 1.0])
    cosine = up[2]
    skew = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    rotation = np.eye(4)
    rotation[:3, :3] += skew + skew @ skew / (1.0 + cosine)
    return rotation


def _sample(depth: NDArray[np.float32], camera: PinholeCamera) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    z = depth[::_STRIDE, ::_STRIDE].astype(np.float64)
    valid = np.isfinite(z) & (z > 0)
    z = np.where(valid, z, 0.0)
    v, u = np.mgrid[0 : depth.shape[0] : _STRIDE, 0 : depth.shape[1] : _STRIDE]
    return np.stack([(u - camera.cx) / camera.fx * z, (v - camera.cy) / camera.fy * z, z], axis=-1), valid


def _densest(values: NDArray[np.float64], width: float) -> float:
    """Centre of the densest interval of a given half width."""
    ordered = np.sort(values)
    ends = np.searchsorted(ordered, ordered + 2 * width)
    return float(ordered[np.argmax(ends - np.arange(len(ordered)))] + width)
