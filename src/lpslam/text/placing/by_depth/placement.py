"""From a text box, the depth image and the camera to a place in space (paper, III-F, Eq. 4-7)."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.config import PlacementConfig
from lpslam.text.placing.by_depth.hiding import PlacementFault, fault_at_ends, goes_on_behind_something_near
from lpslam.text.placing.by_depth.sampling import (
    Array,
    covered_share,
    depths_inside,
    fit_inverse_depth_plane,
    grown,
    points_inside,
)
from lpslam.text.placing.views import BOX_STRAY, moved, placement_of, sides_of, unit
from lpslam.text.reading.boxes import along_the_lines
from lpslam.text.types import Placement


def place_text(
    box: Array,
    depth: NDArray[np.float32],
    camera: PinholeCamera,
    keyframe_from_camera: Array,
    config: PlacementConfig,
    map_points: Callable[[], Array] = lambda: np.zeros((0, 3)),
    rgb: NDArray[np.uint8] | None = None,
    is_cut: bool = False,
) -> Placement | PlacementFault:
    """Place a text box in its reference keyframe's frame.

    The paper back-projects the mean of the box's corners with the depth there (Eq. 7). One pixel's depth is noisy, may
    be a hole or belong to whatever hangs in front, and the middle of a box seen askance is not the middle of the text:
    so a plane is fitted to all depths inside, the corners' rays are met with it, and the mean is taken in space. Where
    the sign gives no depth, being glossy or black, the plane is that of the surface around it, or of the map's points.

    Args:
        box: (4, 2) raw pixels, ordered top left, top right, bottom right, bottom left.
        depth: (height, width) metres, 0 where there is none.
        camera: whose raw pixels these are.
        keyframe_from_camera: 4×4.
        config: thresholds.
        map_points: gives (n, 3) metres, points of the map that are in view, in the camera's frame; asked where depth
            fails.
        rgb: (h, w, 3), which shows whether a text ends before something nearer; without it that hides the rest.
        is_cut: whether it is known that the text goes on where the view ends: what is in view is placed.

    Returns:
        The placement, or why there is none.
    """
    corner_rays = camera.back_project(camera.undistort(box), np.ones(4))
    support = _support(box, corner_rays.mean(axis=0), depth, camera, config, map_points)
    if not support.is_own and not is_cut and goes_on_behind_something_near(box, depth, config, rgb):
        return PlacementFault.HIDDEN
    if not support.is_enough:
        return PlacementFault.NO_DEPTH
    surface = _surface(corner_rays, support, config)
    if surface is None:
        return PlacementFault.NO_DEPTH
    if surface.inverse_plane is not None and not is_cut:
        line = along_the_lines(box[None])[0]
        fault = fault_at_ends(line, depth, camera, surface.inverse_plane, config, rgb)
        if fault is not None:
            return fault
    corners = surface.corners
    centre = corners.mean(axis=0)
    view_angle = np.degrees(np.arccos(np.clip(-unit(centre) @ surface.normal, -1.0, 1.0)))
    if view_angle > config.max_view_angle:
        return PlacementFault.GRAZING
    height = float(np.linalg.norm(sides_of(corners)[1]))
    spread = float(np.hypot(surface.noise / np.sqrt(len(support.depths) / 10.0), BOX_STRAY * height))
    uncertainty = spread if support.is_own else float(np.hypot(spread, config.surroundings_uncertainty))
    return moved(placement_of(corners, centre, surface.normal, uncertainty), keyframe_from_camera)


@dataclass(frozen=True, slots=True, eq=False)
class _Support:
    """What tells the surface of a text.

    Attributes:
        rays, depths: (n, 3) with third component 1, (n,) metres.
        is_own: whether these lie on the text itself, not around it.
        is_enough: whether they may tell a surface at all.
    """

    rays: Array
    depths: Array
    is_own: bool
    is_enough: bool


@dataclass(frozen=True, slots=True, eq=False)
class _Surface:
    """Where a text is painted, in the camera's frame.

    Attributes:
        corners: (4, 3) metres.
        normal: (3,) towards the camera.
        noise: metres, by which depths stray from it.
        inverse_plane: (3,) inverse depth by ray; None where there is no plane: the text faces the camera.
    """

    corners: Array
    normal: Array
    noise: float
    inverse_plane: Array | None


def _support(
    box: Array,
    middle: Array,
    depth: NDArray[np.float32],
    camera: PinholeCamera,
    config: PlacementConfig,
    map_points: Callable[[], Array],
) -> _Support:
    """Depths inside a box (4, 2) whose middle is seen along a ray (3,), else around it, else points of the map."""
    middle_of_box = box.mean(axis=0)
    pixels, depths, area = depths_inside(middle_of_box + (box - middle_of_box) * config.inner_share, depth, config)
    rays = camera.back_project(camera.undistort(pixels), np.ones(len(depths)))
    if len(depths) >= max(config.min_samples, config.min_depth_share * area) and (
        covered_share(box, pixels, area, config) >= config.min_covered_share
    ):
        return _Support(rays, depths, True, True)
    around = grown(box, config.surroundings)
    pixels, depths, area = depths_inside(around, depth, config)
    rays = camera.back_project(camera.undistort(pixels), np.ones(len(depths)))
    is_along = covered_share(around, pixels, area, config) >= config.min_covered_share
    if len(depths) >= config.min_samples and is_along and _surround(middle, rays):
        return _Support(rays, depths, False, True)
    rays, depths = points_inside(grown(box, config.surroundings_of_points), map_points(), camera, config)
    return _Support(rays, depths, False, len(depths) >= config.min_points)


def _surface(corner_rays: Array, support: _Support, config: PlacementConfig) -> _Surface | None:
    """The surface that a text's corners, seen along rays (4, 3), lie on; None where what is around it tells none."""
    rays, depths = support.rays, support.depths
    inverse_plane, inliers = fit_inverse_depth_plane(rays, 1.0 / depths, config)
    corner_inverse_depths = corner_rays @ inverse_plane
    # A plane that leaves the box's corners without a believable depth is no surface to write on.
    believable = (corner_inverse_depths > 0.5 / config.max_depth) & (corner_inverse_depths < 2.0 / config.min_depth)
    is_plane = inliers.mean() >= config.min_inlier_share and believable.all()
    if not support.is_own:
        supported = is_plane and _surround(corner_rays.mean(axis=0), rays[inliers])
        if not supported or not _lies_between(corner_inverse_depths, 1.0 / depths[inliers], config):
            return None
    if not is_plane:
        middle = np.median(depths)
        corners = corner_rays * middle
        noise = float(np.median(np.abs(depths - middle))) * 1.4826
        return _Surface(corners, -unit(corners.mean(axis=0)), noise, None)
    residuals = 1.0 / depths[inliers] - rays[inliers] @ inverse_plane
    noise = float(np.std(residuals)) * float(np.median(depths)) ** 2
    # The plane n·p = d, divided by its depth, is linear in the ray: its coefficients point along the normal.
    return _Surface(corner_rays / corner_inverse_depths[:, None], -unit(inverse_plane), noise, inverse_plane)


def _surround(middle: Array, rays: Array) -> bool:
    """Whether rays (n, 3) lie on all sides of the middle (3,) of a box: what is on one side may hang before it."""
    offsets = rays[:, :2] - middle[:2]
    angles = np.sort(np.arctan2(offsets[:, 1], offsets[:, 0]))
    gaps = np.diff(angles, append=angles[:1] + 2.0 * np.pi)
    return bool(len(angles) and gaps.max() < _WIDEST_GAP)


_WIDEST_GAP = 0.75 * np.pi
"""Radians around a box without evidence: one side of it may be cut off, two may not."""


def _lies_between(corners: Array, support: Array, config: PlacementConfig) -> bool:
    """Whether a text's surface, taken from what is around it, is one surface and not two that a plane goes through.

    Both ends of a slanted plane may lie on things of their own, one near and one far: a pillar and the wall behind it.
    On one surface some of the support lies at depths between those of the text's ends.

    Args:
        corners: (4,) inverse depths of the text's corners on the plane, 1/m.
        support: (n,) inverse depths of what the plane was fitted to.
        config: thresholds.
    """
    nearest, farthest = float(corners.max()), float(corners.min())
    quarter = 0.25 * (nearest - farthest)
    if 4.0 * quarter <= 2.0 * config.inverse_depth_band:
        return True
    between = np.count_nonzero((support > farthest + quarter) & (support < nearest - quarter))
    return bool(between >= max(3.0, config.between_share * len(support)))


def is_squeezed(text: str, placement: Placement | PlacementFault) -> bool:
    """Whether one character was read of what has room for more: two ideographs seen aslant look like another one."""
    if sum(ch.isalnum() for ch in text) != 1:
        return False
    if isinstance(placement, PlacementFault):
        return True
    return max(placement.width, placement.height) > _SQUARE * min(placement.width, placement.height)


_SQUARE = 1.5
"""Largest ratio of the sides of a character's box, in metres."""
