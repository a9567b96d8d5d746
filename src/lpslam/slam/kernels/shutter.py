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
