"""Direct alignment of two small RGB-D images: brightness and depth of every pixel (Steinbrücker 2011; Kerl 2013)."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

_HUBER = 1.5
"""Sigmas from which on a residual counts linearly."""

_AGREES = 3.0
"""Sigmas within which a reading of depth agrees with a pose."""


@njit(cache=True, nogil=True, inline="always")
def _add(
    hessian: NDArray[np.float64],
    gradient: NDArray[np.float64],
    along: tuple[float, float, float],
    point: tuple[float, float, float],
    residual: float,
    sigma: float,
) -> None:
    """Add a residual whose derivative by the point is `along`; the pose is moved by a twist from the left."""
    a, b, c = along
    x, y, z = point
    jacobian = (a, b, c, c * y - b * z, a * z - c * x, b * x - a * y)
    size = abs(residual) / sigma
    weight = (1.0 if size < _HUBER else _HUBER / size) / (sigma * sigma)
    for i in range(6):
        gradient[i] += weight * jacobian[i] * residual
        for j in range(i, 6):
            hessian[i, j] += weight * jacobian[i] * jacobian[j]


@njit(cache=True, nogil=True)
def align_terms(
    reference: NDArray[np.float32],
    image: NDArray[np.float32],
    intrinsics: NDArray[np.float64],
    pose: NDArray[np.float64],
    brightness: tuple[float, float],
    depth_noise: tuple[float, float],
    hessian: NDArray[np.float64],
    gradient: NDArray[np.float64],
    residuals: NDArray[np.float64],
) -> tuple[int, int, int]:
    """Normal equations of the pose between two images, from all pixels of the reference with depth.

    Args:
        reference: (2, h, w) grey value and depth in metres, 0 where there is none.
        image: (6, h, w) grey value, its slope along u and v, depth, its slope along u and v; depth and slopes are not
            a number off smooth surfaces.
        intrinsics: fx, fy, cx, cy of both.
        pose: 4×4 image from reference.
        brightness: what is added to the image's grey values, and their sigma.
        depth_noise: c in metres and q a metre of σ = c + q z².
        hessian, gradient: (6, 6), of which the upper half is filled, and (6,); overwritten.
        residuals: (2, h·w) overwritten for each pixel that fell into the image: by how much its grey value differs, and
            the reference's grey value.

    Returns:
        How many pixels fell into the image, how many have depth in both, and how many of these agree.
    """
    height, width = reference.shape[1:]
    fx, fy, cx, cy = intrinsics[0], intrinsics[1], intrinsics[2], intrinsics[3]
    offset, grey_sigma = brightness
    hessian[:] = 0.0
    gradient[:] = 0.0
    inside = measured = agreeing = 0
    value = np.empty(6)
    for row in range(height):
        for column in range(width):
            depth = np.float64(reference[1, row, column])
            if depth <= 0.0:
                continue
            p, q = (column - cx) / fx * depth, (row - cy) / fy * depth
            x = pose[0, 0] * p + pose[0, 1] * q + pose[0, 2] * depth + pose[0, 3]
            y = pose[1, 0] * p + pose[1, 1] * q + pose[1, 2] * depth + pose[1, 3]
            z = pose[2, 0] * p + pose[2, 1] * q + pose[2, 2] * depth + pose[2, 3]
            if z < 0.05:
                continue
            u, v = fx * x / z + cx, fy * y / z + cy
            if not (0.0 <= u < width - 1 and 0.0 <= v < height - 1):
                continue
            left, top = int(u), int(v)
            right_share, low_share = u - left, v - top
            for k in range(6):
                above = image[k, top, left] * (1.0 - right_share) + image[k, top, left + 1] * right_share
                below = image[k, top + 1, left] * (1.0 - right_share) + image[k, top + 1, left + 1] * right_share
                value[k] = above * (1.0 - low_share) + below * low_share
            residual = value[0] + offset - np.float64(reference[0, row, column])
            residuals[0, inside], residuals[1, inside] = residual, reference[0, row, column]
            inside += 1
            u_x, u_z, v_y, v_z = fx / z, -fx * x / (z * z), fy / z, -fy * y / (z * z)
            along = (value[1] * u_x, value[2] * v_y, value[1] * u_z + value[2] * v_z)
            _add(hessian, gradient, along, (x, y, z), residual, grey_sigma)
            if value[3] == value[3] and value[4] == value[4]:
                sigma = depth_noise[0] + depth_noise[1] * z * z
                residual = value[3] - z
                measured += 1
                agreeing += abs(residual) < _AGREES * sigma
                along = (value[4] * u_x, value[5] * v_y, value[4] * u_z + value[5] * v_z - 1.0)
                _add(hessian, gradient, along, (x, y, z), residual, sigma)
    return inside, measured, agreeing
