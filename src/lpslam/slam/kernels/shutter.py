"""Rolling shutter: where keypoints would be had all rows been exposed at once."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpslam.slam.kernels.geometry import exponential
from lpslam.slam.kernels.reprojection import MIN_DEPTH


@njit(cache=True, nogil=True)
def straighten(
    pixels: NDArray[np.float32],
    depth: NDArray[np.float32],
    twist: NDArray[np.float64],
    readout: float,
    height: int,
    intrinsics: NDArray[np.float64],
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Pixels and depths as at the middle row's time.

    A point that is seen t seconds after the middle row stands at exp(t ξ) X in the camera, where X is its place at the
    middle row's time and ξ the camera's velocity. Without depth only the turn counts.

    Args:
        pixels: (n, 2) undistorted, as seen.
        depth: (n,) metres; 0 for none.
        twist: (6,) of the world in the camera frame, a second (translation, rotation).
        readout: seconds from the first row to the last; negative undoes it.
        height: rows of the image.
        intrinsics: (fx, fy, cx, cy, b·fx).

    Returns:
        Pixels (n, 2) and depths (n,); what would come to lie behind the camera stays.
    """
    fx, fy, cx, cy = intrinsics[0], intrinsics[1], intrinsics[2], intrinsics[3]
    out_pixels, out_depth = pixels.copy(), depth.copy()
    scaled = np.empty(6)
    for i in range(pixels.shape[0]):
        t = ((pixels[i, 1] + 0.5) / height - 0.5) * readout
        z = np.float64(depth[i])
        for a in range(6):
            scaled[a] = -t * twist[a]
        if z <= 0.0:
            scaled[0] = scaled[1] = scaled[2] = 0.0
        move = exponential(scaled)
        length = z if z > 0.0 else 1.0
        x, y = (pixels[i, 0] - cx) / fx * length, (pixels[i, 1] - cy) / fy * length
        new_z = move[2, 0] * x + move[2, 1] * y + move[2, 2] * length + move[2, 3]
        if new_z < MIN_DEPTH * length:
            continue
        new_x = move[0, 0] * x + move[0, 1] * y + move[0, 2] * length + move[0, 3]
        new_y = move[1, 0] * x + move[1, 1] * y + move[1, 2] * length + move[1, 3]
        out_pixels[i, 0] = fx * new_x / new_z + cx
        out_pixels[i, 1] = fy * new_y / new_z + cy
        if z > 0.0:
            out_depth[i] = new_z
    return out_pixels, out_depth


@njit(cache=True, nogil=True)
def readout_terms(
    points: NDArray[np.float64],
    rows_before: NDArray[np.float64],
    twist_before: NDArray[np.float64],
    target: NDArray[np.float32],
    rows_after: NDArray[np.float64],
    twist_after: NDArray[np.float64],
    after_from_before: NDArray[np.float64],
    information: NDArray[np.float32],
    scale: float,
    intrinsics: NDArray[np.float64],
    depth_after: NDArray[np.float32],
    chi2: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Normal equations of a rigid motion (a twist from the left) and of the readout, from points that two views show.

    Args:
        points: (n, 3) in the first view, straightened.
        rows_before, rows_after: (n,) of the views, shares of their height from the middle.
        twist_before, twist_after: (6,) velocities.
        target: (n, 2) pixels in the second view, straightened.
        after_from_before: 4×4.
        information: (n,) 1/σ² of a pixel.
        scale: χ² at which an error counts a quarter.
        intrinsics: fx, fy, cx, cy, b·fx.
        depth_after: (n,) overwritten: metres in the second view.
        chi2: (n,) overwritten.

    Returns:
        Of twist and readout in seconds: (7, 7), of which the upper half is filled, and (7,).
    """
    fx, fy, cx, cy = intrinsics[0], intrinsics[1], intrinsics[2], intrinsics[3]
    normal, right = np.zeros((7, 7)), np.zeros(7)
    jacobian, error = np.zeros((2, 7)), np.empty(2)
    turned = np.empty(3)
    m = after_from_before
    for i in range(points.shape[0]):
        p, q, r = points[i, 0], points[i, 1], points[i, 2]
        # A point seen that much later has moved by its velocity.
        a = -rows_before[i] * (twist_before[4] * r - twist_before[5] * q + twist_before[0])
        b = -rows_before[i] * (twist_before[5] * p - twist_before[3] * r + twist_before[1])
        c = -rows_before[i] * (twist_before[3] * q - twist_before[4] * p + twist_before[2])
        for k in range(3):
            turned[k] = m[k, 0] * a + m[k, 1] * b + m[k, 2] * c
        x = m[0, 0] * p + m[0, 1] * q + m[0, 2] * r + m[0, 3]
        y = m[1, 0] * p + m[1, 1] * q + m[1, 2] * r + m[1, 3]
        z = m[2, 0] * p + m[2, 1] * q + m[2, 2] * r + m[2, 3]
        near = 1.0 / max(z, MIN_DEPTH)
        depth_after[i] = z
        error[0], error[1] = target[i, 0] - (fx * x * near + cx), target[i, 1] - (fy * y * near + cy)
        for k in range(2):
            u, v = (fx * near, 0.0) if k == 0 else (0.0, fy * near)
            w = -(fx * x if k == 0 else fy * y) * near * near
            row = jacobian[k]
            row[0], row[1], row[2] = u, v, w
            row[3], row[4], row[5] = y * w - z * v, z * u - x * w, x * v - y * u
            along = 0.0
            for j in range(6):
                along += row[j] * twist_after[j]
            row[6] = along * rows_after[i] + u * turned[0] + v * turned[1] + w * turned[2]
        chi2[i] = (error[0] * error[0] + error[1] * error[1]) * information[i]
        weight = information[i] * (scale / (scale + chi2[i])) ** 2
        for k in range(2):
            for j in range(7):
                scaled = weight * jacobian[k, j]
                right[j] += scaled * error[k]
                for h in range(j, 7):
                    normal[j, h] += scaled * jacobian[k, h]
    return normal, right
