"""Storeys that lie above one another: which scans are of one, so that a grid has one height to a place."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from lpslam.config import GroundConfig

Array = NDArray[np.float64]


def storeys_of(
    floors: Array, ground_of: Callable[[int], Array], config: GroundConfig
) -> tuple[Array, NDArray[np.int64]]:
    """Heights of storeys that lie above one another, lowest first, and which of them each scan is of.

    Floors of different heights that lie beside one another, as along a ramp, are one storey.

    Args:
        floors: (n,) height of the floor below each scan's camera.
        ground_of: of a scan, what it shows of the ground, (m, 3) world.
        config: thresholds.
    """
    levels = _levels(floors, config)
    of = np.asarray(np.abs(floors[:, None] - levels).argmin(axis=1), np.int64)
    if len(levels) == 1:
        return levels, of
    cells = [
        _cells([ground_of(at) for at in np.flatnonzero(of == level).tolist()], config) for level in range(len(levels))
    ]
    apart: list[int] = []
    one = np.arange(len(levels))
    for level, own in enumerate(cells):
        beside = [each for each in apart if not _lies_above(own, cells[each], config)]
        if len(beside) == len(apart) and apart:
            # It lies above none of them: it belongs to that of the nearest height.
            one[level] = min(apart, key=lambda each: abs(levels[each] - levels[level]))
        else:
            apart.append(level)
    return levels[apart], np.searchsorted(apart, one[of])


def _levels(floors: Array, config: GroundConfig) -> Array:
    """Heights at which floors are seen most often, a storey apart at least; lowest first."""
    support = (np.abs(floors[:, None] - floors) <= config.height_change).sum(axis=1)
    found: list[float] = []
    for row in np.argsort(-support, kind="stable"):
        is_apart = all(abs(floors[row] - each) >= config.storey_height for each in found)
        if is_apart and (not found or support[row] >= config.min_floor_share * len(floors)):
            found.append(float(floors[row]))
    return np.sort(found)


def _cells(grounds: list[Array], config: GroundConfig) -> set[tuple[int, int]]:
    """Large cells in which ground was seen."""
    points = np.concatenate([np.empty((0, 3)), *grounds])[:, :2]
    cells = np.unique(np.floor(points / (_LARGE * config.resolution)).astype(np.int64), axis=0)
    return {(int(column), int(row)) for column, row in cells}


def _lies_above(cells: set[tuple[int, int]], others: set[tuple[int, int]], config: GroundConfig) -> bool:
    """Whether ground of one storey lies above or below that of another."""
    return len(cells & others) > config.storey_overlap * max(min(len(cells), len(others)), 1)


_LARGE = 10
"""Cells of the grid to a side of one of those that are compared: half a metre."""
