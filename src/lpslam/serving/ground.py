"""What maps know of the ground: goal poses, ways and the occupancy grid. Most maps know nothing of it."""

from typing import Any, NoReturn

from lpslam.errors import UserError
from lpslam.serving.atlas import ServedMap
from lpslam.text.types import Landmark

Start = tuple[tuple[float, ...], float | None]
"""Metres, map frame, and degrees or None: where somebody stands."""


class NoGroundError(UserError):
    """The map has no ground to go on."""


def has_ground(served: ServedMap) -> bool:
    """Whether the map knows where one can go."""
    return False


def goal(served: ServedMap, mark: Landmark, start: Start | None) -> dict[str, Any]:
    """Where to stand before a landmark, as `records.GoalRecord` has it.

    Raises:
        NoGroundError: the map has no ground.
    """
    refuse(served)


def path(served: ServedMap, mark: Landmark, start: Start | None) -> dict[str, Any]:
    """The way to a landmark, as `records.PathRecord` has it; raises as `goal`."""
    refuse(served)


def grid_picture(served: ServedMap) -> bytes:
    """The occupancy grid as PNG; raises as `goal`."""
    refuse(served)


def refuse(served: ServedMap) -> NoReturn:
    """Say that a map has no ground.

    Raises:
        NoGroundError: always.
    """
    raise NoGroundError(
        f"map {served.name} has no ground: where one can go is not known; /ask gives the place and its distance"
    )
