"""Brings measured depth into the colour image, as the makers' programs do: each depth pixel covers a small patch."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera

Picture = NDArray[np.float32]
Matrix = NDArray[np.float64]


def register(
    depth: Picture,
    sensor: PinholeCamera,
    colour: PinholeCamera,
    colour_from_sensor: Matrix,
    beside: tuple[float, float],
) -> Picture:
    """Project every depth pixel into the (distorted) colour image; the nearest one stays.

    Args:
        depth: (h, w) metres in the sensor's image.
        sensor, colour: geometries.
        colour_from_sensor: 4×4.
        beside: pixels (x, y) by which the result is shifted in the colour image.

    Returns:
        (height, width) metres along the colour camera's axis, 0 where there is none.
    """
    own = (sensor.fx, sensor.fy, sensor.cx, sensor.cy)
    other = (colour.fx, colour.fy, colour.cx + beside[0], colour.cy + beside[1])
    out = np.zeros((colour.height, colour.width), np.float32)
    _register(depth, own, other, colour.distortion, colour_from_sensor, out)
    return out


@njit(cache=True, nogil=True, fastmath=True)
def _register(
    depth: Picture,
    own: tuple[float, float, float, float],
    other: tuple[float, float, float, float],
    distortion: tuple[float, float, float, float, float],
    move: Matrix,
    out: Picture,
) -> None:
    height, width = depth.shape
    rows, columns = out.shape
    k1, k2, p1, p2, k3 = distortion
    for row in range(height):
        y0 = (row - own[3]) / own[1]
        for column in range(width):
            z0 = depth[row, column]
            if z0 <= 0.0:
                continue
            x0 = (column - own[2]) / own[0]
            z = z0 * (move[2, 0] * x0 + move[2, 1] * y0 + move[2, 2]) + move[2, 3]
            if z < 0.05:
                continue
            x = (z0 * (move[0, 0] * x0 + move[0, 1] * y0 + move[0, 2]) + move[0, 3]) / z
            y = (z0 * (move[1, 0] * x0 + move[1, 1] * y0 + move[1, 2]) + move[1, 3]) / z
            r2 = x * x + y * y
            if r2 > 4.0:
                continue
            radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
            u = other[0] * (x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x)) + other[2]
            v = other[1] * (y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y) + other[3]
            # The patch is as large as one depth pixel looks from the colour camera, and a little more against cracks.
            growth = z0 / z * max(1.0, 1.0 + r2 * (3.0 * k1 + r2 * (5.0 * k2 + r2 * 7.0 * k3)))
            across = max(0.5 * other[0] / own[0] * growth + 0.08, 0.5)
            down = max(0.5 * other[1] / own[1] * growth + 0.08, 0.5)
            left, right = max(math.ceil(u - across), 0), min(math.floor(u + across), columns - 1)
            top, bottom = max(math.ceil(v - down), 0), min(math.floor(v + down), rows - 1)
            for i in range(top, bottom + 1):
                for j in range(left, right + 1):
                    if out[i, j] == 0.0 or z < out[i, j]:
                        out[i, j] = z
