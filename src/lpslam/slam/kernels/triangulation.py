"""Matching the keypoints of two views by appearance where epipolar geometry lets them be the same."""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpslam.slam.kernels.geometry import hamming

_BINS = 512
"""Half-planes about the baseline in which rays are looked up."""


class Rays(NamedTuple):
    """Keypoints of a view, n rows.

    Attributes:
        direction: (n, 3) in its camera frame, with z = 1.
        octave, descriptor: (n,) and (n, 4) see `Features`.
    """

    direction: NDArray[np.float64]
    octave: NDArray[np.uint8]
    descriptor: NDArray[np.uint64]


@njit(cache=True, nogil=True)
def match_epipolar(
    own: Rays,
    other: Rays,
    other_from_own: NDArray[np.float64],
    focal: tuple[float, float],
    gates: NDArray[np.float64],
    max_distance: int,
    ratio: float,
) -> NDArray[np.int32]:
    """For each keypoint of another view the own one that looks most alike among those whose epipolar line it is on.

    A point and the two cameras span a half-plane that begins at the line through the cameras: both rays lie in it.
    Rays are bucketed by its angle, so that each is compared with few.

    Args:
        own, other: n and m keypoints.
        other_from_own: 4×4, between the camera frames.
        focal: fx, fy.
        gates: (levels,) pixels²; the sum of both keypoints' is the square of the largest distance from the line.
        max_distance: largest Hamming distance of a match.
        ratio: a second candidate on the same level must be farther by 1/ratio; 1 or more turns the test off.

    Returns:
        (m,) rows of `own`, or -1; each is given to one keypoint only, the nearest in descriptor space.
    """
    n, m = own.direction.shape[0], other.direction.shape[0]
    match = np.full(m, -1, np.int32)
    tx, ty, tz = other_from_own[0, 3], other_from_own[1, 3], other_from_own[2, 3]
    length = math.sqrt(tx * tx + ty * ty + tz * tz)
    if length == 0.0:
        return match
    # Two axes across the baseline; any that are not along it would do.
    tx, ty, tz = tx / length, ty / length, tz / length
    if abs(tz) < 0.7:
        ux, uy, uz = -tz * tx, -tz * ty, 1.0 - tz * tz
    else:
        ux, uy, uz = 1.0 - tx * tx, -tx * ty, -tx * tz
    length = math.sqrt(ux * ux + uy * uy + uz * uz)
    ux, uy, uz = ux / length, uy / length, uz / length
    vx, vy, vz = ty * uz - tz * uy, tz * ux - tx * uz, tx * uy - ty * ux

    # Own rays: the half-plane as a unit vector across the baseline, bucketed by its angle; and the line's scale.
    across = np.empty((n, 2))
    to_pixels = np.empty(n)
    bucket = np.empty(n, np.int32)
    starts = np.zeros(_BINS + 1, np.int32)
    widest = 0.0
    for i in range(n):
        a, b, c = own.direction[i, 0], own.direction[i, 1], own.direction[i, 2]
        x = other_from_own[0, 0] * a + other_from_own[0, 1] * b + other_from_own[0, 2] * c
        y = other_from_own[1, 0] * a + other_from_own[1, 1] * b + other_from_own[1, 2] * c
        z = other_from_own[2, 0] * a + other_from_own[2, 1] * b + other_from_own[2, 2] * c
        p, q = ux * x + uy * y + uz * z, vx * x + vy * y + vz * z
        norm = math.sqrt(p * p + q * q) + 1e-12
        p, q = p / norm, q / norm
        across[i, 0], across[i, 1] = p, q
        # The plane's normal, p v − q u, is the line in normalised coordinates.
        line_u, line_v = (p * vx - q * ux) / focal[0], (p * vy - q * uy) / focal[1]
        to_pixels[i] = 1.0 / (math.sqrt(line_u * line_u + line_v * line_v) + 1e-12)
        bucket[i] = int((math.atan2(q, p) / (2.0 * math.pi) + 0.5) * _BINS) % _BINS
        starts[bucket[i] + 1] += 1
        widest = max(widest, gates[own.octave[i]])
    for k in range(_BINS):
        starts[k + 1] += starts[k]
    fill = starts[:-1].copy()
    order = np.empty(n, np.int32)
    for i in range(n):
        order[fill[bucket[i]]] = i
        fill[bucket[i]] += 1

    owner = np.full(n, -1, np.int32)
    owner_distance = np.full(n, max_distance + 1, np.int32)
    for j in range(m):
        x, y, z = other.direction[j, 0], other.direction[j, 1], other.direction[j, 2]
        p, q = ux * x + uy * y + uz * z, vx * x + vy * y + vz * z
        gate = gates[other.octave[j]]
        # The nearer to the baseline a ray is, the less turning about it moves the ray.
        reach = math.sqrt((gate + widest) * (x * x + y * y + z * z)) / min(focal[0], focal[1])
        sideways = math.sqrt(p * p + q * q)
        first, count = 0, _BINS
        if reach < sideways:
            turn = math.asin(reach / sideways) / (2.0 * math.pi)
            angle = math.atan2(q, p) / (2.0 * math.pi) + 0.5
            first = math.floor((angle - turn) * _BINS)
            count = min(math.floor((angle + turn) * _BINS) - first + 1, _BINS)
        best, best_distance = -1, 257
        second, second_distance = -1, 257
        for k in range(first, first + count):
            for o in range(starts[k % _BINS], starts[k % _BINS + 1]):
                i = order[o]
                if across[i, 0] * p + across[i, 1] * q <= 0.0:
                    continue
                off = (across[i, 0] * q - across[i, 1] * p) * to_pixels[i]
                if off * off > gate + gates[own.octave[i]]:
                    continue
                distance = hamming(other.descriptor[j], own.descriptor[i])
                if distance < best_distance:
                    second, second_distance = best, best_distance
                    best, best_distance = i, distance
                elif distance < second_distance:
                    second, second_distance = i, distance
        if best < 0 or best_distance >= owner_distance[best]:
            continue
        if second >= 0 and own.octave[best] == own.octave[second] and best_distance > ratio * second_distance:
            continue
        if owner[best] >= 0:
            match[owner[best]] = -1
        owner[best], owner_distance[best] = j, best_distance
        match[j] = best
    return match
