"""A served map in a few facts, and one of its landmarks."""

import math
from typing import Any

from lpslam.errors import UserError
from lpslam.serving.atlas import Atlas, ServedMap
from lpslam.serving.ground import Grounds
from lpslam.text.types import Landmark


class NoSuchLandmarkError(UserError):
    """A landmark was asked for that the map does not have."""


def summary(served: ServedMap, atlas: Atlas) -> dict[str, Any]:
    """A map as `records.MapRecord` has it."""
    position, heading = served.view
    return {
        "name": served.name,
        "version": served.version,
        "source": served.world.source,
        "landmarks": len(served.records),
        "keyframes": len(served.world.slam.living_keyframes()),
        "frames": served.world.trajectory.frame_count,
        "path_length_m": round(served.path_length, 2),
        "question": served.world.text.question,
        "last_position": [round(float(value), 4) for value in position],
        "last_heading": round(math.degrees(heading), 2),
        "has_ground": Grounds.has(served),
        "trouble": atlas.trouble(served.name),
    }


def landmark_of(served: ServedMap, id_: int) -> Landmark:
    """A landmark by its id.

    Raises:
        NoSuchLandmarkError: the map has none of this id.
    """
    if id_ not in served.directory.by_id:
        raise NoSuchLandmarkError(f"map {served.name} has no landmark {id_}; /landmarks lists them")
    return served.directory.by_id[id_]
