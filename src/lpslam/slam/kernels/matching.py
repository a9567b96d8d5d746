"""Data association: projecting map points, searching windows of the image, brute force with a ratio test."""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpslam.slam.kernels.geometry import hamming

GRID_CELL = 32
"""Side in pixels of the buckets in which a frame's keypoints are looked up."""

_ROTATION_BINS = 30


@njit(cache=True, nogil=True)
def build_grid(
    pixels: NDArray[np.float32], width: int, height: int
) -> tuple[NDArray[np.int32], NDArray[np.int32], tuple[int, int]]:
    """Bucket keypoints by image cell.

    Args:
        pixels: (n, 2) u, v.
        width, height: of the image; keypoints outside (after undistortion) go to the nearest cell.

    Returns:
        starts: (rows·columns + 1,) where each bucket begins in `order`.
        order: (n,) keypoint numbers by bucket, rising within one.
        size: columns and rows of the grid.
    """
    columns = (width + GRID_CELL - 1) // GRID_CELL
    rows = (height + GRID_CELL - 1) // GRID_CELL
    count = pixels.shape[0]
    bucket = np.empty(count, np.int32)
    starts = np.zeros(rows * columns + 1, np.int32)
    for i in range(count):
        column = min(max(int(pixels[i, 0]) // GRID_CELL, 0), columns - 1)
        row = min(max(int(pixels[i, 1]) // GRID_CELL, 0), rows - 1)
        bucket[i] = row * columns + column
        starts[bucket[i] + 1] += 1
    for i in range(rows * columns):
        starts[i + 1] += starts[i]
    fill = starts[:-1].copy()
    order = np.empty(count, np.int32)
    for i in range(count):
        order[fill[bucket[i]]] = i
        fill[bucket[i]] += 1
    return starts, order, (columns, rows)


@njit(cache=True, nogil=True)
def project_candidates(
    ids: NDArray[np.int32],
    positions: NDArray[np.float64],
    normals: NDArray[np.float32],
    distance_ranges: NDArray[np.float32],
    camera_from_world: NDArray[np.float64],
    intrinsics: NDArray[np.float64],
    image_size: tuple[int, int],
    levels: int,
    log_scale: float,
    min_view_cosine: float,
) -> tuple[NDArray[np.int32], NDArray[np.float32], NDArray[np.int32], NDArray[np.float32]]:
    """Project map points that a camera may see: in the image, in their scale range, from a side they were seen from.

    Args:
        ids: (m,) rows of the point columns.
        positions, normals: (P, 3) world frame; normals point from the observers' mean direction to the viewer.
        distance_ranges: (P, 2) metres, nearest and farthest at which a point's patch matches a pyramid level.
        camera_from_world: 4×4.
        intrinsics: (fx, fy, cx, cy, b·fx).
        image_size: width, height.
        levels, log_scale: number of pyramid levels and the logarithm of their scale factor.
        min_view_cosine: cosine of the largest angle between the mean viewing direction and this one.

    Returns:
        The kept ids (k,), their (k, 3) u, v, u_r, predicted levels (k,), and cosines of the viewing angle (k,).
    """
    r, t = camera_from_world[:3, :3], camera_from_world[:3, 3]
    centre = np.empty(3)
    for a in range(3):
        centre[a] = -(r[0, a] * t[0] + r[1, a] * t[1] + r[2, a] * t[2])
    width, height = image_size
    kept = np.empty(ids.shape[0], np.int32)
    projections = np.empty((ids.shape[0], 3), np.float32)
    level = np.empty(ids.shape[0], np.int32)
    cosines = np.empty(ids.shape[0], np.float32)
    n = 0
    for i in ids:
        p = positions[i]
        z = r[2, 0] * p[0] + r[2, 1] * p[1] + r[2, 2] * p[2] + t[2]
        if z <= 0.05:
            continue
        x = r[0, 0] * p[0] + r[0, 1] * p[1] + r[0, 2] * p[2] + t[0]
        u = intrinsics[0] * x / z + intrinsics[2]
        if u < 0.0 or u >= width:
            continue
        y = r[1, 0] * p[0] + r[1, 1] * p[1] + r[1, 2] * p[2] + t[1]
        v = intrinsics[1] * y / z + intrinsics[3]
        if v < 0.0 or v >= height:
            continue
        dx, dy, dz = centre[0] - p[0], centre[1] - p[1], centre[2] - p[2]
        distance = math.sqrt(dx * dx + dy * dy + dz * dz)
        if distance < 0.8 * distance_ranges[i, 0] or distance > 1.2 * distance_ranges[i, 1]:
            continue
        cosine = (dx * normals[i, 0] + dy * normals[i, 1] + dz * normals[i, 2]) / distance
        if cosine < min_view_cosine:
            continue
        predicted = math.ceil(math.log(distance_ranges[i, 1] / distance) / log_scale)
        kept[n] = i
        projections[n, 0], projections[n, 1], projections[n, 2] = u, v, u - intrinsics[4] / z
        level[n] = min(max(predicted, 0), levels - 1)
        cosines[n] = cosine
        n += 1
    return kept[:n], projections[:n], level[:n], cosines[:n]


class Keypoints(NamedTuple):
    """A frame's keypoints, bucketed for window searches; columns as in `Features`.

    Attributes:
        grid_starts, grid_order: from `build_grid`.
        grid_size: columns and rows of the grid.
    """

    pixels: NDArray[np.float32]
    u_right: NDArray[np.float32]
    has_depth: NDArray[np.bool_]
    octave: NDArray[np.uint8]
    descriptor: NDArray[np.uint64]
    grid_starts: NDArray[np.int32]
    grid_order: NDArray[np.int32]
    grid_size: tuple[int, int]


@njit(cache=True, nogil=True)
def search_windows(
    projections: NDArray[np.float32],
    radii: NDArray[np.float32],
    lowest: NDArray[np.int32],
    highest: NDArray[np.int32],
    descriptors: NDArray[np.uint64],
    keypoints: Keypoints,
    taken: NDArray[np.bool_],
    max_distance: int,
    ratio: float,
) -> NDArray[np.int32]:
    """The best keypoint in the window around each projection.

    Args:
        projections: (m, 3) predicted u, v, u_r.
        radii: (m,) pixels.
        lowest, highest: (m,) pyramid levels a match may have.
        descriptors: (m, 4) of the projected points.
        keypoints: of the frame, n rows.
        taken: (n,) keypoints that are not to be matched.
        max_distance: largest Hamming distance of a match.
        ratio: a second candidate on the same level must be farther by 1/ratio; 1 or more turns the test off.

    Returns:
        (n,) for each keypoint the row of its projection, or -1; one projection at most per keypoint, the nearest in
        descriptor space.
    """
    pixels, u_right, octave = keypoints.pixels, keypoints.u_right, keypoints.octave
    columns, rows = keypoints.grid_size
    match = np.full(pixels.shape[0], -1, np.int32)
    match_distance = np.full(pixels.shape[0], max_distance + 1, np.int32)
    for i in range(projections.shape[0]):
        u, v, right, radius = projections[i, 0], projections[i, 1], projections[i, 2], radii[i]
        column0 = min(max(int((u - radius) / GRID_CELL), 0), columns - 1)
        column1 = min(max(int((u + radius) / GRID_CELL), 0), columns - 1)
        row0 = min(max(int((v - radius) / GRID_CELL), 0), rows - 1)
        row1 = min(max(int((v + radius) / GRID_CELL), 0), rows - 1)
        best, best_distance, best_level = -1, 257, -1
        second_distance, second_level = 257, -1
        for row in range(row0, row1 + 1):
            first, last = (
                keypoints.grid_starts[row * columns + column0],
                keypoints.grid_starts[row * columns + column1 + 1],
            )
            for k in range(first, last):
                j = keypoints.grid_order[k]
                level = int(octave[j])
                if level < lowest[i] or level > highest[i] or taken[j]:
                    continue
                if abs(pixels[j, 0] - u) > radius or abs(pixels[j, 1] - v) > radius:
                    continue
                if keypoints.has_depth[j] and abs(u_right[j] - right) > radius:
                    continue
                distance = hamming(descriptors[i], keypoints.descriptor[j])
                if distance < best_distance:
                    second_distance, second_level = best_distance, best_level
                    best, best_distance, best_level = j, distance, level
                elif distance < second_distance:
                    second_distance, second_level = distance, level
        if best < 0 or best_distance > max_distance:
            continue
        if best_level == second_level and best_distance > ratio * second_distance:
            continue
        if best_distance < match_distance[best]:
            match[best] = i
            match_distance[best] = best_distance
    return match


@njit(cache=True, nogil=True)
def match_brute_force(
    descriptors: NDArray[np.uint64],
    frame_descriptors: NDArray[np.uint64],
    max_distance: int,
    ratio: float,
) -> NDArray[np.int32]:
    """For each row of `frame_descriptors` (n, 4) the row of `descriptors` (m, 4) that matches it, or -1.

    A match is nearer than `ratio` times the second best; each row of `descriptors` is given to one keypoint only.
    """
    n = frame_descriptors.shape[0]
    match = np.full(n, -1, np.int32)
    owner = np.full(descriptors.shape[0], -1, np.int32)
    owner_distance = np.full(descriptors.shape[0], 257, np.int32)
    for j in range(n):
        best, best_distance, second = -1, 257, 257
        for i in range(descriptors.shape[0]):
            distance = hamming(descriptors[i], frame_descriptors[j])
            if distance < best_distance:
                best, second, best_distance = i, best_distance, distance
            elif distance < second:
                second = distance
        certain = best >= 0 and best_distance <= max_distance and best_distance < ratio * second
        if certain and best_distance < owner_distance[best]:
            if owner[best] >= 0:
                match[owner[best]] = -1
            owner[best], owner_distance[best] = j, best_distance
            match[j] = best
    return match


@njit(cache=True, nogil=True)
def keep_consistent_rotations(
    match: NDArray[np.int32], angles: NDArray[np.float32], frame_angles: NDArray[np.float32]
) -> None:
    """Drop, in place, matches whose change of direction is not among the three commonest.

    Args:
        match: (n,) rows of `angles` or -1.
        angles, frame_angles: radians, of the matched rows (m,) and of the keypoints (n,).
    """
    histogram = np.zeros(_ROTATION_BINS, np.int64)
    bins = np.empty(match.shape[0], np.int64)
    for j in range(match.shape[0]):
        if match[j] >= 0:
            turn = (angles[match[j]] - frame_angles[j]) / (2.0 * math.pi)
            bins[j] = int((turn - math.floor(turn)) * _ROTATION_BINS + 0.5) % _ROTATION_BINS
            histogram[bins[j]] += 1
    keep = np.zeros(_ROTATION_BINS, np.bool_)
    most = 0
    for _ in range(3):
        commonest, count = -1, -1
        for b in range(_ROTATION_BINS):
            if not keep[b] and histogram[b] > count:
                commonest, count = b, histogram[b]
        most = max(most, count)
        # A bin with less than a tenth of the commonest is noise, not a second motion.
        if count * 10 < most:
            break
        keep[commonest] = True
    for j in range(match.shape[0]):
        if match[j] >= 0 and not keep[bins[j]]:
            match[j] = -1


@njit(cache=True, nogil=True)
def twins(
    descriptors: NDArray[np.uint64],
    points: NDArray[np.int32],
    among: NDArray[np.int32],
    point_descriptor: NDArray[np.uint64],
    position: NDArray[np.float64],
    apart: float,
) -> NDArray[np.int32]:
    """What looks most like each descriptor (n, 4), at least as its match does, `points` (n,), and stands elsewhere.

    Args:
        among: (m,) points that are looked through.
        point_descriptor, position: of all points, by id.
        apart: metres; what is nearer to the match is the same thing.

    Returns:
        (n,) ids, or -1 where nothing looks so.
    """
    found = np.full(len(points), -1, np.int32)
    for i in range(len(points)):
        own = points[i]
        limit = hamming(descriptors[i], point_descriptor[own])
        for other in among:
            distance = hamming(descriptors[i], point_descriptor[other])
            if distance > limit or (distance == limit and found[i] >= 0):
                continue
            x = position[other, 0] - position[own, 0]
            y = position[other, 1] - position[own, 1]
            z = position[other, 2] - position[own, 2]
            if x * x + y * y + z * z > apart * apart:
                found[i], limit = other, distance
    return found
