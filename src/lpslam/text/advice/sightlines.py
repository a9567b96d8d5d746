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

Array = NDArray[np.float64]

# Most pairs of signs that are tried, the rarest first; each costs a tenth of a millisecond.
_TRIED = 200


@dataclass(frozen=True, slots=True, eq=False)
class Sightline:
    """A text as one frame shows it, and the signs that it may be.

    Attributes:
        corners: (4, 3) directions in the camera's frame, ordered as those of `Bearing`.
        signs: in one world.
    """

    corners: Array
    signs: Sequence[Seen]


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
    seen = [each for each in sightlines if len(each.signs) and (each.corners[:, 2] > 0).all()]
    choices = [(row, sign) for row, each in enumerate(seen) for sign in each.signs]
    weights = [1.0 / len(seen[row].signs) for row, _ in choices]
    pairs = [
        (one, other)
        for one, other in combinations(range(len(choices)), 2)
        if _may_go_together(choices[one], choices[other], config)
    ]
    pairs = sorted(pairs, key=lambda pair: -(weights[pair[0]] + weights[pair[1]]))[:_TRIED]
    found: list[tuple[float, float, list[int], Array]] = []
    for pair in pairs:
        pose = _pose([(seen[row].corners, sign) for row, sign in (choices[at] for at in pair)])
        if pose is None:
            continue
        off = {at: _off(seen[choices[at][0]].corners, choices[at][1], pose) for at in range(len(choices))}
        group = _best_of_each(choices, off, config.corner_tolerance)
        if not set(pair) <= set(group):
            continue
        refined = _pose([(seen[choices[at][0]].corners, choices[at][1]) for at in group]) if len(group) > 2 else pose
        if refined is not None:
            found.append((sum(weights[at] for at in group), max(off[at] for at in group), group, refined))
    used: set[int] = set()
    for rarity, _, group, pose in sorted(found, key=lambda each: (-each[0], each[1])):
        if rarity >= config.min_rarity and not used & set(group):
            used |= set(group)
            matches = [(seen[choices[at][0]].corners, choices[at][1]) for at in group]
            yield Standpoint(rarity, pose, anchor_of(matches))


def anchor_of(matches: Sequence[tuple[Array, Seen]]) -> Anchor:
    """Signs, each seen in directions (4, 3)."""
    return Anchor(np.array([corners_of(sign) for _, sign in matches]), np.array([corners for corners, _ in matches]))


def corners_of(sign: Seen) -> Array:
    """(4, 3) metres, in the sign's world: top left, top right, bottom right, bottom left."""
    across, down = sign.baseline * sign.width / 2, np.cross(-sign.normal, sign.baseline) * sign.height / 2
    return np.array([sign.position + x * across + y * down for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))])


def _may_go_together(one: tuple[int, Seen], other: tuple[int, Seen], config: AdviceConfig) -> bool:
    """Whether two texts of a frame may be two signs: neither a reading of the other, and not of one board."""
    (row, sign), (other_row, other_sign) = one, other
    return (
        row != other_row
        and float(np.linalg.norm(sign.position - other_sign.position)) >= config.board_size
        and likeness(sign, other_sign) < config.alike
    )


def _best_of_each(choices: Sequence[tuple[int, Seen]], off: dict[int, float], tolerance: float) -> list[int]:
    """Of the signs that a text may be, the one that is seen where it stands, if any is."""
    best: dict[int, int] = {}
    for at, (row, _) in enumerate(choices):
        if off[at] <= tolerance and (row not in best or off[at] < off[best[row]]):
            best[row] = at
    return sorted(best.values())


def _pose(matches: Sequence[tuple[Array, Seen]]) -> Array | None:
    """4×4, camera from world, from which signs are seen in directions (4, 3); None where there is none."""
    import cv2

    anchor = anchor_of(matches)
    points, directions = anchor.corners.reshape(-1, 3), anchor.directions.reshape(-1, 3)
    pixels = directions[:, :2] / directions[:, 2:]
    middle = points.mean(axis=0)
    is_found, turn, way = cv2.solvePnP(points - middle, pixels, np.eye(3), None, flags=cv2.SOLVEPNP_SQPNP)
    if not is_found or not (np.isfinite(turn).all() and np.isfinite(way).all()):
        return None
    pose = np.eye(4)
    pose[:3, :3] = cv2.Rodrigues(turn)[0]
    pose[:3, 3] = way[:, 0] - pose[:3, :3] @ middle
    return pose


def _off(corners: Array, sign: Seen, camera_from_world: Array) -> float:
    """By how much of its height a sign's corners are seen elsewhere than they stand; infinite from behind."""
    local = transform_points(camera_from_world, corners_of(sign))
    facing = camera_from_world[:3, :3] @ sign.normal
    if (local[:, 2] <= 0).any() or facing @ local.mean(axis=0) >= 0:
        return float("inf")
    seen, stands = corners[:, :2] / corners[:, 2:], local[:, :2] / local[:, 2:]
    height = float(np.linalg.norm(stands[3] - stands[0] + stands[2] - stands[1])) / 2
    return float(np.linalg.norm(seen - stands, axis=1).max()) / max(height, 1e-9)
