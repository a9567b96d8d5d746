"""One picture of a text from many views: each is warped to the text's plane, aligned, and all are averaged.

A view's noise, compression and sampling are its own; the letters are the same in all. Views are warped by what is known
of poses and plane, then moved by the affine map that makes them most alike (enhanced correlation coefficient,
Evangelidis and Psarakis, 2008).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera, inverse_transform, transform_points
from lpslam.config import SecondLookConfig
from lpslam.text.again.crops import Crop, Picture
from lpslam.text.placing.instances import KeyframePoses
from lpslam.text.placing.places import Place

Array = NDArray[np.float64]

# Pixels of blur before views are aligned: edges must be wider than what they are off by.
_ALIGNED_BLUR = 2.0
# Rounds of alignment, and the change of correlation below which it ends.
_ROUNDS, _ENOUGH = 30, 1e-3
# Pixels by which a text may reach beyond its cut-out and still be wholly in it.
_SLACK = 2.0
# Metres before the camera from which a corner can be projected.
_NEAREST = 0.1


@dataclass(frozen=True, slots=True, eq=False)
class Canvas:
    """The surface around a text seen from straight ahead.

    Attributes:
        rgb: (h, w, 3).
        box: (4, 2) pixels of it, the text's.
        corner: (3,) metres, world, of its first pixel's outer corner.
        scale: pixels a metre.
        views: how many crops were averaged.
        reference: that which the others were aligned with.
    """

    rgb: Picture
    box: Array
    corner: Array
    scale: float
    views: int
    reference: Crop


def canvas_of(
    place: Place,
    crops: Sequence[Crop],
    world_from_keyframe: KeyframePoses,
    camera: PinholeCamera,
    config: SecondLookConfig,
) -> Canvas | None:
    """Draw the surface around a text from all crops that show the whole of it; None where none does.

    Args:
        place: where the text stands.
        crops: of its sightings.
        world_from_keyframe: takes a keyframe's id to its 4×4 pose.
        camera: whose raw pixels the crops are.
        config: sizes and thresholds.
    """
    scale = config.line_height / max(place.letter, 1e-3)
    margin = config.margin * place.letter
    size = np.ceil(scale * np.array([place.width + 2.0 * margin, place.height + 2.0 * margin])).astype(int)
    if size.max() > config.longest:
        return None
    corner = place.position - place.baseline * size[0] / (2.0 * scale) - place.down * size[1] / (2.0 * scale)
    warped, sources = [], []
    for crop in crops:
        pose = world_from_keyframe(crop.keyframe)
        homography = None if pose is None else _crop_from_canvas(place, corner, scale, size, crop, pose, camera)
        if homography is not None and _shows(homography, _box(place, scale, size), crop):
            flags = cv2.INTER_CUBIC | cv2.WARP_INVERSE_MAP
            drawn = cv2.warpPerspective(
                crop.rgb, homography, size.tolist(), flags=flags, borderMode=cv2.BORDER_REPLICATE
            )
            warped.append(np.asarray(drawn, np.uint8))
            sources.append(crop)
    if not warped:
        return None
    sharpest = int(np.argmax([cv2.Laplacian(_grey(each), cv2.CV_32F).var() for each in warped]))
    mean, count = _average(warped, sharpest, config)
    return Canvas(mean, _box(place, scale, size), corner, scale, count, sources[sharpest])


def _box(place: Place, scale: float, size: NDArray[np.int64]) -> Array:
    half = np.array([place.width, place.height]) * scale / 2.0
    return size / 2.0 + np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * half


def _crop_from_canvas(
    place: Place,
    corner: Array,
    scale: float,
    size: NDArray[np.int64],
    crop: Crop,
    world_from_keyframe: Array,
    camera: PinholeCamera,
) -> Array | None:
    """3×3, pixels of the canvas to those of a crop; None where the camera does not face it."""
    outline = np.array([[0, 0], [size[0], 0], size, [0, size[1]]], np.float64)
    world = corner + (outline[:, :1] * place.baseline + outline[:, 1:] * place.down) / scale
    camera_from_world = inverse_transform(world_from_keyframe @ crop.keyframe_from_camera)
    points = transform_points(camera_from_world, world)
    if points[:, 2].min() < _NEAREST:
        return None
    own, undistorted = crop.corners(camera)
    to_ideal = cv2.getPerspectiveTransform(outline.astype(np.float32), camera.project(points).astype(np.float32))
    to_own = cv2.getPerspectiveTransform(undistorted.astype(np.float32), own.astype(np.float32))
    return np.asarray(to_own @ to_ideal, np.float64)


def _shows(homography: Array, box: Array, crop: Crop) -> bool:
    seen = cv2.perspectiveTransform(box[None].astype(np.float64), homography)[0]
    limit = np.array(crop.rgb.shape[1::-1]) - 1.0 + _SLACK
    return bool((seen >= -_SLACK).all() and (seen <= limit).all())


def _average(views: Sequence[Picture], sharpest: int, config: SecondLookConfig) -> tuple[Picture, int]:
    """The mean of all views that can be aligned with the sharpest, and how many they are."""
    smooth = [np.asarray(cv2.GaussianBlur(_grey(each), (0, 0), _ALIGNED_BLUR), np.float32) for each in views]
    ends = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, _ROUNDS, _ENOUGH)
    total, count = views[sharpest].astype(np.float32), 1
    for row, view in enumerate(views):
        if row == sharpest:
            continue
        try:
            motion = np.eye(2, 3, dtype=np.float32)
            alike, found = cv2.findTransformECC(smooth[sharpest], smooth[row], motion, cv2.MOTION_AFFINE, ends)
        except cv2.error:
            # What shares no structure with the reference cannot be aligned.
            continue
        if alike < config.alike:
            continue
        size = view.shape[1::-1]
        flags = cv2.INTER_CUBIC | cv2.WARP_INVERSE_MAP
        moved = cv2.warpAffine(view, found, size, flags=flags, borderMode=cv2.BORDER_REPLICATE)
        total += moved
        count += 1
    return np.clip(np.round(total / count), 0, 255).astype(np.uint8), count


def _grey(rgb: Picture) -> NDArray[np.float32]:
    return np.asarray(cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY), np.float32)
