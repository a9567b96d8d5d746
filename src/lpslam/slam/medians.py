"""Medians of what is not equally sure, and of many groups at once."""

import numpy as np
from numpy.typing import NDArray


def weighted_median(values: NDArray[np.float64], weights: NDArray[np.float64]) -> float:
    """The value on both sides of which half of the weight lies."""
    order = np.argsort(values)
    reached = np.cumsum(weights[order])
    return float(values[order[np.searchsorted(reached, 0.5 * reached[-1])]])


def medians_of_groups(values: NDArray[np.float64], groups: NDArray[np.int64]) -> NDArray[np.float64]:
    """(g,) medians of values (n,) whose `groups` (n,) are counted from 0 to g - 1, each of which has some."""
    ordered = values[np.lexsort((values, groups))]
    counts = np.bincount(groups)
    first = np.cumsum(counts) - counts
    return np.asarray(0.5 * (ordered[first + (counts - 1) // 2] + ordered[first + counts // 2]), np.float64)
