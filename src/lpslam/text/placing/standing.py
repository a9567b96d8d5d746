"""How a text stands whose position is known by directions: which way it faces, and how large it is."""

import numpy as np

from lpslam.text.placing.triangulation import Triangulated, on_plane, triangulate
from lpslam.text.placing.views import Array, Rows, Views, placement_of, unit
from lpslam.text.types import Placement

_FACING_SPREAD = 0.6
"""Spread of the tangent of the angle at which texts are seen: what the corners must say more surely than."""


def placements_at(
    views: Views, here: Rows, there: Rows, place: Triangulated, has_depth: bool = True
) -> dict[int, Placement]:
    """Placements of the views `here` at a position; they face as depth says, or as the corners do.

    Args:
        views: all of a class.
        here: rows of those that are placed.
        there: rows of others that depth placed surely at this position.
        place: the position.
        has_depth: whether what depth says of them counts.

    Returns:
        In the world, by row.
    """
    known = [views.placements[row] for row in np.concatenate([there, here]).tolist() if has_depth]
    normals = [each.normal for each in known if each is not None]
    normal = unit(np.mean(normals, axis=0)) if normals else _facing(views, here, place)
    found = {}
    for row in here.tolist():
        own = views.placements[row] if has_depth else None
        facing = np.array(own.normal) if own is not None else normal
        corners = on_plane(views.origins[row], views.corners[row], place.position, facing)
        found[row] = placement_of(corners, place.position, facing, place.uncertainty)
    return found


def _facing(views: Views, rows: Rows, place: Triangulated) -> Array:
    """The normal (3,) as the corners tell it, each triangulated; as far as they do not, towards the viewers."""
    ahead = unit((place.position - views.origins[rows]).mean(axis=0))
    seen = views.noise[rows] * np.sqrt(2.0), views.shares(rows)
    corners = [
        triangulate(views.origins[rows], views.corners[rows, corner], *seen, start=place.position)
        for corner in range(4)
    ]
    found = [each for each in corners if each is not None]
    if len(found) < 4 or views.keyframes_of(rows) < 2:
        return -ahead
    positions = np.array([each.position for each in found])
    variance = float(ahead @ sum(each.covariance for each in found) @ ahead) / 4.0
    sides = []
    for ends, starts in (((1, 2), (0, 3)), ((2, 3), (0, 1))):
        side = (positions[list(ends)] - positions[list(starts)]).sum(axis=0) / 2.0
        level = side - ahead * (side @ ahead)
        size = max(float(np.linalg.norm(level)), 1e-9)
        told = _FACING_SPREAD**2 / (_FACING_SPREAD**2 + variance / size**2)
        sides.append(level / size + ahead * (told * float(side @ ahead) / size))
    normal = unit(np.cross(sides[1], sides[0]))
    return normal if normal @ ahead < 0.0 else -normal
