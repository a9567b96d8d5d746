"""How far points are by their pixels alone, and depth images corrected by a table."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpslam.slam.kernels.graph import MapColumns
from lpslam.slam.kernels.linear import solve_positive
from lpslam.slam.kernels.reprojection import CHI2_PIXEL, MIN_DEPTH

_STEPS = 5
"""Of Gauss-Newton, from where the map has a point: that is near where its pixels put it."""


@njit(cache=True, nogil=True)
def corrected(depth: NDArray[np.float32], table: NDArray[np.float64], step: float) -> NDArray[np.float32]:
    """Depths (n,) in metres by a table of what those at 0, step, 2 · step, … are; beyond it its last factor goes on."""
    out = np.empty_like(depth)
    last = table.shape[0] - 1
    factor = table[last] / (last * step)
    for i in range(depth.shape[0]):
        d = float(depth[i])
        if not d > 0.0:
            out[i] = depth[i]
            continue
        at = d / step
        if at >= last:
            out[i] = d * factor
            continue
        j = int(at)
        out[i] = table[j] + (at - j) * (table[j + 1] - table[j])
    return out


@njit(cache=True, nogil=True)
def _place(
    m: MapColumns,
    point: int,
    intrinsics: NDArray[np.float64],
    pixel_information: NDArray[np.float32],
    position: NDArray[np.float64],
    hessian: NDArray[np.float64],
) -> bool:
    """Move a position (3,) to where the pixels of all observers put a point, and say how surely (3×3, 1/m²)."""
    fx, fy, cx, cy = intrinsics[0], intrinsics[1], intrinsics[2], intrinsics[3]
    capacity = m.point.shape[1]
    gradient, solved = np.empty(3), np.empty((3, 3))
    for _ in range(_STEPS):
        hessian[:] = 0.0
        gradient[:] = 0.0
        o = m.head[point]
        while o >= 0:
            slot, feature = o // capacity, o % capacity
            o = m.next_observation[slot, feature]
            c = m.camera_from_world[m.slot_keyframe[slot]]
            x = c[0, 0] * position[0] + c[0, 1] * position[1] + c[0, 2] * position[2] + c[0, 3]
            y = c[1, 0] * position[0] + c[1, 1] * position[1] + c[1, 2] * position[2] + c[1, 3]
            z = c[2, 0] * position[0] + c[2, 1] * position[1] + c[2, 2] * position[2] + c[2, 3]
            if z < MIN_DEPTH:
                return False
            off_u, off_v = fx * x / z + cx - m.pixels[slot, feature, 0], fy * y / z + cy - m.pixels[slot, feature, 1]
            information = float(pixel_information[m.octave[slot, feature]])
            # Cauchy's weight: a wrong match pulls little.
            information /= 1.0 + (off_u * off_u + off_v * off_v) * information / CHI2_PIXEL
            for a in range(3):
                along_u = fx * (c[0, a] - x / z * c[2, a]) / z
                along_v = fy * (c[1, a] - y / z * c[2, a]) / z
                gradient[a] -= information * (along_u * off_u + along_v * off_v)
                for b in range(3):
                    other_u = fx * (c[0, b] - x / z * c[2, b]) / z
                    other_v = fy * (c[1, b] - y / z * c[2, b]) / z
                    hessian[a, b] += information * (along_u * other_u + along_v * other_v)
        solved[:] = hessian
        if not solve_positive(solved, gradient):
            return False
        for a in range(3):
            position[a] += gradient[a]
    return True


@njit(cache=True, nogil=True)
def by_pixels(
    m: MapColumns,
    keyframe: int,
    intrinsics: NDArray[np.float64],
    pixel_information: NDArray[np.float32],
    least_observers: int,
) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
    """How far the points that a keyframe has a depth of are, by the pixels of all keyframes that see them.

    Args:
        m: the map.
        keyframe: a living one.
        intrinsics: (fx, fy, cx, cy, b·fx).
        pixel_information: (levels,) 1/σ².
        least_observers: of a point.

    Returns:
        The keyframe's keypoints (n,), how far their points are along its optical axis (n,), metres, and by which share
        of that this is uncertain (n,).
    """
    slot = m.keyframe_slot[keyframe]
    count = m.feature_count[slot]
    rows, far, share = np.empty(count, np.int64), np.empty(count), np.empty(count)
    found = 0
    position, hessian, axis = np.empty(3), np.empty((3, 3)), np.empty(3)
    c = m.camera_from_world[keyframe]
    for feature in range(count):
        point = m.point[slot, feature]
        if point < 0 or not m.has_depth[slot, feature] or m.observations[point] < least_observers:
            continue
        position[:] = m.position[point]
        if not _place(m, point, intrinsics, pixel_information, position, hessian):
            continue
        z = c[2, 0] * position[0] + c[2, 1] * position[1] + c[2, 2] * position[2] + c[2, 3]
        axis[:] = c[2, :3]
        if z < MIN_DEPTH or not solve_positive(hessian, axis):
            continue
        variance = c[2, 0] * axis[0] + c[2, 1] * axis[1] + c[2, 2] * axis[2]
        rows[found], far[found], share[found] = feature, z, math.sqrt(max(variance, 0.0)) / z
        found += 1
    return rows[:found], far[:found], share[:found]
