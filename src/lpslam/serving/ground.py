"""What maps know of the ground: the occupancy grid, goal poses and ways. Older maps know nothing of it."""

import threading
from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np

from lpslam.config import Config
from lpslam.errors import UserError
from lpslam.ground.grid import FREE, OCCUPIED, Grid, trinary
from lpslam.navigation.walking.goals import Goal
from lpslam.navigation.walking.routes import Leg, route_through, told_legs
from lpslam.navigation.walking.storeys import Building
from lpslam.navigation.walking.ways import NoWayError
from lpslam.serving.atlas import ServedMap
from lpslam.text.types import Landmark

Start = tuple[tuple[float, ...], float | None]
"""Metres, map frame, and degrees or None: where somebody stands."""


class NoGroundError(UserError):
    """The map does not know where one can go."""


class Grounds:
    """The ground of maps, made when it is first asked for and kept for each version; safe in threads.

    Args:
        config: how the ground is seen, and the robot.
    """

    def __init__(self, config: Config) -> None:
        self._config = config
        self._making = threading.Lock()
        self._made: dict[str, tuple[str, Building | None]] = {}

    @staticmethod
    def has(served: ServedMap) -> bool:
        """Whether a map has kept what its ground follows from; the floor may still have been out of sight."""
        scans = served.world.scans
        return scans is not None and len(scans) > 0

    def goal(self, served: ServedMap, mark: Landmark, start: Start | None) -> dict[str, Any]:
        """Where to stand before a landmark, as `records.GoalRecord` has it.

        Raises:
            NoGroundError: the map has no ground.
            NoWayError: nothing can be reached from there.
        """
        here, _ = _start(served, start)
        goal, _ = self._building(served).to_sign(here, mark.position, mark.normal)
        return _goal_record(served, mark, goal)

    def path(
        self, served: ServedMap, marks: Sequence[Landmark], start: Start | None, language: str = "en"
    ) -> dict[str, Any]:
        """The way through landmarks in their order, as `records.PathRecord` has it, told in a language.

        Raises:
            NoGroundError, NoWayError: as `goal`.
        """
        here, heading = _start(served, start)
        legs = route_through(here, marks, self._building(served))
        told = told_legs(legs, served.directory.landmarks, language, heading)
        parts = [_leg_record(served, leg, steps) for leg, steps in zip(legs, told, strict=True)]
        return parts[-1] | {
            "points": parts[0]["points"] + [point for part in parts[1:] for point in part["points"][1:]],
            "length": round(sum(leg.way.length for leg in legs), 2),
            "seconds": round(sum(leg.way.seconds for leg in legs), 1),
            "steps": [step for steps in told for step in steps],
            "legs": parts,
        }

    def facts(self, served: ServedMap) -> dict[str, Any]:
        """Where the occupancy grid lies, as `records.GridRecord` has it; raises as `goal`.

        Of several storeys it is of that on which the map ends.
        """
        grid = self._grid(served)
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

    def picture(self, served: ServedMap) -> bytes:
        """The occupancy grid as PNG, a pixel a cell, x to the right and y up; raises as `goal`."""
        _, encoded = cv2.imencode(".png", trinary(self._grid(served).values))
        return encoded.tobytes()

    def _grid(self, served: ServedMap) -> Grid:
        return self._building(served).ground_at(served.view[0]).grid

    def _building(self, served: ServedMap) -> Building:
        if not self.has(served):
            raise NoGroundError(
                f"map {served.name} has no ground: where one can go is not known; /ask gives the place and its distance"
            )
        # One at a time: a flood must not have it made more than once.
        with self._making:
            version, building = self._made.get(served.name, ("", None))
            if version != served.version:
                grids = served.world.grids(self._config.ground)
                carried = served.world.frame_poses().positions
                building = Building(grids, carried, self._config) if grids else None
                self._made[served.name] = served.version, building
        if building is None:
            raise NoGroundError(f"map {served.name} has no ground: no floor was seen when it was made")
        return building


def _start(served: ServedMap, start: Start | None) -> tuple[np.ndarray[Any, np.dtype[np.float64]], float | None]:
    """Where somebody stands, and the heading in radians; where the camera was last, if nobody says."""
    if start is None:
        return served.view[0], served.view[1]
    place, heading = start
    here = np.array([*place, *served.view[0][len(place) :]], dtype=np.float64)
    return here, None if heading is None else float(np.radians(heading))


def _goal_record(served: ServedMap, mark: Landmark, goal: Goal) -> dict[str, Any]:
    return {
        "map": served.name,
        "version": served.version,
        "landmark": mark.id,
        "name": mark.name,
        "position": _rounded(goal.position),
        "heading": round(float(np.degrees(goal.yaw)) % 360.0, 2),
        "is_before_the_sign": goal.is_before,
        "missing": round(goal.missing, 2),
    }


def _leg_record(served: ServedMap, leg: Leg, steps: Sequence[str]) -> dict[str, Any]:
    return _goal_record(served, leg.landmark, leg.goal) | {
        "points": [_rounded(point) for point in leg.way.points],
        "length": round(leg.way.length, 2),
        "seconds": round(leg.way.seconds, 1),
        "steps": list(steps),
    }


def _rounded(point: np.ndarray[Any, np.dtype[np.float64]]) -> list[float]:
    return [round(float(value), 3) for value in point]


__all__ = ["Grounds", "NoGroundError", "NoWayError", "Start"]
