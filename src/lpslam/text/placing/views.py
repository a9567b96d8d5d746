"""In which directions a text was seen: of one box in its keyframe, and of a class's observations in the world."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera, transform_points
from lpslam.config import InstanceConfig
from lpslam.text.placing.instances import KeyframePoses
from lpslam.text.placing.triangulation import middles
from lpslam.text.remembering.similarity import comparison_key
from lpslam.text.types import Bearing, Placement, TextObservation, Vector3

Array = NDArray[np.float64]
Rows = NDArray[np.intp]

BOX_STRAY = 0.1
"""How far the middle of a detected box strays from that of the text, as a share of the box's height."""

_POSE_NOISE = 0.003
"""Radians by which the poses of keyframes that see one text disagree: two pixels of a usual camera."""


def bearing_of(box: Array, camera: PinholeCamera, keyframe_from_camera: Array) -> Bearing:
    """The directions of a box's corners (4, 2), raw pixels, and where they were seen from, in the keyframe's frame."""
    rays = camera.back_project(camera.undistort(box), np.ones(4)) @ keyframe_from_camera[:3, :3].T
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    first, second, third, fourth = (vector3(ray) for ray in rays)
    return Bearing(vector3(keyframe_from_camera[:3, 3]), (first, second, third, fourth))


@dataclass(frozen=True, slots=True, eq=False)
class Views:
    """What n observations of a class say in the world.

    Attributes:
        origins: (n, 3) metres, of the camera.
        directions: (n, 3) unit, to the middle of the text.
        corners: (n, 4, 3) unit.
        noise: (n,) radians, standard deviation of the directions: as assumed of any box, and for what it lacks.
        lacking: (n,) radians, what the box may lack of its text, or have more than it.
        spellings: (n,) numbers, the same where the same was read.
        keyframes: (n,) on which they hang.
        frames: (n,) in which they were seen.
        placements: by depth, in the world; None without.
        sure: (n,) whether depth placed them surely.
    """

    origins: Array
    directions: Array
    corners: Array
    noise: Array
    lacking: Array
    spellings: Rows
    keyframes: NDArray[np.int64]
    frames: NDArray[np.int64]
    placements: list[Placement | None]
    sure: NDArray[np.bool_]

    def shares(self, rows: Rows) -> Array:
        """What each of some views counts, so that each keyframe counts once: its views share the errors of its pose."""
        _, inverse, counts = np.unique(self.keyframes[rows], return_inverse=True, return_counts=True)
        return np.asarray(1.0 / counts[inverse], np.float64)

    def keyframes_of(self, rows: Rows) -> int:
        """From how many keyframes some views are."""
        return len(np.unique(self.keyframes[rows]))


def views_of(
    observations: Sequence[TextObservation], world_from_keyframe: KeyframePoses, config: InstanceConfig
) -> Views:
    """Observations of one class, all of which have a bearing, by their keyframes' present poses.

    Raises:
        ValueError: the place of a keyframe, or a bearing, is not known.
    """
    origins, corners, placements = [], [], []
    for each in observations:
        pose = world_from_keyframe(each.keyframe)
        if pose is None or each.bearing is None:
            raise ValueError(f"an observation of keyframe {each.keyframe} has no place or no bearing")
        origins.append(transform_points(pose, np.array([each.bearing.origin]))[0])
        corners.append(np.array(each.bearing.corners) @ pose[:3, :3].T)
        placements.append(moved(each.placement, pose) if each.placement is not None else None)
    # The surface around a text is none to measure its middle on: it may not be the text's.
    sure = [each is not None and each.uncertainty <= config.doubtful_uncertainty for each in placements]
    towards = [
        np.array(each.position) - origin if each is not None and is_sure else None
        for each, origin, is_sure in zip(placements, origins, sure, strict=True)
    ]
    rays = np.array(corners)
    heights = np.linalg.norm(rays[:, 3] + rays[:, 2] - rays[:, 0] - rays[:, 1], axis=1) / 2.0
    widths = np.linalg.norm(rays[:, 1] + rays[:, 2] - rays[:, 0] - rays[:, 3], axis=1) / 2.0
    lacking = _lacking(observations, rays)
    _, spellings = np.unique([comparison_key(each.text) for each in observations], return_inverse=True)
    return Views(
        origins=np.array(origins),
        directions=middles(rays, towards),
        corners=rays,
        noise=np.hypot(np.hypot(BOX_STRAY * np.minimum(heights, widths), _POSE_NOISE), lacking),
        lacking=lacking,
        spellings=spellings,
        keyframes=np.array([each.keyframe for each in observations], np.int64),
        frames=np.array([each.frame for each in observations], np.int64),
        placements=placements,
        sure=np.array(sure, np.bool_),
    )


def _lacking(observations: Sequence[TextObservation], corners: Array) -> Array:
    """How far, radians (n,), a box's middle may be from that of the text for what was not read of it, or of more.

    A reading without its first letters has its middle farther on; as far as it is shorter than most, none can tell
    whether its box is, too.
    """
    letters = np.array([len(comparison_key(each.text)) for each in observations], np.float64)
    usual = max(float(np.median(letters)), 1.0)
    length = np.maximum(
        np.linalg.norm(corners[:, 1] + corners[:, 2] - corners[:, 0] - corners[:, 3], axis=1),
        np.linalg.norm(corners[:, 3] + corners[:, 2] - corners[:, 0] - corners[:, 1], axis=1),
    )
    return np.asarray(0.5 * np.abs(letters / usual - 1.0) * length / 2.0, np.float64)


def moved(placement: Placement, target_from_source: Array) -> Placement:
    """A placement in another frame of reference; the pose is 4×4."""
    rotation = target_from_source[:3, :3]
    return replace(
        placement,
        position=vector3(transform_points(target_from_source, np.array([placement.position]))[0]),
        normal=vector3(rotation @ np.array(placement.normal)),
        baseline=vector3(rotation @ np.array(placement.baseline)),
    )


def sides_of(corners: Array) -> tuple[Array, Array]:
    """Along and across a text by its corners (4, k): the means of two opposite sides, (k,) each."""
    first, second, third, fourth = corners
    return (second + third - first - fourth) / 2.0, (third + fourth - first - second) / 2.0


def placement_of(corners: Array, position: Array, normal: Array, uncertainty: float) -> Placement:
    """A text with corners (4, 3) metres on a surface, in their frame."""
    along, across = sides_of(corners)
    return Placement(
        vector3(position),
        vector3(normal),
        vector3(unit(along)),
        float(np.linalg.norm(along)),
        float(np.linalg.norm(across)),
        uncertainty,
    )


def unit(vector: Array) -> Array:
    """A vector (n,) of length 1."""
    return np.asarray(vector / max(float(np.linalg.norm(vector)), 1e-12), np.float64)


def vector3(array: Array) -> Vector3:
    """The first three of an array, as value types keep them."""
    return float(array[0]), float(array[1]), float(array[2])
