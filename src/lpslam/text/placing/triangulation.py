"""Where directions meet: a point from rays of known noise, and how uncertain it is."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_STEPS = 5
"""Rounds in which the weights follow the distances: they settle in three."""


@dataclass(frozen=True, slots=True, eq=False)
class Triangulated:
    """A point where directions meet.

    Attributes:
        position: (3,) metres.
        covariance: 3×3 square metres.
        misfit: chi-square a degree of freedom; the covariance is widened by what is above 1.
    """

    position: Array
    covariance: Array
    misfit: float

    @property
    def uncertainty(self) -> float:
        """Metres, standard deviation where it is largest."""
        return float(np.sqrt(np.linalg.eigvalsh(self.covariance)[-1]))


def triangulate(
    origins: Array,
    directions: Array,
    noise: Array,
    shares: Array,
    known: tuple[Array, Array] | None = None,
    start: Array | None = None,
) -> Triangulated | None:
    """Find the point that directions agree on, each weighted by its noise and its distance.

    Args:
        origins, directions: (n, 3) metres and unit.
        noise: (n,) radians, standard deviation.
        shares: (n,) what each counts; views with common errors count together as one.
        known: what else is known of the point, as information: 3×3 matrix, and it times the point, (3,).
        start: (3,) about where the point is.

    Returns:
        The point, or None where the directions do not meet before the cameras.
    """
    across = np.eye(3) - directions[:, :, None] * directions[:, None, :]
    known_matrix, known_vector = known if known is not None else (np.zeros((3, 3)), np.zeros(3))
    distances = np.ones(len(origins)) if start is None else np.linalg.norm(start - origins, axis=1)
    for _ in range(_STEPS):
        weights = shares / (noise * np.maximum(distances, 1e-6)) ** 2
        matrix = np.einsum("n,nij->ij", weights, across) + known_matrix
        if np.linalg.cond(matrix) > 1e12:
            return None
        point = np.linalg.solve(matrix, np.einsum("n,nij,nj->i", weights, across, origins) + known_vector)
        distances = ((point - origins) * directions).sum(axis=1)
        if (distances <= 0.0).any():
            return None
    chi_square = float(shares @ (angles(point, origins, directions) / noise) ** 2)
    misfit = chi_square / max(2.0 * float(shares.sum()) - 3.0, 1.0)
    return Triangulated(point, np.linalg.inv(matrix) * max(misfit, 1.0), misfit)


def angles(points: Array, origins: Array, directions: Array) -> Array:
    """Angles (..., n) between directions (n, 3) and where points (..., 3) stand; pi/2 for what is behind."""
    offsets = points[..., None, :] - origins
    ahead = (offsets * directions).sum(axis=-1)
    aside = np.linalg.norm(offsets - ahead[..., None] * directions, axis=-1)
    return np.asarray(np.where(ahead > 0.0, np.arctan2(aside, np.maximum(ahead, 1e-9)), np.pi / 2.0), np.float64)


def middles(corners: Array, towards: Sequence[Array | None] = ()) -> Array:
    """Directions (n, 3) to the middles of rectangles with corners along (n, 4, 3): where their diagonals cross.

    Of a long text that is surer where it lies on a known surface: ends that are drawn a tenth too high or too low move
    the crossing by a tenth of the length.

    Args:
        corners: unit.
        towards: for each rectangle the way (3,) to its middle where the surface that it lies on tells it.
    """
    diagonals = np.cross(corners[:, 0], corners[:, 2]), np.cross(corners[:, 1], corners[:, 3])
    crossing, mean = np.cross(*diagonals), corners.mean(axis=1)
    crossing *= np.sign((crossing * mean).sum(axis=1, keepdims=True))
    sizes = np.linalg.norm(crossing, axis=1, keepdims=True)
    directions = np.where(sizes > 1e-12, crossing / np.maximum(sizes, 1e-12), mean)
    for row, way in enumerate(towards):
        if way is not None:
            directions[row] = way
    return np.asarray(directions / np.linalg.norm(directions, axis=1, keepdims=True), np.float64)


def on_plane(origin: Array, corners: Array, point: Array, normal: Array) -> Array:
    """Where rays (4, 3) meet the plane; on a plane seen all but edge-on, where they are as far as the point is."""
    slants = corners @ normal
    if (slants > -_EDGE_ON).any():
        return np.asarray(origin + corners * np.linalg.norm(point - origin), np.float64)
    return np.asarray(origin + corners * (((point - origin) @ normal) / slants)[:, None], np.float64)


_EDGE_ON = 0.17
"""Cosine of 80 degrees."""


def meetings(
    origins: Array, directions: Array, noise: Array, first: NDArray[np.intp], second: NDArray[np.intp]
) -> Array:
    """Points (m, 3) ahead at which pairs of rays come nearest to each other; none of pairs parallel within their noise.

    Args:
        origins, directions, noise: (n, 3) metres, (n, 3) unit, (n,) radians.
        first, second: (p,) row numbers of the pairs.
    """
    a, b = directions[first], directions[second]
    # Directions that differ by less than their noise meet anywhere.
    told = 1.0 - (a * b).sum(axis=1) ** 2 > noise[first] ** 2 + noise[second] ** 2
    first, second, a, b = first[told], second[told], a[told], b[told]
    between = origins[second] - origins[first]
    cosine = (a * b).sum(axis=1)
    along_a, along_b = (between * a).sum(axis=1), (between * b).sum(axis=1)
    far_a = (along_a - cosine * along_b) / (1.0 - cosine**2)
    far_b = (cosine * along_a - along_b) / (1.0 - cosine**2)
    met = origins[first] + far_a[:, None] * a + origins[second] + far_b[:, None] * b
    return np.asarray(met[(far_a > 0.0) & (far_b > 0.0)] / 2.0, np.float64)
