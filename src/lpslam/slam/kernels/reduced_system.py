"""The Schur complement of a bundle adjustment: points are eliminated, and follow from the poses.

What an observation says of point and pose together is (o, 3, 6), `cross`; `measured` (o, 5) is as in `bundle.py`.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpslam.slam.kernels.linear import solve_blocks, solve_positive


@njit(cache=True, nogil=True, fastmath={"contract"})
def block_pattern(
    keyframe: NDArray[np.int32], starts: NDArray[np.int64], free: int, pairs: NDArray[np.int32]
) -> tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.int32]]:
    """Which two free keyframes share a point, or are a pair (t, 2) anyway.

    Returns:
        (free, free) the block of each pair, the lower row first, or -1; and row and column of each block, in order.
    """
    block_of = np.full((free, free), -1, np.int32)
    for k in range(free):
        block_of[k, k] = 0
    for j in range(starts.shape[0] - 1):
        for o in range(starts[j], starts[j + 1]):
            k = keyframe[o]
            if k < free:
                for q in range(starts[j], starts[j + 1]):
                    if k <= keyframe[q] < free:
                        block_of[k, keyframe[q]] = 0
    for t in range(pairs.shape[0]):
        if pairs[t, 0] < free and pairs[t, 1] < free:
            block_of[min(pairs[t, 0], pairs[t, 1]), max(pairs[t, 0], pairs[t, 1])] = 0
    count = 0
    for k in range(free):
        for l in range(k, free):  # noqa: E741
            count += block_of[k, l] + 1
    rows, columns = np.empty(count, np.int32), np.empty(count, np.int32)
    count = 0
    for k in range(free):
        for l in range(k, free):  # noqa: E741
            if block_of[k, l] == 0:
                block_of[k, l] = count
                rows[count], columns[count] = k, l
                count += 1
    return block_of, rows, columns


@njit(cache=True, nogil=True, fastmath={"contract"})
def invert_points(point_hessian: NDArray[np.float64], damping: float, inverse: NDArray[np.float64]) -> None:
    """Inverses of damped symmetric 3×3 matrices (p, 6); zero, so that the point stays, for a singular one."""
    for j in range(point_hessian.shape[0]):
        h, out = point_hessian[j], inverse[j]
        a, d, f = h[0] * (1 + damping) + 1e-9, h[3] * (1 + damping) + 1e-9, h[5] * (1 + damping) + 1e-9
        b, c, e = h[1], h[2], h[4]
        i00, i01, i02 = d * f - e * e, c * e - b * f, b * e - c * d
        determinant = a * i00 + b * i01 + c * i02
        s = 1.0 / determinant if determinant > 1e-30 else 0.0
        out[0], out[1], out[2] = i00 * s, i01 * s, i02 * s
        out[3], out[4], out[5] = (a * f - c * c) * s, (b * c - a * e) * s, (a * d - b * b) * s


@njit(cache=True, nogil=True, fastmath={"contract"})
def eliminate_points(
    measured: NDArray[np.float64],
    keyframe: NDArray[np.int32],
    starts: NDArray[np.int64],
    inverse: NDArray[np.float64],
    point_gradient: NDArray[np.float64],
    cross: NDArray[np.float64],
    block_of: NDArray[np.int32],
    blocks: NDArray[np.float64],
    right: NDArray[np.float64],
) -> None:
    """Subtract from the poses' equations what the points account for: the Schur complement, upper half."""
    free = right.shape[0]
    half = np.empty((3, 6))
    for j in range(inverse.shape[0]):
        m0, m1, m2 = inverse[j, 0], inverse[j, 1], inverse[j, 2]
        m3, m4, m5 = inverse[j, 3], inverse[j, 4], inverse[j, 5]
        g0, g1, g2 = point_gradient[j, 0], point_gradient[j, 1], point_gradient[j, 2]
        for o in range(starts[j], starts[j + 1]):
            k = np.intp(keyframe[o])
            if k >= free or measured[o, 3] == 0.0:
                continue
            for a in range(6):
                c0, c1, c2 = cross[o, 0, a], cross[o, 1, a], cross[o, 2, a]
                s0 = m0 * c0 + m1 * c1 + m2 * c2
                s1 = m1 * c0 + m3 * c1 + m4 * c2
                s2 = m2 * c0 + m4 * c1 + m5 * c2
                right[k, a] -= s0 * g0 + s1 * g1 + s2 * g2
                half[0, a], half[1, a], half[2, a] = s0, s1, s2
            for q in range(starts[j], starts[j + 1]):
                l = np.intp(keyframe[q])  # noqa: E741
                if l < k or l >= free or measured[q, 3] == 0.0:
                    continue
                i = np.intp(block_of[k, l])
                d00, d01, d02, d03, d04, d05 = (
                    cross[q, 0, 0],
                    cross[q, 0, 1],
                    cross[q, 0, 2],
                    cross[q, 0, 3],
                    cross[q, 0, 4],
                    cross[q, 0, 5],
                )
                d10, d11, d12, d13, d14, d15 = (
                    cross[q, 1, 0],
                    cross[q, 1, 1],
                    cross[q, 1, 2],
                    cross[q, 1, 3],
                    cross[q, 1, 4],
                    cross[q, 1, 5],
                )
                d20, d21, d22, d23, d24, d25 = (
                    cross[q, 2, 0],
                    cross[q, 2, 1],
                    cross[q, 2, 2],
                    cross[q, 2, 3],
                    cross[q, 2, 4],
                    cross[q, 2, 5],
                )
                for a in range(6):
                    s0, s1, s2 = half[0, a], half[1, a], half[2, a]
                    blocks[i, a, 0] -= s0 * d00 + s1 * d10 + s2 * d20
                    blocks[i, a, 1] -= s0 * d01 + s1 * d11 + s2 * d21
                    blocks[i, a, 2] -= s0 * d02 + s1 * d12 + s2 * d22
                    blocks[i, a, 3] -= s0 * d03 + s1 * d13 + s2 * d23
                    blocks[i, a, 4] -= s0 * d04 + s1 * d14 + s2 * d24
                    blocks[i, a, 5] -= s0 * d05 + s1 * d15 + s2 * d25


@njit(cache=True, nogil=True, fastmath={"contract"})
def moved_points(
    measured: NDArray[np.float64],
    keyframe: NDArray[np.int32],
    starts: NDArray[np.int64],
    inverse: NDArray[np.float64],
    point_gradient: NDArray[np.float64],
    cross: NDArray[np.float64],
    twists: NDArray[np.float64],
    points: NDArray[np.float64],
) -> NDArray[np.float64]:
    """(p, 3) points after a step, given that of the poses (free, 6)."""
    result = np.empty(points.shape)
    for j in range(points.shape[0]):
        g0, g1, g2 = point_gradient[j, 0], point_gradient[j, 1], point_gradient[j, 2]
        for o in range(starts[j], starts[j + 1]):
            k = keyframe[o]
            if k < twists.shape[0] and measured[o, 3] != 0.0:
                for b in range(6):
                    t = twists[k, b]
                    g0 -= cross[o, 0, b] * t
                    g1 -= cross[o, 1, b] * t
                    g2 -= cross[o, 2, b] * t
        m = inverse[j]
        result[j, 0] = points[j, 0] + m[0] * g0 + m[1] * g1 + m[2] * g2
        result[j, 1] = points[j, 1] + m[1] * g0 + m[3] * g1 + m[4] * g2
        result[j, 2] = points[j, 2] + m[2] * g0 + m[4] * g1 + m[5] * g2
    return result


@njit(cache=True, nogil=True, fastmath={"contract"})
def solve_reduced(
    blocks: NDArray[np.float64],
    rows: NDArray[np.int32],
    columns: NDArray[np.int32],
    right: NDArray[np.float64],
    dense: int,
    stop: NDArray[np.bool_],
) -> NDArray[np.float64]:
    """(free, 6) twists of the poses."""
    free = right.shape[0]
    if free > dense:
        return solve_blocks(blocks, rows, columns, right, 1e-6, 1000, stop)
    matrix = np.zeros((6 * free, 6 * free))
    for i in range(rows.shape[0]):
        k, l = 6 * rows[i], 6 * columns[i]  # noqa: E741
        for a in range(6):
            for b in range(6):
                matrix[k + a, l + b] = blocks[i, a, b]
    solution = right.copy().reshape(-1)
    if not solve_positive(matrix, solution):
        solution[:] = 0.0
    return solution.reshape(free, 6)
