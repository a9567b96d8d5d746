"""A place: what is drawn, where a camera may go, what it looks at."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from lpslam.simulation.scene import Scene
from lpslam.simulation.signs import Sign

Points = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Solids:
    """What no camera may be inside of.

    Attributes:
        bounds: (2, 3) lower and upper corner of the space in which cameras may be, metres.
        corners: (n, 3) of upright boxes, at the bottom.
        along, across: (n, 3) horizontal edges, at right angles.
        heights: (n,) metres.
    """

    bounds: Points
    corners: Points
    along: Points
    across: Points
    heights: NDArray[np.float64]

    def clearance(self, points: Points) -> NDArray[np.float64]:
        """(m,) metres from each of (m, 3) points to the nearest solid or bound; negative inside of one."""
        inside = np.minimum(points - self.bounds[0], self.bounds[1] - points).min(axis=1)
        for corner, along, across, height in zip(self.corners, self.along, self.across, self.heights, strict=True):
            half = np.array([np.linalg.norm(along), np.linalg.norm(across), height]) / 2
            axes = np.array([along / (2 * half[0]), across / (2 * half[1]), [0.0, 0.0, 1.0]])
            local = (points - corner) @ axes.T - half
            beyond = np.abs(local) - half
            distance = np.linalg.norm(np.maximum(beyond, 0), axis=1) + np.minimum(beyond.max(axis=1), 0)
            inside = np.minimum(inside, distance)
        return np.asarray(inside)


@dataclass(frozen=True, slots=True, eq=False)
class Route:
    """A way through a place.

    Attributes:
        points: (k, 3) metres, close together; a closed one ends where it began.
        targets: (k, 3) what is looked at from there; NaN: straight ahead.
        is_closed: whether it goes round; else it is gone to and fro.
        pace: metres a second, of someone who walks it.
        robot_height: metres above the floor of a camera on wheels.
    """

    points: Points
    targets: Points
    is_closed: bool
    pace: float
    robot_height: float


@dataclass(frozen=True, slots=True, eq=False)
class Pane:
    """A mirror or a sheet of glass: an upright rectangle; `corner` is its upper left, seen from the front."""

    corner: Points
    edge_u: Points
    edge_v: Points
    is_mirror: bool


@dataclass(frozen=True, slots=True, eq=False)
class Walker:
    """Someone who walks: rows of the scene and where they are at a time.

    Attributes:
        first, last: rows of the scene, the last one not included.
        start, end: (2,) metres, between which they go to and fro.
        speed: metres a second.
        phase: metres of their way that lie behind them at the start.
        swings: (rows,) 1 or -1 for faces of limbs that swing forward with one foot or the other, 0 for others.
        hips: (rows,) metres above the floor about which they swing.
    """

    first: int
    last: int
    start: Points
    end: Points
    speed: float
    phase: float
    swings: NDArray[np.int64]
    hips: Points


@dataclass(frozen=True, slots=True, eq=False)
class Place:
    """A place.

    Attributes:
        scene: what is drawn while nothing moves.
        signs: what can be read.
        route: how one goes through it.
        solids: what stands in the way.
        panes: glass and mirrors.
        walkers: who moves.
        goes_dark: whether the lamps fail for a while.
    """

    scene: Scene
    signs: tuple[Sign, ...]
    route: Route
    solids: Solids
    panes: tuple[Pane, ...] = field(default=())
    walkers: tuple[Walker, ...] = field(default=())
    goes_dark: bool = False


def ahead(points: Points) -> Points:
    """Targets that say: look where you go."""
    return np.full(points.shape, np.nan)


def smooth_path(corners: Points, is_closed: bool, spacing: float = 0.05) -> Points:
    """(k, 3) points of a smooth curve through some corners (n, 3), `spacing` metres apart."""
    from scipy.interpolate import CubicSpline

    knots = np.vstack([corners, corners[:1]]) if is_closed else corners
    steps = np.sqrt(np.linalg.norm(np.diff(knots, axis=0), axis=1)) + 1e-6
    at = np.concatenate([[0.0], np.cumsum(steps)])
    curve = CubicSpline(at, knots, bc_type="periodic" if is_closed else "natural")(np.linspace(0, at[-1], 4000))
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(curve, axis=0), axis=1))])
    even = np.linspace(0, lengths[-1], max(8, round(lengths[-1] / spacing)))
    return np.column_stack([np.interp(even, lengths, curve[:, axis]) for axis in range(3)])
