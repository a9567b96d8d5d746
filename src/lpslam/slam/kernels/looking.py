"""What stands at a spot of a picture, whether or not a corner was found there: compiled loops over descriptors."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpslam.slam.kernels.geometry import hamming
from lpslam.slam.kernels.image import BORDER, describe, orientations

NOWHERE = 257
"""Bits by which what is outside the picture differs from any descriptor: more than there are."""


@njit(cache=True, nogil=True)
def least_distances(
    image: NDArray[np.uint8],
    blurred: NDArray[np.uint8],
    spots: NDArray[np.int32],
    radius: int,
    steered: NDArray[np.int64],
    descriptors: NDArray[np.uint64],
) -> NDArray[np.int32]:
    """By how many bits each descriptor differs from what is most like it around each of its spots.

    Args:
        image: (h, w) contiguous, a level.
        blurred: (h, w) contiguous, the same after smoothing.
        spots: (n, places, 2) x, y in pixels of the level.
        radius: pixels around a spot, in a square.
        steered: as `describe` takes them.
        descriptors: (n, 4), 64 bits a word.

    Returns:
        (n, places) bits; `NOWHERE` where the square comes too near to the border.
    """
    height, width = image.shape
    side = 2 * radius + 1
    corners = np.empty((side * side, 2), np.int32)
    there = np.empty((side * side, 4), np.uint64)
    margin = BORDER + radius
    least = np.full(spots.shape[:2], NOWHERE, np.int32)
    for i in range(spots.shape[0]):
        for place in range(spots.shape[1]):
            x, y = spots[i, place, 0], spots[i, place, 1]
            if x < margin or y < margin or x >= width - margin or y >= height - margin:
                continue
            for cell in range(side * side):
                corners[cell, 0], corners[cell, 1] = x + cell % side - radius, y + cell // side - radius
            describe(blurred, corners, orientations(image, corners), steered, there)
            for cell in range(side * side):
                least[i, place] = min(least[i, place], hamming(descriptors[i], there[cell]))
    return least
