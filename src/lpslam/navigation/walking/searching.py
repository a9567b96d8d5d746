"""Shortest ways over cells (A*; Hart, Nilsson and Raphael 1968), as kernels."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpslam.kernel_cache import provide_cache

provide_cache(__file__)

DIAGONAL = math.sqrt(2.0)
_EAGER = 1.03
"""How much what is left is made of: a way is 3 % too long at most, and open ground is crossed, not flooded."""


@njit(cache=True, nogil=True)
def cheapest(cost: NDArray[np.float32], start: int, end: int, near: NDArray[np.uint8], side: int) -> NDArray[np.int64]:
    """Cells (n,) from start to end, numbered row by row; none where there is no way.

    Args:
        cost: (rows, columns) of a step into a cell, 1 at least; infinite where nobody can go.
        start, end: cells.
        near: squares of so many cells to a side that may be entered, where it is not 0.
        side: of these squares, cells.
    """
    rows, columns = cost.shape
    flat = cost.ravel()
    spent, parent = _unvisited(rows, columns, near, side)
    keys, cells, size = np.empty(1024, np.float32), np.empty(1024, np.int32), 0
    row, column = end // columns, end % columns
    spent[start] = 0.0
    keys, cells, size = push(keys, cells, size, 0.0, start)
    while size:
        key, cell = keys[0], cells[0]
        size = pop(keys, cells, size)
        if cell == end:
            break
        i, j = cell // columns, cell % columns
        if key > spent[cell] + ahead(i, j, row, column) + 1e-3:
            continue  # a cheaper way to it was found since
        for di in range(-1, 2):
            for dj in range(-1, 2):
                a, b = i + di, j + dj
                if (di == 0 and dj == 0) or a < 0 or b < 0 or a >= rows or b >= columns:
                    continue
                other = a * columns + b
                if math.isinf(flat[other]) or near[a // side, b // side] == 0:
                    continue
                # No cutting of corners.
                if di != 0 and dj != 0 and (math.isinf(cost[i, b]) or math.isinf(cost[a, j])):
                    continue
                step = (DIAGONAL if di != 0 and dj != 0 else 1.0) * 0.5 * (flat[cell] + flat[other])
                total = float(np.float32(spent[cell] + step))  # as it is kept: rounded up, it would seem cheaper again
                if total < spent[other]:
                    spent[other], parent[other] = total, cell
                    keys, cells, size = push(keys, cells, size, total + ahead(a, b, row, column), other)
    return traced(parent, start, end)


@njit(cache=True, nogil=True)
def traced(parent: NDArray[np.int32], start: int, end: int) -> NDArray[np.int64]:
    """The way (n,) from start to end by what each was reached from; none where the end was not reached."""
    if end != start and parent[end] < 0:
        return np.empty(0, np.int64)
    length, cell = 1, end
    while cell != start:
        cell = parent[cell]
        length += 1
    way = np.empty(length, np.int64)
    cell = end
    for at in range(length - 1, -1, -1):
        way[at] = cell
        cell = parent[cell]
    return way


@njit(cache=True, nogil=True)
def _unvisited(
    rows: int, columns: int, near: NDArray[np.uint8], side: int
) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    """What was spent on the way to each cell and from where, of those that may be entered; the rest is not touched."""
    spent, parent = np.empty(rows * columns, np.float32), np.empty(rows * columns, np.int32)
    for p in range(near.shape[0]):
        for q in range(near.shape[1]):
            if near[p, q] == 0:
                continue
            left, right = q * side, min((q + 1) * side, columns)
            for i in range(p * side, min((p + 1) * side, rows)):
                for cell in range(i * columns + left, i * columns + right):
                    spent[cell], parent[cell] = np.inf, -1
    return spent, parent


@njit(cache=True, nogil=True)
def ahead(i: int, j: int, row: int, column: int) -> float:
    """What is left in steps from a cell to another one, all but at least."""
    down, across = abs(i - row), abs(j - column)
    return _EAGER * (max(down, across) + (DIAGONAL - 1.0) * min(down, across))


@njit(cache=True, nogil=True)
def push(
    keys: NDArray[np.float32], cells: NDArray[np.int32], size: int, key: float, cell: int
) -> tuple[NDArray[np.float32], NDArray[np.int32], int]:
    """Add to a binary heap."""
    if size == len(keys):
        keys, cells = np.concatenate((keys, np.empty_like(keys))), np.concatenate((cells, np.empty_like(cells)))
    at = size
    while at > 0:
        above = (at - 1) >> 1
        if keys[above] <= key:
            break
        keys[at], cells[at] = keys[above], cells[above]
        at = above
    keys[at], cells[at] = key, cell
    return keys, cells, size + 1


@njit(cache=True, nogil=True)
def pop(keys: NDArray[np.float32], cells: NDArray[np.int32], size: int) -> int:
    """Take the least away from a binary heap; its new size."""
    size -= 1
    key, cell = keys[size], cells[size]
    at = 0
    while True:
        below = 2 * at + 1
        if below >= size:
            break
        if below + 1 < size and keys[below + 1] < keys[below]:
            below += 1
        if keys[below] >= key:
            break
        keys[at], cells[at] = keys[below], cells[below]
        at = below
    keys[at], cells[at] = key, cell
    return size


@njit(cache=True, nogil=True)
def is_clear(cost: NDArray[np.float32], start: NDArray[np.float64], end: NDArray[np.float64], most: float) -> bool:
    """Whether a straight way between two places, in cells (row, column), enters none that costs more than `most`."""
    rows, columns = cost.shape
    steps = int(2.0 * max(abs(end[0] - start[0]), abs(end[1] - start[1]))) + 1
    for step in range(steps + 1):
        i = int(start[0] + step / steps * (end[0] - start[0]))
        j = int(start[1] + step / steps * (end[1] - start[1]))
        if i < 0 or j < 0 or i >= rows or j >= columns or cost[i, j] > most:
            return False
    return True
