"""Pictures of signs for their cards: as each landmark was seen best."""

import base64

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import transform_points
from lpslam.config import PageConfig
from lpslam.mapfile.language_map import LanguageMap
from lpslam.text.sightings import Sighting
from lpslam.text.types import Landmark

Array = NDArray[np.float64]

_CLASS = 1000  # a landmark's id is its class's times this, and a number
_OWN = 1.5  # times as large another line of a board must have been seen to show the landmark rather than its own


def sign_pictures(world: LanguageMap, most_bytes: int | None, config: PageConfig) -> dict[str, list[str]]:
    """For each landmark, by its id, the pictures in which it was seen best, as JPEGs' addresses within the page.

    Args:
        world: the map.
        most_bytes: of all addresses together; the best of each landmark come first, the surest landmarks' before the
            others'. Without, all.
        config: how many, and how near they must have been taken.
    """
    taken = _placed(world)
    if not taken:
        return {}
    places = np.array([place for _, place, _ in taken])
    marks = sorted(world.landmarks(), key=lambda each: (-each.confidence, each.id))
    best = {mark.id: _best(mark, taken, places, config) for mark in marks}
    pictures: dict[str, list[str]] = {}
    left = np.inf if most_bytes is None else most_bytes
    for rank in range(config.pictures):
        for mark in marks:
            if rank >= len(best[mark.id]):
                continue
            address = "data:image/jpeg;base64," + base64.b64encode(best[mark.id][rank].jpeg).decode("ascii")
            if len(address) <= left:
                left -= len(address)
                pictures.setdefault(str(mark.id), []).append(address)
    return pictures


def _placed(world: LanguageMap) -> list[tuple[int, Array, Sighting]]:
    """All pictures that have a place, with their class and that place, (3,) metres, map frame."""
    placed = []
    for text_class, sightings in world.text.sightings.by_class.items():
        for each in sightings:
            pose = world.world_from_keyframe(each.keyframe)
            if pose is not None:
                placed.append((text_class, transform_points(pose, np.array([each.position]))[0], each))
    return placed


def _best(
    mark: Landmark, taken: list[tuple[int, Array, Sighting]], places: Array, config: PageConfig
) -> list[Sighting]:
    """Of the pictures taken of a landmark those in which its letters are largest, its own line's by preference.

    One a keyframe: others of the same keyframe show the same.
    """
    reach = config.picture_reach + 0.5 * float(np.hypot(mark.width, mark.height))
    near = np.flatnonzero(np.linalg.norm(places - mark.position, axis=1) <= reach)
    ranked = sorted(
        (taken[row] for row in near), key=lambda each: -each[2].seen * (_OWN if each[0] == mark.id // _CLASS else 1.0)
    )
    chosen: dict[int, Sighting] = {}
    for _, _, sighting in ranked:
        chosen.setdefault(sighting.keyframe, sighting)
    return list(chosen.values())[: config.pictures]
