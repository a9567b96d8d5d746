"""Ways over the ground: where a robot has room, the shortest way, and how long it takes."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.config import WayConfig
from lpslam.errors import UserError
from lpslam.ground.grid import FREE, OCCUPIED, Grid
from lpslam.navigation.walking.blocks import Blocks
from lpslam.navigation.walking.searching import cheapest, is_clear

Array = NDArray[np.float64]


class NoWayError(UserError):
    """There is no such way; the message says what is missing, and what would be next best."""


@dataclass(frozen=True, slots=True)
class Climb:
    """The part of a way that leads to another storey.

    Attributes:
        first, last: of the way's points, where it begins and ends.
        storeys: how many it leads up; down, where negative.
    """

    first: int
    last: int
    storeys: int


@dataclass(frozen=True, slots=True, eq=False)
class Way:
    """A way over the ground.

    Attributes:
        points: (n, 2) metres, map frame, from where it begins to where it ends.
        speed: metres a second at which it is gone.
        climbs: where it leads to other storeys, in its order.
    """

    points: Array
    speed: float
    climbs: tuple[Climb, ...] = ()

    @property
    def length(self) -> float:
        """Metres."""
        return float(np.linalg.norm(np.diff(self.points, axis=0), axis=1).sum())

    @property
    def seconds(self) -> float:
        """How long it takes."""
        return self.length / self.speed


class Walkable:
    """The part of a grid in which a robot has room.

    Args:
        grid: of the ground.
        config: the robot, and how it likes to go.

    Attributes:
        clearance: (rows, columns) metres to the next thing in the way.
        cost: (rows, columns) of a step into each cell; infinite where the robot has no room.
        regions: (rows, columns) numbers of parts between which there is no way; 0 where there is no room.
        largest: the number of the largest of them; 0 where there is none.
    """

    def __init__(self, grid: Grid, config: WayConfig) -> None:
        self.grid, self.config = grid, config
        free = (grid.values != OCCUPIED).astype(np.uint8)
        # Where nothing at all is in the way, the transform has nothing to measure from.
        away = (
            cv2.distanceTransform(free, cv2.DIST_L2, 5) * grid.resolution
            if not free.all()
            else np.full(grid.shape, 1e3)
        )
        self.clearance = np.asarray(away, np.float32)
        has_room = (grid.values == FREE) & (self.clearance > config.robot_radius)
        tight = np.clip(1.0 - (self.clearance - config.robot_radius) / max(config.comfort, 1e-6), 0.0, 1.0)
        self.cost = np.where(has_room, 1.0 + config.comfort_cost * tight, np.inf).astype(np.float32)
        side = max(-(-max(grid.shape) // _MOST_SQUARES), 1)
        self._blocks = Blocks.of(self.cost, side) if side > 1 else None
        _, regions = cv2.connectedComponents(has_room.astype(np.uint8), connectivity=4)
        self.regions = np.asarray(regions, np.int32)
        sizes = np.bincount(self.regions.ravel())[1:]
        self.largest = int(sizes.argmax()) + 1 if len(sizes) else 0

    def nearest(self, point: Array, reach: float, region: int = 0) -> tuple[int, int] | None:
        """The cell with room that is nearest to a point (2,) within so many metres; of a region only, if not 0."""
        place, cell = np.asarray(point[:2], np.float64), self.grid.cell(point)
        radius = _FIRST_LOOK
        while True:
            within = min(radius * self.grid.resolution, reach)
            top, left = max(cell[0] - radius, 0), max(cell[1] - radius, 0)
            part = self.regions[top : max(cell[0] + radius + 1, 0), left : max(cell[1] + radius + 1, 0)]
            found = np.argwhere(part == region if region else part > 0) + np.array([top, left])
            if len(found):
                away = np.linalg.norm(self.grid.middles(found) - place, axis=1)
                best = int(away.argmin())
                # What lies in the corners of the square may be farther than what lies beyond its sides.
                if away[best] <= within:
                    return int(found[best, 0]), int(found[best, 1])
            if within >= reach or part.size == self.regions.size:
                return (int(found[best, 0]), int(found[best, 1])) if len(found) and away[best] <= reach else None
            radius *= 2

    def start(self, point: Array) -> tuple[int, int]:
        """The cell in which a way from a point (2 or 3,) begins.

        Raises:
            NoWayError: the robot has no room there.
        """
        cell = self.nearest(point, self.config.start_reach)
        if cell is not None:
            return cell
        farther = self.nearest(point, np.inf)
        x, y = float(point[0]), float(point[1])
        if farther is None:
            raise NoWayError(
                f"nowhere on this map is there room for a robot of {self.config.robot_radius:g} m radius; "
                "set ways.robot_radius, or map more of the floor"
            )
        at = self.grid.middles(np.array([farther]))[0]
        state = "something is in the way" if self.grid.at(point) == OCCUPIED else "no ground was seen"
        nearest = f"the nearest place with room is ({at[0]:.2f}, {at[1]:.2f})"
        raise NoWayError(f"no way begins at ({x:.2f}, {y:.2f}): {state} there; {nearest}")

    def way(self, start: Array, end: Array) -> Way:
        """The shortest way between two points (2 or 3,), metres, that keeps off what is in the way.

        Raises:
            NoWayError: there is none.
        """
        first = self.start(start)
        last = self.nearest(end, 2.0 * self.grid.resolution)
        if last is None:
            x, y = float(end[0]), float(end[1])
            raise NoWayError(f"there is no room to stand at ({x:.2f}, {y:.2f}); ask for a place before it")
        if self.regions[first] != self.regions[last]:
            raise NoWayError(self._why_apart(first, last))
        return Way(self.grid.middles(self._straightened(self._cells(first, last))), self.config.speed)

    def _cells(self, first: tuple[int, int], last: tuple[int, int]) -> NDArray[np.int64]:
        """The cells (n, 2) of the cheapest way; on a large grid, near that over squares of cells."""
        if self._blocks is not None:
            near = self._blocks.near(first, last)
            if near is not None:
                return _over(self.cost, first, last, near, self._blocks.side)
        return _over(self.cost, first, last)

    def _straightened(self, cells: NDArray[np.int64]) -> NDArray[np.int64]:
        """Leave out the cells between which one can go straight on, no nearer to anything than the way itself."""
        kept, at = [0], 0
        costs = self.cost[cells[:, 0], cells[:, 1]]
        while at < len(cells) - 1:
            ahead = len(cells) - 1
            while ahead > at + 1:
                most = float(costs[at : ahead + 1].max()) + 1e-3
                if is_clear(self.cost, cells[at] + 0.5, cells[ahead] + 0.5, most):
                    break
                ahead = at + max((ahead - at) * 3 // 4, 1)
            kept.append(ahead)
            at = ahead
        return cells[kept]

    def _why_apart(self, first: tuple[int, int], last: tuple[int, int]) -> str:
        """Whether a smaller robot would get through, in words."""
        free = self.grid.values == FREE
        for radius in np.arange(self.config.robot_radius - 0.05, 0.0, -0.05):
            cost = np.where(free & (self.clearance > radius), 1.0, np.inf).astype(np.float32)
            if len(_over(cost, first, last)):
                return (
                    f"a robot of {self.config.robot_radius:g} m radius does not get through: it is too narrow on the "
                    f"way; one of {radius:.2f} m would"
                )
        return "no ground was seen that leads there: the two parts of the map are islands; map the way between them"


def _over(
    cost: NDArray[np.float32],
    first: tuple[int, int],
    last: tuple[int, int],
    near: NDArray[np.uint8] | None = None,
    size: int = 1 << 30,
) -> NDArray[np.int64]:
    """The cells (n, 2) of the cheapest way, within those that are near; none where there is no way."""
    columns, everywhere = cost.shape[1], np.ones((1, 1), np.uint8)
    start, end = first[0] * columns + first[1], last[0] * columns + last[1]
    cells = cheapest(cost, start, end, everywhere if near is None else near, size)
    return np.column_stack([cells // columns, cells % columns])


class WayDistances:
    """Lengths of ways, for whoever asks what is nearest; as the crow flies, where there is no ground.

    Args:
        walkable: the ground.
    """

    def __init__(self, walkable: Walkable) -> None:
        self._walkable = walkable
        self._known: dict[tuple[tuple[int, int], tuple[int, int]], float] = {}

    def distance(self, start: Array, end: Array) -> float:
        """Metres; infinite where there is ground at both ends and no way between them."""
        first, last = (self._walkable.nearest(each, _BESIDE_GROUND) for each in (start, end))
        if first is None or last is None:
            return float(np.linalg.norm(end - start))
        if self._walkable.regions[first] != self._walkable.regions[last]:
            return float("inf")
        if (first, last) not in self._known:
            middles = self._walkable.grid.middles(np.array([first, last]))
            beside = sum(float(np.linalg.norm(p[:2] - m)) for p, m in zip((start, end), middles, strict=True))
            self._known[first, last] = self._walkable.way(*middles).length + beside
        return self._known[first, last]


_MOST_SQUARES = 256
"""Squares to a side: a grid of more cells is searched over squares first."""

_FIRST_LOOK = 32
"""Cells to each side in which a place is looked for first."""

_BESIDE_GROUND = 2.0
"""Metres from ground at which a sign hangs beside it."""
