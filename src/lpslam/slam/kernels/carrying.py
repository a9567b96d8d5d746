"""Changing the world under a map: keyframes get new poses, and all that hangs on them follows."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpslam.slam.kernels.geometry import inverse


@njit(cache=True, nogil=True)
def corrections(
    camera_from_world: NDArray[np.float64],
    parent: NDArray[np.int32],
    keyframes: NDArray[np.int32],
    new_camera_from_world: NDArray[np.float64],
) -> NDArray[np.float64]:
    """(K, 4, 4) new world from old world at each keyframe.

    A keyframe without a new pose, be it removed or made meanwhile, is rigid with its parent, down the spanning tree.

    Args:
        camera_from_world: (K, 4, 4) as it is.
        parent: (K,) an earlier keyframe, or -1.
        keyframes: (n,) those with a new pose.
        new_camera_from_world: (n, 4, 4).
    """
    count = parent.shape[0]
    result = np.empty((count, 4, 4))
    is_known = np.zeros(count, np.bool_)
    for i in range(keyframes.shape[0]):
        k = keyframes[i]
        result[k] = inverse(new_camera_from_world[i]) @ camera_from_world[k]
        is_known[k] = True
    for k in range(count):
        if not is_known[k]:
            result[k] = result[parent[k]] if parent[k] >= 0 else np.eye(4)
    return result


@njit(cache=True, nogil=True)
def carry_keyframes(camera_from_world: NDArray[np.float64], new_from_old: NDArray[np.float64]) -> None:
    """Move each keyframe (K, 4, 4) with its part of the world, in place."""
    for k in range(new_from_old.shape[0]):
        camera_from_world[k] = camera_from_world[k] @ inverse(new_from_old[k])


@njit(cache=True, nogil=True)
def carry_points(
    position: NDArray[np.float64],
    normal: NDArray[np.float32],
    first_keyframe: NDArray[np.int32],
    new_from_old: NDArray[np.float64],
) -> None:
    """Move each point (P, 3), and its normal, with the keyframe that created it, in place."""
    for p in range(first_keyframe.shape[0]):
        m = new_from_old[first_keyframe[p]]
        x, y, z = position[p, 0], position[p, 1], position[p, 2]
        u, v, w = normal[p, 0], normal[p, 1], normal[p, 2]
        for a in range(3):
            position[p, a] = m[a, 0] * x + m[a, 1] * y + m[a, 2] * z + m[a, 3]
            normal[p, a] = m[a, 0] * u + m[a, 1] * v + m[a, 2] * w
