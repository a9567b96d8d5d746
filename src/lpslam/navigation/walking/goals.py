"""Where a robot stands before a sign: on free ground that it can reach, facing it."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lpslam.ground.grid import FREE, OCCUPIED
from lpslam.navigation.walking.ways import NoWayError, Walkable

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Goal:
    """A pose on the ground.

    Attributes:
        position: (2,) metres, map frame.
        yaw: radians counter-clockwise from the map's x axis: which way the robot faces.
        is_before: whether it stands before the sign; else it is the nearest place that can be reached.
        missing: metres to the sign, seen from above.
        why: what keeps the robot from standing before the sign; empty where it does.
    """

    position: Array
    yaw: float
    is_before: bool
    missing: float
    why: str = ""


def goal_before(position: Array, normal: Array | None, walkable: Walkable, start: Array | None = None) -> Goal:
    """Where to stand to read a sign, or to enter below it.

    Args:
        position: (3,) of the sign, metres, map frame.
        normal: (3,) unit, out of the sign towards its readers; None where that is not known.
        walkable: the ground.
        start: (2 or 3,) from where it must be reached; from the largest part of the ground, without.

    Raises:
        NoWayError: there is no ground, or none to start from.
    """
    grid, config = walkable.grid, walkable.config
    if not walkable.largest:
        raise NoWayError("the map has no ground with room for the robot; map more of the floor")
    if not np.isfinite(position).all():
        raise NoWayError("where the sign hangs is not known; map it once more, from nearer by")
    storeys = grid.storeys_to(float(position[2])) if len(position) > 2 else 0
    if storeys:
        apart = f"{abs(storeys)} storey{'s' * (abs(storeys) > 1)} {'higher' if storeys > 0 else 'lower'}"
        raise NoWayError(
            f"the sign hangs {apart}, and no way there is known: ask for stairs or a lift, and again from there"
        )
    region = walkable.largest if start is None else int(walkable.regions[walkable.start(start)])
    sign = np.asarray(position[:2], np.float64)
    cells = _around(sign, walkable, region)
    middles = grid.middles(cells)
    offsets = middles - sign
    away = np.linalg.norm(offsets, axis=1)
    aside = _aside(offsets, away, normal)
    fits = (away >= config.goal_near) & (away <= config.goal_far) & (aside <= np.radians(config.goal_aside))
    score = np.abs(away - config.goal_best) + 0.5 * aside + 0.3 * (walkable.cost[cells[:, 0], cells[:, 1]] - 1.0)
    for row in np.flatnonzero(fits)[np.argsort(score[fits], kind="stable")]:
        if _sees(walkable, middles[row], sign):
            return _facing(middles[row], sign, True)
    nearest = walkable.nearest(sign, np.inf, region)
    if nearest is None:
        raise NoWayError("no ground can be reached from there; map more of the floor")
    return replace(_facing(grid.middles(np.array([nearest]))[0], sign, False), why=_why_short(sign, walkable, region))


def _why_short(sign: Array, walkable: Walkable, region: int) -> str:
    """What keeps the robot from standing before a sign, in words."""
    config, (top, left), (bottom, right) = walkable.config, *_window(sign, walkable)
    regions, free = walkable.regions[top:bottom, left:right], walkable.grid.values[top:bottom, left:right] == FREE
    if not free.any():
        return "no ground was seen before it; map it from nearer by"
    if not (regions > 0).any():
        return f"there is no room before it for a robot of {config.robot_radius:g} m radius"
    if not (regions == region).any():
        return "no way was seen to the ground before it; map the way between"
    return "something stands before it"


def _window(sign: Array, walkable: Walkable) -> tuple[tuple[int, int], tuple[int, int]]:
    """The first row and column of what lies near a sign, and those after the last."""
    reach = int(np.ceil(walkable.config.goal_far / walkable.grid.resolution)) + 1
    row, column = walkable.grid.cell(sign)
    return (max(row - reach, 0), max(column - reach, 0)), (max(row + reach + 1, 0), max(column + reach + 1, 0))


def _around(sign: Array, walkable: Walkable, region: int) -> NDArray[np.int64]:
    """Cells (n, 2) of a region near a sign."""
    (top, left), (bottom, right) = _window(sign, walkable)
    part = walkable.regions[top:bottom, left:right] == region
    return np.asarray(np.argwhere(part) + np.array([top, left]), np.int64)


def _aside(offsets: Array, away: Array, normal: Array | None) -> Array:
    """(n,) radians by which places lie to the side of straight before a sign."""
    flat = None if normal is None else np.asarray(normal[:2], np.float64)
    if flat is None or not np.isfinite(flat).all() or np.linalg.norm(flat) < 0.3:
        return np.zeros(len(away))
    ahead = offsets @ (flat / np.linalg.norm(flat)) / np.maximum(away, 1e-6)
    return np.asarray(np.arccos(np.clip(ahead, -1.0, 1.0)), np.float64)


def _sees(walkable: Walkable, place: Array, sign: Array) -> bool:
    """Whether nothing stands between a place and what hangs around a sign."""
    grid = walkable.grid
    away = float(np.linalg.norm(sign - place))
    steps = np.arange(0.0, max(away - _SIGN_DEPTH, 0.0), 0.5 * grid.resolution)
    points = place + steps[:, None] * (sign - place) / max(away, 1e-6)
    return not any(grid.at(point) == OCCUPIED for point in points)


def _facing(place: Array, sign: Array, is_before: bool) -> Goal:
    x, y = sign - place
    return Goal(place, float(np.arctan2(y, x)), is_before, float(np.hypot(x, y)))


_SIGN_DEPTH = 0.4
"""Metres before a sign that the thing on which it hangs may fill."""
