"""Fusing duplicate points: points of one keyframe looked for among the keypoints of another."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpslam.slam.kernels.geometry import hamming
from lpslam.slam.kernels.graph import MapColumns, link, merge_points, observed_in
from lpslam.slam.kernels.matching import GRID_CELL, build_grid
from lpslam.slam.kernels.reprojection import CHI2_DEPTH, CHI2_PIXEL


@njit(cache=True, nogil=True)
def fuse_points(
    m: MapColumns,
    points: NDArray[np.int32],
    keyframe: int,
    intrinsics: NDArray[np.float64],
    image_size: tuple[int, int],
    scales: NDArray[np.float64],
    pixel_information: NDArray[np.float32],
    radius: float,
    max_distance: int,
) -> int:
    """Link points to the keypoints of a keyframe where they project, or merge them with the points already there.

    Args:
        m: columns.
        points: ids to look for.
        keyframe: where to look.
        intrinsics: (fx, fy, cx, cy, b·fx).
        image_size: width, height.
        scales: size of each pyramid level.
        pixel_information: (levels,) 1/σ² of a pixel.
        radius: pixels of the window at the finest level.
        max_distance: largest Hamming distance.

    Returns:
        How many points were linked or merged.
    """
    slot = m.keyframe_slot[keyframe]
    pose = m.camera_from_world[keyframe]
    width, height = image_size
    n = m.feature_count[slot]
    starts, order, (columns, rows) = build_grid(m.pixels[slot, :n], width, height)
    levels = scales.shape[0]
    log_scale = math.log(scales[1] / scales[0])
    fx, fy, cx, cy, bf = intrinsics
    fused = 0
    for p in points:
        if p < 0 or not m.point_alive[p] or observed_in(m, p, slot):
            continue
        q = m.position[p]
        z = pose[2, 0] * q[0] + pose[2, 1] * q[1] + pose[2, 2] * q[2] + pose[2, 3]
        if z < 0.05:
            continue
        x = pose[0, 0] * q[0] + pose[0, 1] * q[1] + pose[0, 2] * q[2] + pose[0, 3]
        y = pose[1, 0] * q[0] + pose[1, 1] * q[1] + pose[1, 2] * q[2] + pose[1, 3]
        u, v = fx * x / z + cx, fy * y / z + cy
        if u < 0 or u >= width or v < 0 or v >= height:
            continue
        distance = math.sqrt(x * x + y * y + z * z)
        if distance < 0.8 * m.distance_range[p, 0] or distance > 1.2 * m.distance_range[p, 1]:
            continue
        # Cosine of the angle between the ray and the point's mean viewing direction, both in the world frame.
        cosine = 0.0
        for a in range(3):
            ray = -(pose[0, a] * x + pose[1, a] * y + pose[2, a] * z)
            cosine += ray * m.normal[p, a]
        if cosine < 0.5 * distance:
            continue
        predicted = math.ceil(math.log(m.distance_range[p, 1] / distance) / log_scale)
        predicted = min(max(predicted, 0), levels - 1)
        window = radius * scales[predicted]
        column0 = min(max(int((u - window) / GRID_CELL), 0), columns - 1)
        column1 = min(max(int((u + window) / GRID_CELL), 0), columns - 1)
        row0 = min(max(int((v - window) / GRID_CELL), 0), rows - 1)
        row1 = min(max(int((v + window) / GRID_CELL), 0), rows - 1)
        best, best_distance = -1, max_distance + 1
        for row in range(row0, row1 + 1):
            for k in range(starts[row * columns + column0], starts[row * columns + column1 + 1]):
                f = order[k]
                level = np.int64(m.octave[slot, f])
                if level < predicted - 1 or level > predicted:
                    continue
                eu, ev = m.pixels[slot, f, 0] - u, m.pixels[slot, f, 1] - v
                if abs(eu) > window or abs(ev) > window:
                    continue
                if (eu * eu + ev * ev) * pixel_information[level] > CHI2_PIXEL:
                    continue
                if m.has_depth[slot, f]:
                    ed = m.pixels[slot, f, 0] - m.u_right[slot, f] - bf / z
                    # Both the reading and the point carry depth noise.
                    if ed * ed * m.disparity_information[slot, f] > 4.0 * CHI2_DEPTH:
                        continue
                difference = hamming(m.point_descriptor[p], m.descriptor[slot, f])
                if difference < best_distance:
                    best, best_distance = f, difference
        if best < 0:
            continue
        other = m.point[slot, best]
        if other < 0:
            link(m, p, slot, best)
        elif m.observations[other] >= m.observations[p]:
            merge_points(m, p, other)
        else:
            merge_points(m, other, p)
        fused += 1
    return fused


@njit(cache=True, nogil=True)
def replace_points(m: MapColumns, slot: int, points: NDArray[np.int32]) -> None:
    """Make the keypoints of a slot see other points (n ids, -1 for none); what they saw is merged into those."""
    for feature in range(points.shape[0]):
        p, own = points[feature], m.point[slot, feature]
        if p < 0 or p == own or not m.point_alive[p]:
            continue
        if own >= 0:
            merge_points(m, own, p)
        elif not observed_in(m, p, slot):
            link(m, p, slot, feature)
