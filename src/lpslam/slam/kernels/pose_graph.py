"""Pose graph: keyframe poses that agree best with measured relative poses (ORB-SLAM, VII-D, on SE(3))."""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.sparse import bsr_array
from scipy.sparse.linalg import splu

from lpslam.slam.kernels.geometry import exponential, inverse, orthonormalise


class PoseGraph(NamedTuple):
    """Poses and the relative poses between them; n poses, e edges.

    Attributes:
        camera_from_world: (n, 4, 4).
        is_fixed: (n,) which poses hold the frame; at least one in every connected part.
        pairs: (e, 2) rows a, b of `camera_from_world`.
        a_from_b: (e, 4, 4) measured, camera a from camera b.
        weights: (e,) how much each edge counts.
    """

    camera_from_world: NDArray[np.float64]
    is_fixed: NDArray[np.bool_]
    pairs: NDArray[np.int32]
    a_from_b: NDArray[np.float64]
    weights: NDArray[np.float64]


@njit(cache=True, nogil=True)
def logarithm(transform: NDArray[np.float64], twist: NDArray[np.float64]) -> None:
    """Write the twist (translation, rotation vector) of a rigid 4×4 transform: the inverse of `exponential`.

    Turns are those of at most half a revolution; near it the axis loses its sign.
    """
    t = transform
    x, y, z = 0.5 * (t[2, 1] - t[1, 2]), 0.5 * (t[0, 2] - t[2, 0]), 0.5 * (t[1, 0] - t[0, 1])
    sine = math.sqrt(x * x + y * y + z * z)
    cosine = 0.5 * (t[0, 0] + t[1, 1] + t[2, 2] - 1.0)
    theta = math.atan2(sine, cosine)
    if sine > 1e-9:
        factor = theta / sine
        # The coefficient of the squared rotation vector in the inverse of the left Jacobian.
        rest = (1.0 - 0.5 * theta * sine / (1.0 - cosine)) / (theta * theta) if theta > 1e-3 else 1.0 / 12.0
    else:
        factor, rest = 1.0, 1.0 / 12.0
    x, y, z = factor * x, factor * y, factor * z
    twist[3], twist[4], twist[5] = x, y, z
    # ω × t and ω × (ω × t).
    p, q, r = t[0, 3], t[1, 3], t[2, 3]
    cx, cy, cz = y * r - z * q, z * p - x * r, x * q - y * p
    twist[0] = p - 0.5 * cx + rest * (y * cz - z * cy)
    twist[1] = q - 0.5 * cy + rest * (z * cx - x * cz)
    twist[2] = r - 0.5 * cz + rest * (x * cy - y * cx)


@njit(cache=True, nogil=True)
def _adjoint(transform: NDArray[np.float64]) -> NDArray[np.float64]:
    """6×6 matrix that carries a twist (translation, rotation) over a transform."""
    result = np.zeros((6, 6))
    x, y, z = transform[0, 3], transform[1, 3], transform[2, 3]
    for a in range(3):
        r0, r1, r2 = transform[0, a], transform[1, a], transform[2, a]
        for b in range(3):
            result[b, a] = transform[b, a]
            result[3 + b, 3 + a] = transform[b, a]
        result[0, 3 + a] = y * r2 - z * r1
        result[1, 3 + a] = z * r0 - x * r2
        result[2, 3 + a] = x * r1 - y * r0
    return result


@njit(cache=True, nogil=True)
def _half_bracket(e: NDArray[np.float64]) -> NDArray[np.float64]:
    """6×6 inverse left Jacobian of SE(3) to first order: one minus half the bracket with e."""
    result = np.eye(6)
    for block in range(2):
        for half in range(2):
            # Rows: translation, rotation; the translation part enters only above the rotation's columns.
            if block == 1 and half == 0:
                continue
            v = e[3:] if block == half else e[:3]
            row, column = 3 * block, 3 * half
            result[row, column + 1] += 0.5 * v[2]
            result[row, column + 2] -= 0.5 * v[1]
            result[row + 1, column] -= 0.5 * v[2]
            result[row + 1, column + 2] += 0.5 * v[0]
            result[row + 2, column] += 0.5 * v[1]
            result[row + 2, column + 1] -= 0.5 * v[0]
    return result


@njit(cache=True, nogil=True)
def _error(graph: PoseGraph, poses: NDArray[np.float64], edge: int, twist: NDArray[np.float64]) -> NDArray[np.float64]:
    """Write by how much an edge is off, as a twist in camera a; returns camera a from camera b as the poses have it."""
    now: NDArray[np.float64] = poses[graph.pairs[edge, 0]] @ inverse(poses[graph.pairs[edge, 1]])
    logarithm(now @ inverse(graph.a_from_b[edge]), twist)
    return now


@njit(cache=True, nogil=True)
def _cost(graph: PoseGraph, poses: NDArray[np.float64], scales: NDArray[np.float64]) -> float:
    twist = np.empty(6)
    cost = 0.0
    for edge in range(graph.pairs.shape[0]):
        _error(graph, poses, edge, twist)
        for a in range(6):
            cost += graph.weights[edge] * scales[a] * twist[a] ** 2
    return cost


@njit(cache=True, nogil=True)
def _linearise(
    graph: PoseGraph, poses: NDArray[np.float64], scales: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Normal equations in blocks: poses (n, 6, 6), edges (e, 6, 6) for rows of a and columns of b, gradient (n, 6)."""
    nodes, edges = poses.shape[0], graph.pairs.shape[0]
    diagonal, off, gradient = np.zeros((nodes, 6, 6)), np.zeros((edges, 6, 6)), np.zeros((nodes, 6))
    twist = np.empty(6)
    for edge in range(edges):
        a, b = graph.pairs[edge, 0], graph.pairs[edge, 1]
        now = _error(graph, poses, edge, twist)
        of_a = _half_bracket(twist)
        of_b = -(of_a @ _adjoint(now))
        for k in range(6):
            weight = graph.weights[edge] * scales[k]
            for i in range(6):
                gradient[a, i] -= weight * of_a[k, i] * twist[k]
                gradient[b, i] -= weight * of_b[k, i] * twist[k]
                for j in range(6):
                    diagonal[a, i, j] += weight * of_a[k, i] * of_a[k, j]
                    diagonal[b, i, j] += weight * of_b[k, i] * of_b[k, j]
                    off[edge, i, j] += weight * of_a[k, i] * of_b[k, j]
    return diagonal, off, gradient


@njit(cache=True, nogil=True)
def _moved(poses: NDArray[np.float64], rows: NDArray[np.int64], twists: NDArray[np.float64]) -> NDArray[np.float64]:
    moved = poses.copy()
    for i in range(rows.shape[0]):
        moved[rows[i]] = exponential(twists[i]) @ poses[rows[i]]
        orthonormalise(moved[rows[i]])
    return moved


def optimise_poses(
    graph: PoseGraph, iterations: int, lever: float, stop: NDArray[np.bool_] | None = None
) -> NDArray[np.float64]:
    """Gauss-Newton on all poses that are not fixed, by sparse Cholesky-like factors; the GIL is released in them.

    Args:
        graph: see `PoseGraph`; it is not changed.
        iterations: steps at most; a step that gains less than a thousandth is the last.
        lever: metres that a radian counts as.
        stop: (1,) set to True from another thread to end before the next step.

    Returns:
        (n, 4, 4) camera from world.
    """
    poses = graph.camera_from_world.copy()
    rows = np.flatnonzero(~graph.is_fixed)
    column_of = np.full(len(poses), -1, np.int64)
    column_of[rows] = np.arange(len(rows))
    between = np.flatnonzero((column_of[graph.pairs] >= 0).all(axis=1))
    a, b = column_of[graph.pairs[between]].T
    block_rows, block_columns = (
        np.concatenate([np.arange(len(rows)), a, b]),
        np.concatenate([np.arange(len(rows)), b, a]),
    )
    order = np.lexsort((block_columns, block_rows))
    starts = np.searchsorted(block_rows[order], np.arange(len(rows) + 1))
    scales = np.array([1.0, 1.0, 1.0, lever**2, lever**2, lever**2])
    cost = _cost(graph, poses, scales)
    for _ in range(iterations if len(rows) else 0):
        if stop is not None and stop[0]:
            break
        diagonal, off, gradient = _linearise(graph, poses, scales)
        blocks = np.concatenate([diagonal[rows], off[between], off[between].transpose(0, 2, 1)])[order]
        size = 6 * len(rows)
        system = bsr_array((blocks, block_columns[order], starts), shape=(size, size)).tocsc()
        system.sum_duplicates()
        factors = splu(system, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        twists = factors.solve(gradient[rows].reshape(-1)).reshape(-1, 6)
        moved = _moved(poses, rows, twists)
        new_cost = _cost(graph, moved, scales)
        if not new_cost < cost:
            break
        gained, cost, poses = cost - new_cost, new_cost, moved
        if gained < 1e-3 * cost:
            break
    return poses


@njit(cache=True, nogil=True)
def covisible_pairs(
    head: NDArray[np.int32],
    point: NDArray[np.int32],
    next_observation: NDArray[np.int32],
    keyframe_slot: NDArray[np.int32],
    slot_keyframe: NDArray[np.int32],
    least: int,
) -> NDArray[np.int32]:
    """(e, 2) pairs of keyframes, the earlier first, that share at least so many points.

    Args:
        head: (P,) first observation of each point.
        point, next_observation: (S, F) see `MapColumns`.
        keyframe_slot: (K,).
        slot_keyframe: (S,).
        least: shared points.
    """
    capacity = point.shape[1]
    keyframes = keyframe_slot.shape[0]
    pairs = np.empty((max(8 * keyframes, 16), 2), np.int32)
    count = 0
    shared = np.zeros(keyframes, np.int32)
    touched = np.empty(keyframes, np.int32)
    for k in range(keyframes):
        if keyframe_slot[k] < 0:
            continue
        n = 0
        for f in range(capacity):
            p = point[keyframe_slot[k], f]
            o = head[p] if p >= 0 else -1
            while o >= 0:
                slot = o // capacity
                other = slot_keyframe[slot]
                if other > k:
                    if shared[other] == 0:
                        touched[n] = other
                        n += 1
                    shared[other] += 1
                o = next_observation[slot, o % capacity]
        for i in range(n):
            other = touched[i]
            if shared[other] >= least:
                if count == pairs.shape[0]:
                    grown = np.empty((2 * count, 2), np.int32)
                    grown[:count] = pairs
                    pairs = grown
                pairs[count, 0], pairs[count, 1] = k, other
                count += 1
            shared[other] = 0
    return pairs[:count].copy()
