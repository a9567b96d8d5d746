"""From a text box, the depth image and the camera to a place in space (paper, III-F, Eq. 4-7)."""

from collections.abc import Callable
from enum import StrEnum

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera, inverse_transform, transform_points
from lpslam.config import PlacementConfig
from lpslam.text.reading.borders import goes_on
from lpslam.text.reading.boxes import along_the_lines, letter_heights
from lpslam.text.types import Placement, Vector3

Array = NDArray[np.float64]

# How far the middle of a detected box strays from that of the text, as a share of the box's height.
_BOX_STRAY = 0.1


class PlacementFault(StrEnum):
    """Why a text could not be placed."""

    NO_DEPTH = "no usable depth"
    GRAZING = "surface seen at a grazing angle"
    HIDDEN = "partly hidden by something nearer"
    STEPPED = "on two surfaces, one behind the other"


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
    middle_of_box = box.mean(axis=0)
    pixels, depths, area = _depths_inside(middle_of_box + (box - middle_of_box) * config.inner_share, depth, config)
    is_own = len(depths) >= max(config.min_samples, config.min_depth_share * area) and (
        _covered_share(box, pixels, area, config) >= config.min_covered_share
    )
    rays = camera.back_project(camera.undistort(pixels), np.ones(len(depths)))
    corner_rays = camera.back_project(camera.undistort(box), np.ones(4))
    if not is_own:
        if not is_cut and _goes_on_behind_something_near(box, depth, config, rgb):
            return PlacementFault.HIDDEN
        around = _grown(box, config.surroundings)
        pixels, depths, area = _depths_inside(around, depth, config)
        rays = camera.back_project(camera.undistort(pixels), np.ones(len(depths)))
        is_along = _covered_share(around, pixels, area, config) >= config.min_covered_share
        if len(depths) < config.min_samples or not is_along or not _surround(corner_rays.mean(axis=0), rays):
            rays, depths = _points_inside(_grown(box, config.surroundings_of_points), map_points(), camera, config)
            if len(depths) < config.min_points:
                return PlacementFault.NO_DEPTH

    inverse_plane, inliers = fit_inverse_depth_plane(rays, 1.0 / depths, config)
    corner_inverse_depths = corner_rays @ inverse_plane
    # A plane that leaves the box's corners without a believable depth is no surface to write on.
    believable = (corner_inverse_depths > 0.5 / config.max_depth) & (corner_inverse_depths < 2.0 / config.min_depth)
    is_plane = inliers.mean() >= config.min_inlier_share and believable.all()
    if not is_own:
        supported = is_plane and _surround(corner_rays.mean(axis=0), rays[inliers])
        if not supported or not _lies_between(corner_inverse_depths, 1.0 / depths[inliers], config):
            return PlacementFault.NO_DEPTH
    if not is_plane:
        middle = np.median(depths)
        corners = corner_rays * middle
        normal = -_unit(corners.mean(axis=0))
        noise = float(np.median(np.abs(depths - middle))) * 1.4826
    else:
        corners = corner_rays / corner_inverse_depths[:, None]
        # The plane n·p = d, divided by its depth, is linear in the ray: its coefficients point along the normal.
        normal = -_unit(inverse_plane)
        line = along_the_lines(box[None])[0]
        fault = None if is_cut else _fault_at_ends(line, depth, camera, inverse_plane, config, rgb)
        if fault is not None:
            return fault
        residuals = 1.0 / depths[inliers] - rays[inliers] @ inverse_plane
        noise = float(np.std(residuals)) * float(np.median(depths)) ** 2

    centre = corners.mean(axis=0)
    view_angle = np.degrees(np.arccos(np.clip(-_unit(centre) @ normal, -1.0, 1.0)))
    if view_angle > config.max_view_angle:
        return PlacementFault.GRAZING
    along = (corners[1] + corners[2] - corners[0] - corners[3]) / 2.0
    across = (corners[2] + corners[3] - corners[0] - corners[1]) / 2.0
    width, height = float(np.linalg.norm(along)), float(np.linalg.norm(across))
    spread = np.hypot(noise / np.sqrt(len(depths) / 10.0), _BOX_STRAY * height)
    rotation = keyframe_from_camera[:3, :3]
    return Placement(
        position=_vector(transform_points(keyframe_from_camera, centre[None])[0]),
        normal=_vector(rotation @ normal),
        baseline=_vector(rotation @ _unit(along)),
        width=width,
        height=height,
        uncertainty=float(spread if is_own else np.hypot(spread, config.surroundings_uncertainty)),
    )


def _covered_share(box: Array, pixels: Array, area: int, config: PlacementConfig) -> float:
    """Share of a text's length along which its box has depth at pixels (n, 2), of so many that were looked at.

    Of a text beyond the sensor's reach, whoever walks by has all the depth: on a few letters, and not on the rest.
    """
    line = along_the_lines(box[None])[0]
    along = line[1] + line[2] - line[0] - line[3]
    length = float(np.linalg.norm(along)) / 2.0
    parts = max(_FEWEST_PARTS, round(_PARTS_OF_A_LETTER * length / max(float(letter_heights(box[None])[0]), 1.0)))
    at = (pixels - line.mean(axis=0)) @ _unit(along) / (config.inner_share * length) + 0.5
    counts = np.bincount(np.clip((at * parts).astype(int), 0, parts - 1), minlength=parts)
    return float(np.mean(counts >= max(1.0, config.min_depth_share * area / parts)))


_PARTS_OF_A_LETTER = 3
"""Of a text's length, in the height of a letter: each has depth or not."""

_FEWEST_PARTS = 8
"""Of a short word."""


def _fault_at_ends(
    line: Array,
    depth: NDArray[np.float32],
    camera: PinholeCamera,
    inverse_plane: Array,
    config: PlacementConfig,
    rgb: NDArray[np.uint8] | None,
) -> PlacementFault | None:
    """Whether a line of text on a plane goes on behind something nearer, or on another surface."""
    is_at_something = any(_hides(strip, depth, camera, inverse_plane, config) for strip in _beyond_ends(line))
    if is_at_something and (rgb is None or goes_on(rgb, line, _nearer(line, depth, camera, inverse_plane, config))):
        return PlacementFault.HIDDEN
    if any(_steps(strip, depth, camera, inverse_plane, config) for strip in _ends(line, config.inner_share)):
        return PlacementFault.STEPPED
    return None


def _grown(box: Array, share: float) -> Array:
    """The box (4, 2) with so large a share of its letters' height added on every side."""
    top_left, top_right, bottom_right, bottom_left = box
    along = _unit(top_right + bottom_right - top_left - bottom_left)
    across = _unit(bottom_left + bottom_right - top_left - top_right)
    outwards = np.array([-along - across, along - across, along + across, across - along])
    return np.asarray(box + share * float(letter_heights(box[None])[0]) * outwards, dtype=np.float64)


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


def _goes_on_behind_something_near(
    box: Array, depth: NDArray[np.float32], config: PlacementConfig, rgb: NDArray[np.uint8] | None
) -> bool:
    """Whether what is near hides the rest of a text without depth; without an image, all at an end does."""
    line = along_the_lines(box[None])[0]
    if not _ends_at_something_near(line, depth, config):
        return False
    # Of a text beyond the sensor's reach all that has depth is nearer.
    return rgb is None or goes_on(rgb, line, (depth >= config.min_depth) & (depth <= config.max_depth))


def _ends_at_something_near(line: Array, depth: NDArray[np.float32], config: PlacementConfig) -> bool:
    """Whether a text (4, 2) without depth begins or ends where something nearer stands.

    At one end there is depth, and around the other half of the text there is none.
    """
    middle, along = line.mean(axis=0), _unit(line[1] + line[2] - line[0] - line[3])
    pixels, _, _ = _depths_inside(_grown(line, config.surroundings), depth, config)
    sides = (pixels - middle) @ along
    for strip, is_other_half in zip(_beyond_ends(line), (sides > 0.0, sides < 0.0), strict=True):
        _, beyond, area = _depths_inside(strip, depth, config)
        if len(beyond) < max(config.hiding_share * area, 1.0):
            continue
        if np.count_nonzero(is_other_half) < config.min_samples:
            return True
    return False


def _points_inside(
    quadrilateral: Array, points: Array, camera: PinholeCamera, config: PlacementConfig
) -> tuple[Array, Array]:
    """Of points (n, 3) in the camera's frame those seen inside: their rays (m, 3) and depths (m,)."""
    points = points[(points[:, 2] >= config.min_depth) & (points[:, 2] <= config.max_depth)]
    quadrilateral = camera.undistort(quadrilateral)
    sides = np.roll(quadrilateral, -1, axis=0) - quadrilateral
    offsets = camera.project(points)[:, None] - quadrilateral
    inside = (sides[:, 0] * offsets[..., 1] - sides[:, 1] * offsets[..., 0] > 0.0).all(axis=1)
    depths = points[inside, 2]
    return points[inside] / depths[:, None], depths


def fit_inverse_depth_plane(
    rays: Array, inverse_depths: Array, config: PlacementConfig
) -> tuple[Array, NDArray[np.bool_]]:
    """Fit a plane robustly to points seen along rays.

    On a plane the inverse depth is linear in the ray (x/z, y/z, 1), and there the error of a stereo or
    structured-light sensor, which grows with depth squared, is the same everywhere: plain least squares is then right.

    Args:
        rays: (n, 3) with third component 1.
        inverse_depths: (n,) 1/m.
        config: band, trials.

    Returns:
        (3,) coefficients c with inverse depth = rays @ c, and which points (n,) lie on the plane.
    """
    # A fixed seed: the same picture gives the same map.
    triples = np.random.default_rng(0).integers(0, len(rays), (config.trials, 3))
    systems = rays[triples]
    solvable = np.abs(np.linalg.det(systems)) > 1e-9
    candidates = np.zeros((0, 3))
    if solvable.any():
        candidates = np.linalg.solve(systems[solvable], inverse_depths[triples[solvable]][:, :, None])[:, :, 0]
    flat = np.array([[0.0, 0.0, float(np.median(inverse_depths))]])
    candidates = np.vstack([flat, candidates])
    residuals = np.abs(inverse_depths - candidates @ rays.T)
    coefficients = candidates[(residuals < config.inverse_depth_band).sum(axis=1).argmax()]
    for _ in range(3):
        inliers = np.abs(inverse_depths - rays @ coefficients) < config.inverse_depth_band
        if inliers.sum() < 3:
            break
        coefficients = np.linalg.lstsq(rays[inliers], inverse_depths[inliers], rcond=None)[0]
    return coefficients, np.abs(inverse_depths - rays @ coefficients) < config.inverse_depth_band


def _beyond_ends(box: Array) -> tuple[Array, Array]:
    """The quadrilaterals (4, 2) that continue a text beyond its first and its last letter, for a part of a letter."""
    top_left, top_right, bottom_right, bottom_left = box
    along = _unit((top_right + bottom_right - top_left - bottom_left) / 2.0)
    letter = np.linalg.norm(bottom_left + bottom_right - top_left - top_right) / 2.0
    step, upper, lower = 0.4 * letter * along, 0.8, 0.2
    left = np.array([bottom_left + (top_left - bottom_left) * share for share in (upper, lower)])
    right = np.array([bottom_right + (top_right - bottom_right) * share for share in (upper, lower)])
    return np.vstack([left - step, left[::-1]]), np.vstack([right, (right + step)[::-1]])


def _hides(
    strip: Array, depth: NDArray[np.float32], camera: PinholeCamera, inverse_plane: Array, config: PlacementConfig
) -> bool:
    """Whether something stands in front of the text's plane beyond its end: then the text goes on behind it.

    A text cut off so misleads like one that is cut off by the image's border (Fig. 11), only that it stays so for long.
    """
    offsets, area = _offsets_from_plane(strip, depth, camera, inverse_plane, config)
    return bool((offsets < -1.0).sum() >= max(3.0, config.hiding_share * area))


def _nearer(
    line: Array,
    depth: NDArray[np.float32],
    camera: PinholeCamera,
    inverse_plane: Array,
    config: PlacementConfig,
) -> NDArray[np.bool_]:
    """Which pixels (height, width) on and about a line of text show something in front of its plane."""
    quadrilateral = _grown(line, 1.0)
    nearer = np.zeros(depth.shape, np.bool_)
    low = np.clip(np.floor(quadrilateral.min(axis=0)).astype(int), 0, None)
    high = np.clip(np.ceil(quadrilateral.max(axis=0)).astype(int) + 1, 0, depth.shape[::-1])
    rows, columns = (each.ravel() for each in np.mgrid[low[1] : high[1], low[0] : high[0]])
    pixels = np.column_stack([columns, rows]).astype(np.float64)
    rays = camera.back_project(camera.undistort(pixels), np.ones(len(pixels)))
    surface = 1.0 / np.maximum(rays @ inverse_plane, 1e-3)
    values = depth[rows, columns]
    is_step = values < surface - config.hiding_step - config.hiding_step_share * surface
    nearer[rows, columns] = (values >= config.min_depth) & is_step
    return nearer


def hidden_pixels(
    box: Array,
    placement: Placement,
    depth: NDArray[np.float32],
    camera: PinholeCamera,
    keyframe_from_camera: Array,
    config: PlacementConfig,
) -> NDArray[np.bool_]:
    """Which pixels (height, width) on and about the box (4, 2) of a placed text show something in front of it."""
    camera_from_keyframe = inverse_transform(keyframe_from_camera)
    normal = camera_from_keyframe[:3, :3] @ np.array(placement.normal)
    position = transform_points(camera_from_keyframe, np.array([placement.position]))[0]
    return _nearer(along_the_lines(box[None])[0], depth, camera, normal / (normal @ position), config)


def _ends(box: Array, share: float) -> tuple[Array, Array]:
    """The quadrilaterals (4, 2) of the box's first and last letter, so much narrower than the box as `share` says."""
    middle = box.mean(axis=0)
    top_left, top_right, bottom_right, bottom_left = middle + (box - middle) * share
    along = np.linalg.norm(top_right + bottom_right - top_left - bottom_left)
    across = np.linalg.norm(bottom_left + bottom_right - top_left - top_right)
    part = min(0.5 * float(across / along), 0.25)
    left = np.array([top_left, top_left + (top_right - top_left) * part])
    left = np.vstack([left, [bottom_left + (bottom_right - bottom_left) * part, bottom_left]])
    right = np.array([top_right + (top_left - top_right) * part, top_right])
    right = np.vstack([right, [bottom_right, bottom_right + (bottom_left - bottom_right) * part]])
    return left, right


def _steps(
    strip: Array, depth: NDArray[np.float32], camera: PinholeCamera, inverse_plane: Array, config: PlacementConfig
) -> bool:
    """Whether an end of the text lies on another surface than the rest: two signs that look like one line from here."""
    offsets, area = _offsets_from_plane(strip, depth, camera, inverse_plane, config)
    share = max(3.0, config.stepping_share * area)
    return bool((offsets < -1.0).sum() >= share or (offsets > 1.0).sum() >= share)


def _offsets_from_plane(
    strip: Array, depth: NDArray[np.float32], camera: PinholeCamera, inverse_plane: Array, config: PlacementConfig
) -> tuple[Array, int]:
    """How far beyond the plane (n,) the depths inside lie, in hiding steps; and how many pixels were looked at."""
    pixels, depths, area = _depths_inside(strip, depth, config)
    if len(depths) == 0:
        return np.zeros(0), area
    surface = 1.0 / np.maximum(
        camera.back_project(camera.undistort(pixels), np.ones(len(pixels))) @ inverse_plane, 1e-3
    )
    return (depths - surface) / (config.hiding_step + config.hiding_step_share * surface), area


def _depths_inside(
    quadrilateral: Array, depth: NDArray[np.float32], config: PlacementConfig
) -> tuple[Array, Array, int]:
    """Pixels (n, 2) and depths (n,) inside, thinned evenly, and how many pixels were looked at."""
    height, width = depth.shape
    low = np.clip(np.floor(quadrilateral.min(axis=0)), 0, [width - 1, height - 1]).astype(int)
    high = np.clip(np.ceil(quadrilateral.max(axis=0)), 0, [width - 1, height - 1]).astype(int)
    mask = np.zeros(high[::-1] - low[::-1] + 1, np.uint8)
    cv2.fillConvexPoly(mask, np.round(quadrilateral - low).astype(np.int32), 1)
    rows, columns = np.nonzero(mask)
    step = -(-len(rows) // config.samples)
    rows, columns = rows[::step] + low[1], columns[::step] + low[0]
    values = depth[rows, columns].astype(np.float64)
    usable = np.isfinite(values) & (values >= config.min_depth) & (values <= config.max_depth)
    return np.column_stack([columns, rows])[usable].astype(np.float64), values[usable], len(values)


def _unit(vector: Array) -> Array:
    return vector / np.linalg.norm(vector)


def _vector(array: Array) -> Vector3:
    return float(array[0]), float(array[1]), float(array[2])


def is_squeezed(text: str, placement: Placement | PlacementFault) -> bool:
    """Whether one character was read of what has room for more: two ideographs seen aslant look like another one."""
    if sum(ch.isalnum() for ch in text) != 1:
        return False
    if isinstance(placement, PlacementFault):
        return True
    return max(placement.width, placement.height) > _SQUARE * min(placement.width, placement.height)


_SQUARE = 1.5
"""Largest ratio of the sides of a character's box, in metres."""
