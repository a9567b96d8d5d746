"""Texts that go on behind something nearer, or on another surface."""

from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera, inverse_transform, transform_points
from lpslam.config import PlacementConfig
from lpslam.text.placing.by_depth.sampling import Array, depths_inside, grown
from lpslam.text.placing.views import sides_of, unit
from lpslam.text.reading.borders import goes_on
from lpslam.text.reading.boxes import along_the_lines
from lpslam.text.types import Placement


class PlacementFault(StrEnum):
    """Why a text could not be placed."""

    NO_DEPTH = "no usable depth"
    GRAZING = "surface seen at a grazing angle"
    HIDDEN = "partly hidden by something nearer"
    STEPPED = "on two surfaces, one behind the other"


def fault_at_ends(
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


def goes_on_behind_something_near(
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
    middle, along = line.mean(axis=0), unit(sides_of(line)[0])
    pixels, _, _ = depths_inside(grown(line, config.surroundings), depth, config)
    sides = (pixels - middle) @ along
    for strip, is_other_half in zip(_beyond_ends(line), (sides > 0.0, sides < 0.0), strict=True):
        _, beyond, area = depths_inside(strip, depth, config)
        if len(beyond) < max(config.hiding_share * area, 1.0):
            continue
        if np.count_nonzero(is_other_half) < config.min_samples:
            return True
    return False


def _beyond_ends(box: Array) -> tuple[Array, Array]:
    """The quadrilaterals (4, 2) that continue a text beyond its first and its last letter, for a part of a letter."""
    top_left, top_right, bottom_right, bottom_left = box
    along = unit((top_right + bottom_right - top_left - bottom_left) / 2.0)
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
    line: Array, depth: NDArray[np.float32], camera: PinholeCamera, inverse_plane: Array, config: PlacementConfig
) -> NDArray[np.bool_]:
    """Which pixels (height, width) on and about a line of text show something in front of its plane."""
    quadrilateral = grown(line, 1.0)
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
    placement: Placement | None,
    depth: NDArray[np.float32],
    camera: PinholeCamera,
    keyframe_from_camera: Array,
    config: PlacementConfig,
) -> NDArray[np.bool_]:
    """Which pixels (height, width) on and about the box (4, 2) of a text show something in front of it.

    Of a text without depth, beyond an end of which there is some, all that has depth is nearer; it may be placed on
    just that.
    """
    line = along_the_lines(box[None])[0]
    _, inside, area = depths_inside(line, depth, config)
    if len(inside) < config.min_depth_share * area and _ends_at_something_near(line, depth, config):
        return np.asarray((depth >= config.min_depth) & (depth <= config.max_depth), np.bool_)
    if placement is None:
        return np.zeros(depth.shape, np.bool_)
    camera_from_keyframe = inverse_transform(keyframe_from_camera)
    normal = camera_from_keyframe[:3, :3] @ np.array(placement.normal)
    position = transform_points(camera_from_keyframe, np.array([placement.position]))[0]
    return _nearer(line, depth, camera, normal / (normal @ position), config)


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
    pixels, depths, area = depths_inside(strip, depth, config)
    if len(depths) == 0:
        return np.zeros(0), area
    surface = 1.0 / np.maximum(
        camera.back_project(camera.undistort(pixels), np.ones(len(pixels))) @ inverse_plane, 1e-3
    )
    return (depths - surface) / (config.hiding_step + config.hiding_step_share * surface), area
