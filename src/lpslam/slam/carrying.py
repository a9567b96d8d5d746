"""Changing the world under a map: keyframes get new poses, and all that hangs on them follows."""

import numpy as np
from numpy.typing import NDArray

_Matrix = NDArray[np.float64]


def inverses(transforms: _Matrix) -> _Matrix:
    """Inverses of rigid transforms (n, 4, 4)."""
    result = np.tile(np.eye(4), (len(transforms), 1, 1))
    result[:, :3, :3] = transforms[:, :3, :3].transpose(0, 2, 1)
    result[:, :3, 3] = -np.einsum("nij,nj->ni", result[:, :3, :3], transforms[:, :3, 3])
    return result


def skew(vectors: _Matrix) -> _Matrix:
    """(n, 3, 3) matrices that take the cross product with vectors (n, 3) from the left."""
    x, y, z = vectors.T
    nought = np.zeros_like(x)
    return np.stack([nought, -z, y, z, nought, -x, -y, x, nought], axis=1).reshape(-1, 3, 3)


def corrections(
    camera_from_world: _Matrix, parent: NDArray[np.int32], keyframes: NDArray[np.int32], new_camera_from_world: _Matrix
) -> _Matrix:
    """(K, 4, 4) new world from old world at each keyframe.

    A keyframe without a new pose, be it removed or made meanwhile, is rigid with its parent, down the spanning tree.

    Args:
        camera_from_world: (K, 4, 4) as it is.
        parent: (K,) an earlier keyframe, or -1.
        keyframes: (n,) those with a new pose.
        new_camera_from_world: (n, 4, 4).
    """
    result = np.tile(np.eye(4), (len(parent), 1, 1))
    result[keyframes] = inverses(new_camera_from_world) @ camera_from_world[keyframes]
    follows = parent >= 0
    follows[keyframes] = False
    for k in np.flatnonzero(follows):
        result[k] = result[parent[k]]
    return result


def carry_keyframes(camera_from_world: _Matrix, new_from_old: _Matrix) -> None:
    """Move each keyframe (K, 4, 4) with its part of the world, in place."""
    camera_from_world[:] = camera_from_world @ inverses(new_from_old)


def carry_points(
    position: _Matrix, normal: NDArray[np.float32], first_keyframe: NDArray[np.int32], new_from_old: _Matrix
) -> None:
    """Move each point (P, 3), and its normal, with the keyframe that created it, in place."""
    turn = new_from_old[first_keyframe, :3, :3]
    position[:] = np.einsum("nij,nj->ni", turn, position) + new_from_old[first_keyframe, :3, 3]
    normal[:] = np.einsum("nij,nj->ni", turn, normal)
