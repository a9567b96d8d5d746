"""Solving symmetric positive systems: dense by elimination, block-sparse by conjugate gradients."""

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True, nogil=True, fastmath={"contract"})
def solve_positive(matrix: NDArray[np.float64], right: NDArray[np.float64]) -> bool:
    """Solve a symmetric positive definite system in place, by LDLᵀ; zeros left of the first non-zero cost nothing.

    Args:
        matrix: (n, n) of which only the upper triangle is read; destroyed.
        right: (n,) becomes the solution.

    Returns:
        False if the matrix is not positive definite; `right` is then undefined.
    """
    n = right.shape[0]
    for k in range(n):
        pivot = matrix[k, k]
        if not pivot > 0.0:
            return False
        s = 1.0 / pivot
        for i in range(k + 1, n):
            factor = matrix[k, i] * s
            if factor != 0.0:
                row, above = matrix[i], matrix[k]
                for j in range(i, n):
                    row[j] -= factor * above[j]
                right[i] -= factor * right[k]
    for k in range(n - 1, -1, -1):
        total = right[k]
        for i in range(k + 1, n):
            total -= matrix[k, i] * right[i]
        right[k] = total / matrix[k, k]
    return True


@njit(cache=True, nogil=True, fastmath={"contract"})
def _apply_blocks(
    blocks: NDArray[np.float64],
    rows: NDArray[np.int32],
    columns: NDArray[np.int32],
    x: NDArray[np.float64],
    out: NDArray[np.float64],
) -> None:
    """Write the product S x, for a symmetric S of 6×6 blocks of which the upper half is stored."""
    out[:] = 0.0
    for i in range(rows.shape[0]):
        r, c, block = rows[i], columns[i], blocks[i]
        for a in range(6):
            total = 0.0
            for b in range(6):
                total += block[a, b] * x[c, b]
            out[r, a] += total
        if r != c:
            for a in range(6):
                factor = x[r, a]
                for b in range(6):
                    out[c, b] += block[a, b] * factor


@njit(cache=True, nogil=True, fastmath={"contract"})
def solve_blocks(
    blocks: NDArray[np.float64],
    rows: NDArray[np.int32],
    columns: NDArray[np.int32],
    right: NDArray[np.float64],
    tolerance: float,
    iterations: int,
    stop: NDArray[np.bool_],
) -> NDArray[np.float64]:
    """Solve a symmetric positive definite system of 6×6 blocks by conjugate gradients, preconditioned by its diagonal.

    Args:
        blocks: (b, 6, 6) of the upper half, whole blocks on the diagonal.
        rows, columns: (b,) where they stand.
        right: (n, 6).
        tolerance: of the residual's norm under the preconditioner, relative to that of `right`.
        iterations: at most.
        stop: (1,) set to True from another thread to return what is found so far.

    Returns:
        (n, 6) the solution, as near as the iterations came.
    """
    n = right.shape[0]
    scale = np.zeros((n, 6, 6))
    column = np.empty(6)
    for i in range(rows.shape[0]):
        if rows[i] == columns[i]:
            for a in range(6):
                column[:] = 0.0
                column[a] = 1.0
                solve_positive(blocks[i].copy(), column)
                for b in range(6):
                    scale[rows[i], a, b] = column[b]
    x, residual, product = np.zeros((n, 6)), right.copy(), np.empty((n, 6))
    scaled, direction = np.zeros((n, 6)), np.zeros((n, 6))
    before, goal = 0.0, 0.0
    for turn in range(iterations):
        if stop[0]:
            break
        now = 0.0
        for k in range(n):
            for a in range(6):
                total = 0.0
                for b in range(6):
                    total += scale[k, a, b] * residual[k, b]
                scaled[k, a] = total
                now += total * residual[k, a]
        if turn == 0:
            goal = tolerance * tolerance * now
        if now <= goal:
            break
        ratio = now / before if turn > 0 else 0.0
        for k in range(n):
            for a in range(6):
                direction[k, a] = scaled[k, a] + ratio * direction[k, a]
        _apply_blocks(blocks, rows, columns, direction, product)
        curvature = 0.0
        for k in range(n):
            for a in range(6):
                curvature += direction[k, a] * product[k, a]
        if not curvature > 0.0:
            break
        length = now / curvature
        for k in range(n):
            for a in range(6):
                x[k, a] += length * direction[k, a]
                residual[k, a] -= length * product[k, a]
        before = now
    return x
