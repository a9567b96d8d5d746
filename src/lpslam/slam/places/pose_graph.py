"""Pose graph: keyframe poses that agree best with measured relative poses (ORB-SLAM, VII-D, on SE(3)).

All edges at once in numpy: a few thousand of them take milliseconds, and nothing is to be compiled.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import bsr_array, csc_array
from scipy.sparse.linalg import splu

from lpslam.slam.carrying import inverses, skew
from lpslam.slam.kernels.geometry import exponential, orthonormalise

_Matrix = NDArray[np.float64]


class PoseGraph(NamedTuple):
    """Poses and the relative poses between them; n poses, e edges.

    Attributes:
        camera_from_world: (n, 4, 4).
        is_fixed: (n,) which poses hold the frame; at least one in every connected part.
        pairs: (e, 2) rows a, b of `camera_from_world`.
        a_from_b: (e, 4, 4) measured, camera a from camera b.
        weights: (e,) how much each edge counts.
    """

    camera_from_world: _Matrix
    is_fixed: NDArray[np.bool_]
    pairs: NDArray[np.int32]
    a_from_b: _Matrix
    weights: NDArray[np.float64]


def logarithms(transforms: _Matrix) -> _Matrix:
    """(n, 6) twists (translation, rotation vector) of rigid transforms (n, 4, 4): the inverse of `exponential`.

    Turns are those of at most half a revolution; near it the axis loses its sign.
    """
    r, t = transforms[:, :3, :3], transforms[:, :3, 3]
    axis = 0.5 * np.column_stack([r[:, 2, 1] - r[:, 1, 2], r[:, 0, 2] - r[:, 2, 0], r[:, 1, 0] - r[:, 0, 1]])
    sine = np.linalg.norm(axis, axis=1)
    cosine = 0.5 * (np.trace(r, axis1=1, axis2=2) - 1.0)
    theta = np.arctan2(sine, cosine)
    turns, large = sine > 1e-9, theta > 1e-3
    omega = axis * np.where(turns, theta / np.where(turns, sine, 1.0), 1.0)[:, None]
    # The coefficient of the squared rotation vector in the inverse of the left Jacobian; 1/12 in the limit.
    exact = (1.0 - 0.5 * theta * sine / np.where(large, 1.0 - cosine, 1.0)) / np.where(large, theta, 1.0) ** 2
    rest = np.where(large, exact, 1.0 / 12.0)
    once = np.cross(omega, t)
    return np.column_stack([t - 0.5 * once + rest[:, None] * np.cross(omega, once), omega])


def _adjoints(transforms: _Matrix) -> _Matrix:
    """(n, 6, 6) matrices that carry twists over transforms."""
    result = np.zeros((len(transforms), 6, 6))
    turns = transforms[:, :3, :3]
    result[:, :3, :3] = result[:, 3:, 3:] = turns
    result[:, :3, 3:] = skew(transforms[:, :3, 3]) @ turns
    return result


def _inverse_jacobians(twists: _Matrix) -> _Matrix:
    """(n, 6, 6) inverse left Jacobians of SE(3) to first order: one minus half the bracket with each twist."""
    result = np.tile(np.eye(6), (len(twists), 1, 1))
    turns = 0.5 * skew(twists[:, 3:])
    result[:, :3, :3] -= turns
    result[:, 3:, 3:] -= turns
    result[:, :3, 3:] -= 0.5 * skew(twists[:, :3])
    return result


def optimise_poses(graph: PoseGraph, iterations: int, lever: float, stop: NDArray[np.bool_] | None = None) -> _Matrix:
    """Gauss-Newton on all poses that are not fixed, by sparse factors; the GIL is released while they are found.

    Args:
        graph: see `PoseGraph`; it is not changed.
        iterations: steps at most; a step that gains less than a thousandth is the last.
        lever: metres that a radian counts as.
        stop: (1,) set to True from another thread to end before the next step.

    Returns:
        (n, 4, 4) camera from world.
    """
    poses = graph.camera_from_world.copy()
    free = np.flatnonzero(~graph.is_fixed)
    row_of = np.full(len(poses), -1, np.int64)
    row_of[free] = np.arange(len(free))
    a, b = graph.pairs.T
    weights = graph.weights[:, None] * np.array([1.0, 1.0, 1.0, lever**2, lever**2, lever**2])
    b_from_a = inverses(graph.a_from_b)

    def errors(poses: _Matrix) -> tuple[_Matrix, _Matrix]:
        """Camera a from camera b as the poses have it, and by how much that is off, as a twist in camera a."""
        now = poses[a] @ inverses(poses[b])
        return now, logarithms(now @ b_from_a)

    now, twists = errors(poses)
    cost = float((weights * twists**2).sum())
    for _ in range(iterations if len(free) else 0):
        if stop is not None and stop[0]:
            break
        of_a = _inverse_jacobians(twists)
        of_b = -of_a @ _adjoints(now)
        weighed = [(weights[:, :, None] * jacobian).transpose(0, 2, 1) for jacobian in (of_a, of_b)]
        blocks = np.concatenate([left @ right for left in weighed for right in (of_a, of_b)])
        rows, columns = row_of[np.concatenate([a, a, b, b])], row_of[np.concatenate([a, b, a, b])]
        gradient = np.zeros((len(poses), 6))
        for end, left in ((a, weighed[0]), (b, weighed[1])):
            np.add.at(gradient, end, -(left @ twists[:, :, None])[:, :, 0])
        factors = splu(
            _sparse(blocks, rows, columns, len(free)),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
        steps = factors.solve(gradient[free].reshape(-1)).reshape(-1, 6)
        moved = poses.copy()
        for row, step in zip(free, steps, strict=True):
            moved[row] = exponential(step) @ poses[row]
            orthonormalise(moved[row])
        now, twists = errors(moved)
        new_cost = float((weights * twists**2).sum())
        if not new_cost < cost:
            break
        gained, cost, poses = cost - new_cost, new_cost, moved
        if gained < 1e-3 * cost:
            break
    return poses


def _sparse(blocks: _Matrix, rows: NDArray[np.int64], columns: NDArray[np.int64], count: int) -> csc_array:
    """Sum of 6×6 blocks (m, 6, 6) at rows and columns of blocks; those at -1 are left out."""
    inside = np.flatnonzero((rows >= 0) & (columns >= 0))
    order = inside[np.lexsort((columns[inside], rows[inside]))]
    starts = np.searchsorted(rows[order], np.arange(count + 1))
    system = bsr_array((blocks[order], columns[order], starts), shape=(6 * count, 6 * count)).tocsc()
    system.sum_duplicates()
    return system
