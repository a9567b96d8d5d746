"""The floor plan: a route through corridors, the walls on both sides of it, and what of the floor is walkable."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Points2 = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Wall:
    """A straight wall as seen from the corridor: from `start` to `end` runs to the viewer's right.

    Attributes:
        start, end: (2,) metres.
    """

    start: Points2
    end: Points2

    @property
    def length(self) -> float:
        """Metres."""
        return float(np.linalg.norm(self.end - self.start))

    @property
    def right(self) -> Points2:
        """Unit vector (2,) along the wall, to the right of someone who faces it."""
        return (self.end - self.start) / self.length

    @property
    def normal(self) -> Points2:
        """Unit vector (2,) out of the wall into the corridor."""
        along = self.right
        return np.array([along[1], -along[0]])


@dataclass(frozen=True, slots=True, eq=False)
class Layout:
    """A floor plan.

    Attributes:
        route: (k, 2) corners of the closed route along the middle of the corridors, metres.
        walls: every wall that a corridor sees.
        blocks: (b, 2, 2) lower and upper corners of what stands inside the loops.
        outline: (2, 2) lower and upper corner of all.
        corridors: (c, 2, 2) end points of the corridors' middle lines.
    """

    route: Points2
    walls: tuple[Wall, ...]
    blocks: NDArray[np.float64]
    outline: NDArray[np.float64]
    corridors: NDArray[np.float64]


def plan(rng: np.random.Generator, shape: Literal["loop", "figure-eight"], loop_length: float) -> Layout:
    """Draw a floor plan whose closed route is about `loop_length` metres, with corridors 3 to 6 m wide."""
    if shape == "loop":
        short = loop_length / 2 * rng.uniform(0.40, 0.46)
        sides = np.array([loop_length / 2 - short, short])
        columns = np.array([0.0, sides[0]])
        row = sides[1]
    else:
        # Two loops share the middle corridor, which is walked twice: 3 rows and 4 half widths.
        row = loop_length / 7 * rng.uniform(0.85, 1.05)
        width = (loop_length - 4 * row) / 2
        columns = np.array([0.0, width * rng.uniform(0.46, 0.54), width])
    # A block keeps at least 1.8 m of depth, so that shop windows on its two faces do not meet.
    gap = min(float(np.diff(columns).min()), float(row))
    widest = min(6.0, max(3.0, gap - 1.8))
    half_columns = rng.uniform(3.0, widest, len(columns)) / 2
    half_rows = rng.uniform(3.0, widest, 2) / 2
    blocks = np.array(
        [
            [[columns[i] + half_columns[i], half_rows[0]], [columns[i + 1] - half_columns[i + 1], row - half_rows[1]]]
            for i in range(len(columns) - 1)
        ]
    )
    outline = np.array([[-half_columns[0], -half_rows[0]], [columns[-1] + half_columns[-1], row + half_rows[1]]])
    walls = [*_faces(outline, inward=True)]
    for block in blocks:
        walls += _faces(block, inward=False)
    corridors = [[[columns[0], y], [columns[-1], y]] for y in (0.0, row)]
    corridors += [[[x, 0.0], [x, row]] for x in columns]
    if shape == "loop":
        route = np.array([[columns[0], 0.0], [columns[1], 0.0], [columns[1], row], [columns[0], row]])
    else:
        left, middle, right = columns
        corners = [
            (middle, 0),
            (middle, row),
            (left, row),
            (left, 0),
            (middle, 0),
            (middle, row),
            (right, row),
            (right, 0),
        ]
        route = np.array(corners, dtype=np.float64)
    return Layout(route, tuple(walls), blocks, outline, np.array(corridors))


def _faces(box: NDArray[np.float64], *, inward: bool) -> list[Wall]:
    """The four walls of an upright box, seen from inside or from outside."""
    (x0, y0), (x1, y1) = box
    ring = np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])
    if inward:
        ring = ring[::-1]
    return [Wall(ring[i], ring[(i + 1) % 4]) for i in range(4)]
