"""Texts on glass that some views placed at what is seen through it: they stand on the glass alone."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import transform_points
from lpslam.text.placing.columns import WorldSightings
from lpslam.text.placing.instances import KeyframePoses

Array = NDArray[np.float64]


def without_seen_through(places: Sequence[WorldSightings], world_from_keyframe: KeyframePoses) -> list[WorldSightings]:
    """Of the places of one class, leave out those that each of their views shows through another, larger group's box.

    Two signs that say the same, one behind the other, are seen together, or from somewhere beside each other.
    """
    kept: list[WorldSightings] = []
    for seen in sorted(places, key=len, reverse=True):
        if not any(_is_seen_through(seen, other, world_from_keyframe) for other in kept):
            kept.append(seen)
    return [each for each in places if any(each is other for other in kept)]


def _is_seen_through(behind: WorldSightings, before: WorldSightings, world_from_keyframe: KeyframePoses) -> bool:
    if len(behind) >= len(before) or set(behind.frames.tolist()) & set(before.frames.tolist()):
        return False
    middle, normal = np.median(before.positions, axis=0), before.normals.mean(axis=0)
    along = before.baselines.mean(axis=0)
    half = np.median(before.sizes, axis=0) / 2.0
    for place, origin in zip(behind.positions, _origins(behind, world_from_keyframe), strict=True):
        if origin is None:
            return False
        way = place - origin
        depth = float(way @ normal)
        reached = float((middle - origin) @ normal) / depth if depth else np.inf
        off = origin + reached * way - middle
        if not 0.0 < reached < 1.0 or abs(off @ along) > half[0] or abs(off @ np.cross(normal, along)) > half[1]:
            return False
    return True


def _origins(seen: WorldSightings, world_from_keyframe: KeyframePoses) -> list[Array | None]:
    """Where the camera was, (3,) metres in the world, for each sighting; None where that is not known."""
    origins: list[Array | None] = []
    for each in seen.observations:
        pose = world_from_keyframe(each.keyframe)
        if pose is None or each.bearing is None:
            origins.append(None)
        else:
            origins.append(transform_points(pose, np.array([each.bearing.origin]))[0])
    return origins
