"""The ground of a map of several storeys, and the stairs and ramps on which the camera was carried between them."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from heapq import heappop, heappush
from itertools import count

import numpy as np
from numpy.typing import NDArray

from lpslam.config import Config
from lpslam.ground.grid import Grid
from lpslam.navigation.walking.goals import Goal, goal_before
from lpslam.navigation.walking.ways import Climb, NoWayError, Walkable, Way
from lpslam.text.types import Landmark

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Passage:
    """A way between two storeys on which the camera was carried.

    Attributes:
        begin, end: the storeys, counted from the lowest one.
        points: (n, 2) metres, map frame.
    """

    begin: int
    end: int
    points: Array

    @property
    def length(self) -> float:
        """Metres, seen from above."""
        return float(np.linalg.norm(np.diff(self.points, axis=0), axis=1).sum())

    def reversed(self) -> "Passage":
        """The way back."""
        return Passage(self.end, self.begin, self.points[::-1])


class Building:
    """The ground of all storeys of a map.

    Args:
        grids: one a storey, lowest first.
        carried: (n, 3) metres, map frame, where the camera was, in order of time.
        config: the robot, and how high cameras are carried.

    Attributes:
        grounds: by storey, where there is room.
        passages: from any storey to another one, each both ways.
    """

    def __init__(self, grids: Sequence[Grid], carried: Array, config: Config) -> None:
        self.grounds = {grid.storey: Walkable(grid, config.ways) for grid in grids}
        self._speed = config.ways.speed
        found = list(self._passages(carried, config)) if len(grids) > 1 else []
        self.passages = [*found, *(passage.reversed() for passage in found)]

    def storey_at(self, height: float) -> int:
        """On which storey something is at a height, metres."""
        grid = next(iter(self.grounds.values())).grid
        return grid.storey + grid.storeys_to(height)

    def storey_of(self, mark: Landmark) -> int | None:
        """On which storey a sign hangs; None where its place is not known."""
        return self.storey_at(float(mark.position[2])) if np.isfinite(mark.position).all() else None

    def ground_at(self, here: Array) -> Walkable:
        """The ground of the storey on which somebody is, (3,) metres, map frame.

        Raises:
            NoWayError: it is not known.
        """
        return self._ground(self.storey_at(float(here[2])))

    def to_sign(self, here: Array, position: Array, normal: Array | None) -> tuple[Goal, Way]:
        """The pose before a sign and the way there, over the stairs and ramps that were walked, if need be.

        Args:
            here: (3,) metres, map frame, where somebody is.
            position, normal: of the sign, as in `goal_before`.

        Raises:
            NoWayError: there is none.
        """
        start = self.storey_at(float(here[2]))
        # Where nobody knows how high the sign hangs, the ground on which one stands says what is missing.
        end = self.storey_at(float(position[2])) if np.isfinite(position).all() else start
        if start == end or not any(passage.end == end for passage in self.passages):
            ground = self._ground(start)
            goal = goal_before(position, normal, ground, here)
            return goal, ground.way(here, goal.position)
        before, at = self._over(start, end, here)
        ground = self._ground(end)
        goal = goal_before(position, normal, ground, at)
        return goal, joined([*before, ground.way(at, goal.position)], self._speed)

    def _ground(self, storey: int) -> Walkable:
        if storey not in self.grounds:
            raise NoWayError("no ground of this storey is known; map it once more")
        return self.grounds[storey]

    def _over(self, start: int, end: int, here: Array) -> tuple[list[Way | Passage], Array]:
        """The shortest way from a place on a storey to where another one is entered (Dijkstra 1959), and that place."""
        number = count()
        waiting: list[tuple[float, int, int, list[Way | Passage]]] = [(0.0, next(number), -1, [])]
        taken: set[int] = set()
        while waiting:
            length, _, last, ways = heappop(waiting)
            if last in taken:
                continue
            taken.add(last)
            storey, at = (start, here) if last < 0 else (self.passages[last].end, self.passages[last].points[-1])
            if storey == end:
                return ways, at
            for which, passage in enumerate(self.passages):
                way = self._way(storey, at, passage.points[0]) if passage.begin == storey else None
                if way is not None and which not in taken:
                    farther = length + way.length + passage.length
                    heappush(waiting, (farther, next(number), which, [*ways, way, passage]))
        raise NoWayError(
            "stairs or a ramp to the sign's storey were walked, but no way to them was seen: map the way between"
        )

    def _way(self, storey: int, start: Array, end: Array) -> Way | None:
        try:
            return self._ground(storey).way(start, end)
        except NoWayError:
            return None

    def _passages(self, carried: Array, config: Config) -> Iterator[Passage]:
        """Stretches of the camera's way that begin on one storey and end on another one."""
        carried = carried[np.isfinite(carried).all(axis=1)]
        grid = next(iter(self.grounds.values())).grid
        of, floors = grid.storeys_at(carried[:, 2]), np.array(grid.storeys)
        over = carried[:, 2] - floors[of]
        level = np.abs(over - np.median(over)) <= config.ground.carried_height if len(over) else over > 0
        settled = np.flatnonzero(level)
        for first, last in zip(settled[:-1].tolist(), settled[1:].tolist(), strict=True):
            begin, end = int(of[first]), int(of[last])
            if begin == end or not {begin, end} <= self.grounds.keys():
                continue
            foot = self._with_room(begin, range(first, -1, -1), carried, of)
            head = self._with_room(end, range(last, len(carried)), carried, of)
            if foot is not None and head is not None:
                yield Passage(begin, end, _thinned(carried[foot : head + 1, :2]))

    def _with_room(self, storey: int, rows: range, carried: Array, of: NDArray[np.int64]) -> int | None:
        """The first row at which somebody stood on a storey's ground: where there is most of it, by preference."""
        ground, found = self.grounds[storey], None
        for row in rows:
            if of[row] != storey:
                break
            cell = ground.nearest(carried[row], ground.config.start_reach)
            if cell is not None and ground.regions[cell] == ground.largest:
                return row
            found = row if found is None and cell is not None else found
        return found


def joined(parts: Sequence[Way | Passage], speed: float) -> Way:
    """One way of several that follow each other; passages become climbs."""
    points: list[Array] = [np.empty((0, 2))]
    climbs, at = [], 0
    for part in parts:
        points.append(part.points)
        if isinstance(part, Passage):
            climbs.append(Climb(at, at + len(part.points) - 1, part.end - part.begin))
        at += len(part.points)
    return Way(np.concatenate(points), speed, tuple(climbs))


def _thinned(points: Array) -> Array:
    """Points (n, 2) of a way, both ends and those between that lie a step apart."""
    kept = [0]
    for row in range(1, len(points) - 1):
        if np.linalg.norm(points[row] - points[kept[-1]]) >= _STEP:
            kept.append(row)
    return np.asarray(points[[*kept, len(points) - 1]], np.float64)


_STEP = 0.25
"""Metres between points of a way that was walked: those of a camera that stands say nothing."""
