"""Where a corner lies, to a part of a pixel: at the middle of the bright or dark spot that it belongs to.

A corner test says that a pixel's neighbourhood is one, and says so of several pixels about it, by noise as much as by
the scene. The Laplacian of Gaussian (Lindeberg 1998) has its extremum at one point of the spot in every view.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

MOVES = 2
"""Pixels by which a corner may be moved at most along each axis, before the part of a pixel."""

_SIGMA = 1.5
"""Pixels; of the Gaussian over the smoothed level: about a corner's own size."""

_REACH = 5
"""Pixels of the Gaussian's support to each side."""

_SIDE = 2 * MOVES + 3
"""Responses along each side: about every pixel that may be reached."""

_ROWS = _SIDE + 2 * _REACH
"""Pixels along each side that the responses need."""


def _gaussian_and_bend() -> NDArray[np.float32]:
    """(2, taps) the Gaussian and its second derivative; of both the response to a constant is right: 1 and 0."""
    x = np.arange(-_REACH, _REACH + 1, dtype=float)
    gaussian = np.exp(-0.5 * (x / _SIGMA) ** 2)
    gaussian /= gaussian.sum()
    bend = (x**2 / _SIGMA**4 - 1.0 / _SIGMA**2) * gaussian
    return np.array([gaussian, bend - gaussian * bend.sum()], np.float32)


_TAPS = _gaussian_and_bend()


@njit(cache=True, nogil=True)
def _respond(
    image: NDArray[np.uint8], left: int, top: int, across: NDArray[np.float32], out: NDArray[np.float32]
) -> None:
    """Write the Laplacian (side, side) of pixels whose support begins at `left`, `top`; `across` is room to work in."""
    taps = _TAPS.shape[1]
    for y in range(_ROWS):
        row = image[top + y, left : left + _ROWS]
        for x in range(_SIDE):
            smooth, bent = np.float32(0.0), np.float32(0.0)
            for k in range(taps):
                value = np.float32(row[x + k])
                smooth += _TAPS[0, k] * value
                bent += _TAPS[1, k] * value
            across[0, y, x], across[1, y, x] = smooth, bent
    for y in range(_SIDE):
        for x in range(_SIDE):
            total = np.float32(0.0)
            for k in range(taps):
                total += _TAPS[1, k] * across[0, y + k, x] + _TAPS[0, k] * across[1, y + k, x]
            out[y, x] = total


@njit(cache=True, nogil=True)
def _peak(below: float, here: float, above: float) -> float:
    """Where the parabola through three values has its maximum, within half a step of the middle one."""
    bend = below + above - 2.0 * here
    return min(max(0.5 * (below - above) / bend, -0.5), 0.5) if bend < 0.0 else 0.0


@njit(cache=True, nogil=True)
def settle(
    image: NDArray[np.uint8], corners: NDArray[np.int32], border: int
) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    """Move corners to the extrema of the Laplacian about them; those that meet at one are one.

    Args:
        image: (h, w) the smoothed level.
        corners: (n, 2) x, y, at least `border` pixels from its edge.
        border: pixels to the edge that are kept; more than the reach of the response.

    Returns:
        (m, 2) whole pixels and (m, 2) exact ones, in the order of the corners.
    """
    height, width = image.shape
    is_taken = np.zeros((height, width), np.bool_)
    whole, exact = np.empty((len(corners), 2), np.int32), np.empty((len(corners), 2), np.float32)
    across, response = np.empty((2, _ROWS, _SIDE), np.float32), np.empty((_SIDE, _SIDE), np.float32)
    count = 0
    for i in range(len(corners)):
        left, top = corners[i, 0] - MOVES - 1, corners[i, 1] - MOVES - 1
        _respond(image, left - _REACH, top - _REACH, across, response)
        if response[MOVES + 1, MOVES + 1] < 0.0:
            response *= np.float32(-1.0)
        x = y = MOVES + 1
        for _ in range(MOVES):
            best_x, best_y = x, y
            for v in range(y - 1, y + 2):
                for u in range(x - 1, x + 2):
                    if response[v, u] > response[best_y, best_x]:
                        best_x, best_y = u, v
            x, y = best_x, best_y
        at_x = min(max(left + x, border), width - 1 - border)
        at_y = min(max(top + y, border), height - 1 - border)
        if is_taken[at_y, at_x]:
            continue
        is_taken[at_y, at_x] = True
        u, v = at_x - left, at_y - top
        whole[count, 0], whole[count, 1] = at_x, at_y
        exact[count, 0] = at_x + _peak(response[v, u - 1], response[v, u], response[v, u + 1])
        exact[count, 1] = at_y + _peak(response[v - 1, u], response[v, u], response[v + 1, u])
        count += 1
    return whole[:count], exact[:count]
