"""Places as the solver sees them, and the distances between them."""

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Point = NDArray[np.float64]

FARTHEST = 1e6
"""Metres from the origin of a map within which a place means anything."""


@dataclass(frozen=True, slots=True, eq=False)
class Place:
    """A landmark where it stands.

    Attributes:
        id: of the landmark.
        name: as it is told.
        position: (3,) metres, map frame, z up.
        facing: (3,) unit, out of the board towards its readers; None where that is not known.
        size: metres, width of the board; 0 where that is not known.
        uncertainty: metres, standard deviation of the position.
    """

    id: int
    name: str
    position: Point
    facing: Point | None = None
    size: float = 0.0
    uncertainty: float = 0.0


class Distances(Protocol):
    """How far it is from one point to another."""

    def distance(self, start: Point, end: Point) -> float:
        """Metres; infinite where there is no way."""
        ...


class Straight:
    """Distances as the crow flies, where no way is known."""

    def distances(self, start: Point, ends: NDArray[np.float64]) -> NDArray[np.float64]:
        """(n,) metres to (n, 3) points."""
        return np.asarray(np.linalg.norm(ends - start, axis=1))

    def distance(self, start: Point, end: Point) -> float:
        """Metres."""
        return math.dist(start, end)


@dataclass(frozen=True, slots=True, eq=False)
class Here:
    """Where and how the asker stands.

    Attributes:
        position: (3,) metres, map frame; None where that is not known.
        heading: radians counter-clockwise from the map's x axis; None where that is not known.
    """

    position: Point | None = None
    heading: float | None = None
