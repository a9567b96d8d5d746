"""Searching the keypoints of another view along epipolar lines."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpslam.slam.kernels.geometry import hamming


@njit(cache=True, nogil=True)
def match_along_lines(
    lines: NDArray[np.float64],
    line_gates: NDArray[np.float64],
    descriptors: NDArray[np.uint64],
    pixels: NDArray[np.float32],
    pixel_gates: NDArray[np.float64],
    octaves: NDArray[np.uint8],
    other_descriptors: NDArray[np.uint64],
    max_distance: int,
    ratio: float,
) -> NDArray[np.int32]:
    """The keypoint that looks most alike near each epipolar line.

    Args:
        lines: (n, 3) a, b, c with a² + b² = 1: a u + b v + c is a pixel's distance from the line.
        line_gates, pixel_gates: (n,) and (m,) pixels²; their sum is the square of the largest distance.
        descriptors, other_descriptors: (n, 4) of the keypoints that the lines belong to, (m, 4) of those searched.
        pixels, octaves: (m, 2) and (m,) of the keypoints searched.
        max_distance: largest Hamming distance of a match.
        ratio: a second candidate on the same level must be farther by 1/ratio; 1 or more turns the test off.

    Returns:
        (m,) for each keypoint searched the row of its line, or -1; one line at most, the nearest in descriptor space.
    """
    match = np.full(pixels.shape[0], -1, np.int32)
    match_distance = np.full(pixels.shape[0], max_distance + 1, np.int32)
    for i in range(lines.shape[0]):
        a, b, c, gate = lines[i, 0], lines[i, 1], lines[i, 2], line_gates[i]
        best, best_distance = -1, 257
        second, second_distance = -1, 257
        for j in range(pixels.shape[0]):
            off = a * pixels[j, 0] + b * pixels[j, 1] + c
            if off * off > gate + pixel_gates[j]:
                continue
            distance = hamming(descriptors[i], other_descriptors[j])
            if distance < best_distance:
                second, second_distance = best, best_distance
                best, best_distance = j, distance
            elif distance < second_distance:
                second, second_distance = j, distance
        if best < 0 or best_distance >= match_distance[best]:
            continue
        if second >= 0 and octaves[best] == octaves[second] and best_distance > ratio * second_distance:
            continue
        match[best] = i
        match_distance[best] = best_distance
    return match
