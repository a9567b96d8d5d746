"""Where a camera stands that sees known signs in certain directions, with or without depth.

The corners of a sign are points of the map; two signs give eight, and the pose follows from where they are seen
(perspective-n-point).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import transform_points
from lpslam.config import AdviceConfig
from lpslam.slam.advice import Anchor
from lpslam.text.advice.constellations import Seen, likeness
from lpslam.text.types import Bearing

Array = NDArray[np.float64]

# Most pairs of signs that are tried, the rarest first; each costs a tenth of a millisecond.
_TRIED = 200

# Cosine between the camera's axis and what it may see, at least: 84 degrees.
_LEAST_AHEAD = 0.1


@dataclass(frozen=True, slots=True, eq=False)
class Sightline:
    """A text as one frame shows it, and the signs that it may be.

    Attributes:
        bearing: where its corners were seen.
        camera_from_keyframe: 4×4, into the camera whose place is sought from the one in whose frame the bearing is.
        signs: in one world.
    """

    bearing: Bearing
    camera_from_keyframe: Array
    signs: Sequence[Seen]

    def corners_if(self, sign: Seen) -> Array:
        """(4, 3) in which directions the camera has the corners, if the text is that sign: its height tells how far."""
        rays = np.array(self.bearing.corners)
        down = float(np.linalg.norm(rays[3] - rays[0] + rays[2] - rays[1])) / 2
        points = np.array(self.bearing.origin) + rays * (sign.height / max(down, 1e-9))
        local = transform_points(self.camera_from_keyframe, points)
        directions: Array = local / np.maximum(np.linalg.norm(local, axis=1, keepdims=True), 1e-9)
        return directions


@dataclass(frozen=True, slots=True, eq=False)
class _Choice:
    """A text, by its row, that may be a sign; how the camera has its corners then (4, 3), and what that is worth."""

    row: int
    sign: Seen
    corners: Array
    weight: float


@dataclass(frozen=True, slots=True, eq=False)
class Standpoint:
    """Where a camera stands by the signs that it sees.

    Attributes:
        rarity: sum over the signs of one over the number of those that each text may be.
        camera_from_world: 4×4; signs in one row leave it loose around the row.
        anchor: the signs.
    """

    rarity: float
    camera_from_world: Array
    anchor: Anchor


def standpoints(sightlines: Sequence[Sightline], config: AdviceConfig) -> Iterator[Standpoint]:
    """Find from where two signs or more, that say different things, look as they do.

    Args:
        sightlines: of one frame.
        config: tolerances, and how rare the signs must be.

    Yields:
        Places that no two explain by the same sign, the rarest signs first.
    """
    choices = [
        _Choice(row, sign, corners, 1.0 / len(each.signs))
        for row, each in enumerate(sightlines)
        for sign in each.signs
        if is_ahead(corners := each.corners_if(sign))
    ]
    pairs = [pair for pair in combinations(choices, 2) if _may_go_together(*pair, config)]
    pairs = sorted(pairs, key=lambda pair: -(pair[0].weight + pair[1].weight))[:_TRIED]
    found: list[tuple[float, float, list[_Choice], Array]] = []
    for pair in pairs:
        pose = _pose(pair)
        if pose is None:
            continue
        off = [_off(each, pose) for each in choices]
        group = _best_of_each(choices, off, config.corner_tolerance)
        if not all(any(each is other for other in group) for each in pair):
            continue
        refined = _pose(group) if len(group) > 2 else pose
        if refined is not None:
            worst = max(_off(each, refined) for each in group)
            found.append((sum(each.weight for each in group), worst, group, refined))
    used: set[int] = set()
    for rarity, _, group, pose in sorted(found, key=lambda each: (-each[0], each[1])):
        own = {id(each) for each in group}
        if rarity >= config.min_rarity and not used & own:
            used |= own
            yield Standpoint(rarity, pose, anchor_of([(each.corners, each.sign) for each in group]))


def is_ahead(corners: Array) -> bool:
    """Whether directions (4, 3) lie in front of a camera, where an image can have them."""
    return bool((corners[:, 2] > _LEAST_AHEAD).all())


def anchor_of(matches: Sequence[tuple[Array, Seen]], timestamp: float = -np.inf) -> Anchor:
    """Signs, each seen in directions (4, 3) at a time in seconds."""
    corners, directions = [corners_of(sign) for _, sign in matches], [seen for seen, _ in matches]
    return Anchor(np.array(corners), np.array(directions), timestamp)


def corners_of(sign: Seen) -> Array:
    """(4, 3) metres, in the sign's world: top left, top right, bottom right, bottom left."""
    across, down = sign.baseline * sign.width / 2, np.cross(-sign.normal, sign.baseline) * sign.height / 2
    return np.array([sign.position + x * across + y * down for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))])


def _may_go_together(one: _Choice, other: _Choice, config: AdviceConfig) -> bool:
    """Whether two texts of a frame may be two signs: neither a reading of the other, and not of one board."""
    return (
        one.row != other.row
        and float(np.linalg.norm(one.sign.position - other.sign.position)) >= config.board_size
        and likeness(one.sign, other.sign) < config.alike
    )


def _best_of_each(choices: Sequence[_Choice], off: Sequence[float], tolerance: float) -> list[_Choice]:
    """Of the signs that a text may be, the one that is seen where it stands, if any is."""
    best: dict[int, int] = {}
    for at, each in enumerate(choices):
        if off[at] <= tolerance and (each.row not in best or off[at] < off[best[each.row]]):
            best[each.row] = at
    return [choices[at] for at in sorted(best.values())]


def _pose(choices: Sequence[_Choice]) -> Array | None:
    """4×4, camera from world, from which signs are seen so; None where there is none."""
    import cv2

    anchor = anchor_of([(each.corners, each.sign) for each in choices])
    points, directions = anchor.corners.reshape(-1, 3), anchor.directions.reshape(-1, 3)
    pixels = directions[:, :2] / directions[:, 2:]
    middle = points.mean(axis=0)
    try:
        is_found, turn, way = cv2.solvePnP(points - middle, pixels, np.eye(3), None, flags=cv2.SOLVEPNP_SQPNP)
    except cv2.error:
        # Signs without a size, of a map that was edited.
        return None
    if not is_found or not (np.isfinite(turn).all() and np.isfinite(way).all()):
        return None
    pose = np.eye(4)
    pose[:3, :3] = cv2.Rodrigues(turn)[0]
    pose[:3, 3] = way[:, 0] - pose[:3, :3] @ middle
    return pose


def _off(choice: _Choice, camera_from_world: Array) -> float:
    """By how much of its height a sign's corners are seen elsewhere than they stand; infinite from behind."""
    local = transform_points(camera_from_world, corners_of(choice.sign))
    facing = camera_from_world[:3, :3] @ choice.sign.normal
    if (local[:, 2] <= 0).any() or facing @ local.mean(axis=0) >= 0:
        return float("inf")
    seen, stands = choice.corners[:, :2] / choice.corners[:, 2:], local[:, :2] / local[:, 2:]
    height = float(np.linalg.norm(stands[3] - stands[0] + stands[2] - stands[1])) / 2
    return float(np.linalg.norm(seen - stands, axis=1).max()) / max(height, 1e-9)
