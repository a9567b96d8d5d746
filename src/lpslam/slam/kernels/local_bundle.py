"""From the map to a local adjustment problem, and its solution back into the map."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpslam.slam.kernels.bundle import BundleProblem
from lpslam.slam.kernels.graph import MapColumns, points_of, refresh_view, unlink


@njit(cache=True, nogil=True)
def gather_bundle(
    m: MapColumns,
    free: NDArray[np.int32],
    keyframe_count: int,
    point_count: int,
    pixel_information: NDArray[np.float32],
    held: int,
) -> tuple[BundleProblem, NDArray[np.int32], NDArray[np.int32]]:
    """The local adjustment around some keyframes: they and their points are free, other observers hold the frame.

    A point with a single observation, or of which the direction alone is known, binds nothing and is left out;
    `apply_bundle` carries it along.

    Args:
        m: columns.
        free: keyframes to adjust.
        keyframe_count, point_count: rows in use.
        pixel_information: (levels,) 1/σ² of a pixel at each pyramid level.
        held: a keyframe that stays fixed even if it is in `free`.

    Returns:
        The problem, its keyframes (rows of the map, free ones first) and its points.
    """
    capacity = m.point.shape[1]
    row = np.full(keyframe_count, -1, np.int32)
    keyframes = np.empty(keyframe_count, np.int32)
    count = 0
    for k in free:
        if k != held:
            row[k] = count
            keyframes[count] = k
            count += 1
    free_count = count
    candidates = points_of(m, free, point_count)
    points = np.empty(candidates.shape[0], np.int32)
    starts = np.zeros(candidates.shape[0] + 1, np.int64)
    n = 0
    for p in candidates:
        if m.observations[p] >= 2 and m.inverse_sigma[p] == 0.0:
            points[n] = p
            starts[n + 1] = starts[n] + m.observations[p]
            n += 1
    points, starts = points[:n], starts[: n + 1]
    total = starts[n]
    keyframe = np.empty(total, np.int32)
    pixels = np.empty((total, 2), np.float32)
    disparity = np.empty(total, np.float32)
    has_depth = np.empty(total, np.bool_)
    information = np.empty(total, np.float32)
    disparity_information = np.empty(total, np.float32)
    observation = np.empty(total, np.int64)
    positions = np.empty((n, 3))
    for j in range(n):
        for a in range(3):
            positions[j, a] = m.position[points[j], a]
        i = starts[j]
        o = m.head[points[j]]
        while o >= 0:
            slot, f = o // capacity, o % capacity
            k = m.slot_keyframe[slot]
            if row[k] < 0:
                row[k] = count
                keyframes[count] = k
                count += 1
            keyframe[i] = row[k]
            pixels[i, 0], pixels[i, 1] = m.pixels[slot, f, 0], m.pixels[slot, f, 1]
            disparity[i] = m.pixels[slot, f, 0] - m.u_right[slot, f]
            has_depth[i] = m.has_depth[slot, f]
            information[i] = pixel_information[m.octave[slot, f]]
            disparity_information[i] = m.disparity_information[slot, f]
            observation[i] = o
            i += 1
            o = m.next_observation[slot, f]
    poses = np.empty((count, 4, 4))
    for k in range(count):
        for a in range(4):
            for b in range(4):
                poses[k, a, b] = m.camera_from_world[keyframes[k], a, b]
    problem = BundleProblem(
        poses, free_count, positions, starts, keyframe, pixels, disparity, has_depth,
        information, disparity_information, observation,
    )  # fmt: skip
    return problem, keyframes[:count].copy(), points


@njit(cache=True, nogil=True)
def apply_bundle(
    m: MapColumns,
    problem: BundleProblem,
    keyframes: NDArray[np.int32],
    points: NDArray[np.int32],
    poses: NDArray[np.float64],
    positions: NDArray[np.float64],
    inlier: NDArray[np.bool_],
    scales: NDArray[np.float64],
) -> int:
    """Write an adjustment back; outlier observations are unlinked. Returns how many.

    Points that only one keyframe sees move rigidly with it, and so do those of which it alone tells the direction.
    """
    capacity = m.point.shape[1]
    for row in range(problem.free_count):
        k = keyframes[row]
        slot = m.keyframe_slot[k]
        if slot < 0:
            continue
        old = m.camera_from_world[k].copy()
        for a in range(4):
            for b in range(4):
                m.camera_from_world[k, a, b] = poses[row, a, b]
        for f in range(m.feature_count[slot]):
            p = m.point[slot, f]
            if p >= 0 and (m.observations[p] == 1 or (m.inverse_sigma[p] > 0.0 and m.first_keyframe[p] == k)):
                local = np.empty(3)
                for a in range(3):
                    q = m.position[p]
                    local[a] = old[a, 0] * q[0] + old[a, 1] * q[1] + old[a, 2] * q[2] + old[a, 3] - poses[row, a, 3]
                for a in range(3):
                    m.position[p, a] = (
                        poses[row, 0, a] * local[0] + poses[row, 1, a] * local[1] + poses[row, 2, a] * local[2]
                    )
    dropped = 0
    for j in range(points.shape[0]):
        p = points[j]
        if not m.point_alive[p]:
            continue
        for a in range(3):
            m.position[p, a] = positions[j, a]
        for i in range(problem.starts[j], problem.starts[j + 1]):
            o = problem.observation[i]
            if not inlier[i] and m.point[o // capacity, o % capacity] == p:
                unlink(m, o // capacity, o % capacity)
                dropped += 1
        if m.point_alive[p]:
            refresh_view(m, p, scales)
    return dropped
