"""Shortest ways over cells (A*; Hart, Nilsson and Raphael 1968), as kernels."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpslam.kernel_cache import provide_cache

provide_cache(__file__)

_DIAGONAL = math.sqrt(2.0)
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
    spent = np.full(flat.size, np.inf, np.float32)
    parent = np.full(flat.size, -1, np.int32)
    keys, cells, size = np.empty(1024, np.float32), np.empty(1024, np.int32), 0
    row, column = end // columns, end % columns
    spent[start] = 0.0
    keys, cells, size = _push(keys, cells, size, _ahead(start, row, column, columns), start)
    while size:
        key, cell = keys[0], cells[0]
        size = _pop(keys, cells, size)
        if cell == end:
            break
        i, j = cell // columns, cell % columns
        if key > spent[cell] + _ahead(cell, row, column, columns) + 1e-3:
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
                step = (_DIAGONAL if di != 0 and dj != 0 else 1.0) * 0.5 * (flat[cell] + flat[other])
                total = spent[cell] + step
                if total < spent[other]:
                    spent[other], parent[other] = total, cell
                    keys, cells, size = _push(keys, cells, size, total + _ahead(other, row, column, columns), other)
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
def _ahead(cell: int, row: int, column: int, columns: int) -> float:
    """What is left in steps, all but at least."""
    down, across = abs(cell // columns - row), abs(cell % columns - column)
    return _EAGER * (max(down, across) + (_DIAGONAL - 1.0) * min(down, across))


@njit(cache=True, nogil=True)
def _push(
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
def _pop(keys: NDArray[np.float32], cells: NDArray[np.int32], size: int) -> int:
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
