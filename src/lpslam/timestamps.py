"""Pairing of two streams by their timestamps."""

import numpy as np
from numpy.typing import NDArray

Times = NDArray[np.float64]
Indices = NDArray[np.int64]


def associate(first: Times, second: Times, tolerance: float = 0.02) -> tuple[Indices, Indices]:
    """Pair timestamps of two streams, each at most once, the closest pairs first.

    Args:
        first: (n,) seconds, in any order.
        second: (m,) seconds, in any order.
        tolerance: seconds; the largest difference within a pair.

    Returns:
        Rows of `first` and rows of `second`, (k,) each, pair by pair, in order of the first stream's time.
    """
    free_first, free_second = np.argsort(first, kind="stable"), np.argsort(second, kind="stable")
    pairs: list[tuple[Indices, Indices]] = []
    while len(free_first) and len(free_second):
        a, b = first[free_first], second[free_second]
        b_of_a, a_of_b = _nearest(a, b), _nearest(b, a)
        # A pair in which each is the other's nearest can be improved by no other pairing.
        mutual = (a_of_b[b_of_a] == np.arange(len(a))) & (np.abs(a - b[b_of_a]) <= tolerance)
        if not mutual.any():
            break
        pairs.append((free_first[mutual], free_second[b_of_a[mutual]]))
        taken = np.zeros(len(b), dtype=bool)
        taken[b_of_a[mutual]] = True
        free_first, free_second = free_first[~mutual], free_second[~taken]
    if not pairs:
        empty = np.zeros(0, dtype=np.int64)
        return empty, empty.copy()
    rows = np.concatenate([pair[0] for pair in pairs])
    columns = np.concatenate([pair[1] for pair in pairs])
    order = np.argsort(first[rows], kind="stable")
    return rows[order], columns[order]


def usual_tolerance(first: Times, second: Times, least: float, most: float) -> float:
    """Seconds within which pictures of two streams belong together: half of what lies between those of the faster one.

    Args:
        first, second: (n,), (m,) seconds, in any order.
        least, most: seconds; what is less than `least`, or not known yet, counts as `least`.
    """
    intervals = [np.diff(np.unique(times)) for times in (first, second)]
    if not all(map(len, intervals)):
        return least
    return max(least, min(most, min(float(np.median(each)) for each in intervals) / 2.0))


def _nearest(queries: Times, sorted_times: Times) -> Indices:
    """For each query the row of the nearest of `sorted_times`; the earlier of two equally near."""
    after = np.clip(np.searchsorted(sorted_times, queries), 1, max(len(sorted_times) - 1, 1))
    before = after - 1
    after = np.minimum(after, len(sorted_times) - 1)
    closer_after = np.abs(sorted_times[after] - queries) < np.abs(queries - sorted_times[before])
    return np.where(closer_after, after, before).astype(np.int64)
