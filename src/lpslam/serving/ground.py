"""What maps know of the ground: the occupancy grid, goal poses and ways. Older maps know nothing of it."""

import threading
from typing import Any, NoReturn

import cv2
import numpy as np

from lpslam.errors import UserError
from lpslam.ground.grid import FREE, OCCUPIED, Grid
from lpslam.serving.atlas import ServedMap
from lpslam.text.types import Landmark

Start = tuple[tuple[float, ...], float | None]
"""Metres, map frame, and degrees or None: where somebody stands."""

# Shades as ROS's map_server has them.
_FREE_SHADE, _OCCUPIED_SHADE, _UNKNOWN_SHADE = 254, 0, 205


class NoGroundError(UserError):
    """The map does not know where one can go."""


class _Grids:
    """The grids of maps, built when first asked for and kept for each version; safe in threads."""

    def __init__(self) -> None:
        self._building = threading.Lock()
        self._built: dict[str, tuple[str, Grid | None]] = {}

    def of(self, served: ServedMap) -> Grid | None:
        # One at a time: a flood must not have it built more than once.
        with self._building:
            version, grid = self._built.get(served.name, ("", None))
            if version != served.version:
                grid = served.world.grid()
                self._built[served.name] = served.version, grid
        return grid


_GRIDS = _Grids()


def has_ground(served: ServedMap) -> bool:
    """Whether the map has kept what a grid follows from."""
    scans = served.world.scans
    return scans is not None and len(scans) > 0


def has_ways(served: ServedMap) -> bool:
    """Whether ways over the ground are known."""
    return False


def goal(served: ServedMap, mark: Landmark, start: Start | None) -> dict[str, Any]:
    """Where to stand before a landmark, as `records.GoalRecord` has it.

    Raises:
        NoGroundError: that is not known.
    """
    refuse(served)


def path(served: ServedMap, mark: Landmark, start: Start | None) -> dict[str, Any]:
    """The way to a landmark, as `records.PathRecord` has it; raises as `goal`."""
    refuse(served)


def grid_facts(served: ServedMap) -> dict[str, Any]:
    """Where the occupancy grid lies, as `records.GridRecord` has it; raises as `goal`."""
    grid = _grid(served)
    rows, columns = grid.shape
    return {
        "map": served.name,
        "version": served.version,
        "width": columns,
        "height": rows,
        "resolution": grid.resolution,
        "origin": list(grid.origin),
        "free": int((grid.values == FREE).sum()),
        "occupied": int((grid.values == OCCUPIED).sum()),
    }


def grid_picture(served: ServedMap) -> bytes:
    """The occupancy grid as PNG, a pixel a cell, x to the right and y up; raises as `goal`."""
    values = _grid(served).values
    shades = np.full(values.shape, _UNKNOWN_SHADE, np.uint8)
    shades[values == FREE], shades[values == OCCUPIED] = _FREE_SHADE, _OCCUPIED_SHADE
    _, encoded = cv2.imencode(".png", np.ascontiguousarray(shades[::-1]))
    return encoded.tobytes()


def _grid(served: ServedMap) -> Grid:
    grid = _GRIDS.of(served) if has_ground(served) else None
    if grid is None:
        refuse(served)
    return grid


def refuse(served: ServedMap) -> NoReturn:
    """Say what is not known.

    Raises:
        NoGroundError: always.
    """
    if has_ground(served):
        raise NoGroundError("ways over the ground are not known; /ask gives the place and its distance")
    raise NoGroundError(
        f"map {served.name} has no ground: where one can go is not known; /ask gives the place and its distance"
    )
