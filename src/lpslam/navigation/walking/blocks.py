"""A grid in squares: which parts of them hang together, and the way over these (after HPA*; Botea et al. 2004)."""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpslam.kernel_cache import provide_cache
from lpslam.navigation.walking.searching import DIAGONAL, ahead, pop, push, traced

provide_cache(__file__)


class Blocks(NamedTuple):
    """Squares of a grid, each with the parts into which walls divide it.

    Attributes:
        side: cells of a square's side.
        parts: (rows, columns) number of each cell's part, 0 where there is no room.
        square: (n, 2) row and column of the square of each part; n parts, the first stands for none.
        cost: (n,) of a step into the cheapest cell of each.
        first, others: (n + 1,) and (m,) parts beside each: those of part k are `others[first[k] : first[k + 1]]`.
    """

    side: int
    parts: NDArray[np.int32]
    square: NDArray[np.int32]
    cost: NDArray[np.float32]
    first: NDArray[np.int64]
    others: NDArray[np.int32]

    @classmethod
    def of(cls, cost: NDArray[np.float32], side: int) -> "Blocks":
        """Of the cost (rows, columns) of a step into each cell; infinite where there is no room."""
        parts, square, least = _parts(cost, side)
        pairs = _beside(parts, side)
        order = np.argsort(pairs[:, 0], kind="stable")
        first = np.searchsorted(pairs[order, 0], np.arange(len(square) + 1))
        return cls(side, parts, square, least, first, np.ascontiguousarray(pairs[order, 1]))

    def near(self, first: tuple[int, int], last: tuple[int, int]) -> NDArray[np.uint8] | None:
        """Squares (rows, columns) on and beside the cheapest way over parts between two cells; None without one."""
        rows, columns = (-(-side // self.side) for side in self.parts.shape)
        start, end = int(self.parts[first]), int(self.parts[last])
        way = _over(start, end, self.square, self.cost, self.first, self.others)
        if not len(way):
            return None
        near = np.zeros((rows + 2, columns + 2), np.uint8)
        for down in range(3):
            for across in range(3):
                near[self.square[way, 0] + down, self.square[way, 1] + across] = 1
        return np.ascontiguousarray(near[1:-1, 1:-1])


@njit(cache=True, nogil=True)
def _parts(cost: NDArray[np.float32], side: int) -> tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.float32]]:
    """`Blocks.parts`, `Blocks.square` and `Blocks.cost`."""
    rows, columns = cost.shape
    parts = np.zeros((rows, columns), np.int32)
    square, least = np.zeros((1024, 2), np.int32), np.zeros(1024, np.float32)
    stack = np.empty(side * side, np.int64)
    count = 1
    for top in range(0, rows, side):
        for left in range(0, columns, side):
            bottom, right = min(top + side, rows), min(left + side, columns)
            for i in range(top, bottom):
                for j in range(left, right):
                    if parts[i, j] != 0 or not np.isfinite(cost[i, j]):
                        continue
                    if count == len(least):
                        square = np.concatenate((square, np.zeros_like(square)))
                        least = np.concatenate((least, np.zeros_like(least)))
                    square[count, 0], square[count, 1], least[count] = top // side, left // side, cost[i, j]
                    parts[i, j], stack[0], size = count, i * columns + j, 1
                    while size:
                        size -= 1
                        a, b = stack[size] // columns, stack[size] % columns
                        least[count] = min(least[count], cost[a, b])
                        for way in range(4):
                            u, v = a + (way == 0) - (way == 1), b + (way == 2) - (way == 3)
                            inside = top <= u < bottom and left <= v < right
                            if inside and parts[u, v] == 0 and np.isfinite(cost[u, v]):
                                parts[u, v], stack[size] = count, u * columns + v
                                size += 1
                    count += 1
    return parts, square[:count].copy(), least[:count].copy()


@njit(cache=True, nogil=True)
def _beside(parts: NDArray[np.int32], side: int) -> NDArray[np.int32]:
    """(m, 2) pairs of parts that touch over the border of their squares, both ways round."""
    rows, columns = parts.shape
    pairs, count = np.empty((4096, 2), np.int32), 0
    for down in range(2):
        borders, along = ((rows - 1) // side, columns) if down else ((columns - 1) // side, rows)
        for border in range(1, borders + 1):
            one_before, other_before = 0, 0
            for k in range(along):
                at = border * side
                one, other = (parts[at - 1, k], parts[at, k]) if down else (parts[k, at - 1], parts[k, at])
                if one == 0 or other == 0 or (one == one_before and other == other_before):
                    continue
                one_before, other_before = one, other
                if count + 2 > len(pairs):
                    pairs = np.concatenate((pairs, np.empty_like(pairs)))
                pairs[count, 0], pairs[count, 1] = one, other
                pairs[count + 1, 0], pairs[count + 1, 1] = other, one
                count += 2
    return pairs[:count].copy()


@njit(cache=True, nogil=True)
def _over(
    start: int,
    end: int,
    square: NDArray[np.int32],
    cost: NDArray[np.float32],
    first: NDArray[np.int64],
    others: NDArray[np.int32],
) -> NDArray[np.int64]:
    """Parts (n,) from start to end, the cheapest in steps of squares; none where there is no way."""
    spent, parent = np.full(len(cost), np.inf, np.float32), np.full(len(cost), -1, np.int32)
    keys, parts, size = np.empty(1024, np.float32), np.empty(1024, np.int32), 0
    row, column = square[end, 0], square[end, 1]
    spent[start] = 0.0
    keys, parts, size = push(keys, parts, size, 0.0, start)
    while size:
        key, part = keys[0], parts[0]
        size = pop(keys, parts, size)
        if part == end:
            break
        left = ahead(square[part, 0], square[part, 1], row, column)
        if key > spent[part] + left + 1e-3:
            continue  # a cheaper way to it was found since
        for at in range(first[part], first[part + 1]):
            beside = others[at]
            # The part itself, then those beyond it that lie across a corner.
            for beyond in range(first[beside] - 1, first[beside + 1]):
                other = beside if beyond < first[beside] else others[beyond]
                down, across = abs(square[other, 0] - square[part, 0]), abs(square[other, 1] - square[part, 1])
                if other != beside and (down != 1 or across != 1):
                    continue
                step = (1.0 if other == beside else DIAGONAL) * 0.5 * (cost[part] + cost[other])
                total = float(np.float32(spent[part] + step))  # as it is kept: rounded up, it would seem cheaper again
                if total < spent[other]:
                    spent[other], parent[other] = total, part
                    left = ahead(square[other, 0], square[other, 1], row, column)
                    keys, parts, size = push(keys, parts, size, total + left, other)
    return traced(parent, start, end)
