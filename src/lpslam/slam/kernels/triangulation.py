"""Matching keypoints with those of another view whose epipolar lines pass them."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpslam.slam.kernels.geometry import hamming


@njit(cache=True, nogil=True)
def match_lines(
    pixels: NDArray[np.float32],
    pixel_gates: NDArray[np.float64],
    descriptors: NDArray[np.uint64],
    lines: NDArray[np.float64],
    line_gates: NDArray[np.float64],
    line_octaves: NDArray[np.uint8],
    line_descriptors: NDArray[np.uint64],
    candidates: NDArray[np.int64],
    first: NDArray[np.int64],
    last: NDArray[np.int64],
    max_distance: int,
    ratio: float,
) -> NDArray[np.int32]:
    """For each keypoint the epipolar line close to it whose own keypoint looks most alike.

    Args:
        pixels, descriptors: (m, 2) and (m, 4) of the keypoints.
        lines: (n, 3) a, b, c with a² + b² = 1: a u + b v + c is a pixel's distance from the line.
        pixel_gates, line_gates: (m,) and (n,) pixels²; their sum is the square of the largest distance.
        line_octaves, line_descriptors: (n,) and (n, 4) of the other view's keypoints that the lines belong to.
        candidates: rows of lines; keypoint j is compared with `candidates[first[j]:last[j]]` only.
        first, last: (m,).
        max_distance: largest Hamming distance of a match.
        ratio: a second candidate on the same level must be farther by 1/ratio; 1 or more turns the test off.

    Returns:
        (m,) for each keypoint the row of its line, or -1; each line is given to one keypoint only.
    """
    match = np.full(pixels.shape[0], -1, np.int32)
    owner = np.full(lines.shape[0], -1, np.int32)
    owner_distance = np.full(lines.shape[0], max_distance + 1, np.int32)
    for j in range(pixels.shape[0]):
        best, best_distance = -1, 257
        second, second_distance = -1, 257
        for k in range(first[j], last[j]):
            i = candidates[k]
            off = lines[i, 0] * pixels[j, 0] + lines[i, 1] * pixels[j, 1] + lines[i, 2]
            if off * off > line_gates[i] + pixel_gates[j]:
                continue
            distance = hamming(descriptors[j], line_descriptors[i])
            if distance < best_distance:
                second, second_distance = best, best_distance
                best, best_distance = i, distance
            elif distance < second_distance:
                second, second_distance = i, distance
        if best < 0 or best_distance >= owner_distance[best]:
            continue
        if second >= 0 and line_octaves[best] == line_octaves[second] and best_distance > ratio * second_distance:
            continue
        if owner[best] >= 0:
            match[owner[best]] = -1
        owner[best], owner_distance[best] = j, best_distance
        match[j] = best
    return match
