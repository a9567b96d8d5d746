"""In which frames a person could read a sign: from geometry alone, without drawing a picture."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera, inverse_transform, transform_points
from lpslam.simulation.lettering import is_chinese
from lpslam.simulation.lighting import Vectors, blocked
from lpslam.simulation.scene import Scene
from lpslam.simulation.signs import Sign

MIN_LATIN_PIXELS = 12.0  # height of a capital
MIN_CHINESE_PIXELS = 16.0  # height of a character: more strokes need more pixels
MAX_ANGLE = math.radians(50.0)  # between the sign's normal and the line of sight
MARGIN_PIXELS = 8.0  # all ink must be this far inside the image
MAX_BLUR_PIXELS = 3.0


def is_readable(
    sign: Sign,
    scene: Scene,
    camera: PinholeCamera,
    world_from_camera: NDArray[np.float64],
    world_from_start: NDArray[np.float64],
    world_from_end: NDArray[np.float64],
) -> bool:
    """Whether a person could read the sign in one frame.

    That is: seen within 50 degrees of its normal, all ink inside the image with a margin, letters of 12 pixels (Latin)
    or 16 (Chinese), at most 3 pixels of motion blur, nothing in between. The two further poses are those when the
    shutter opens and closes.
    """
    eye = world_from_camera[:3, 3]
    middle = sign.corners.mean(axis=0)
    way = eye - middle
    cosine = float(way @ sign.normal / np.linalg.norm(way))
    if (abs(cosine) if sign.double_sided else cosine) < math.cos(MAX_ANGLE):
        return False
    seen = transform_points(inverse_transform(world_from_camera), sign.corners)
    if seen[:, 2].min() < 0.3:
        return False
    pixels = camera.project(seen)
    limit = np.array([camera.width, camera.height]) - 1 - MARGIN_PIXELS
    if (pixels < MARGIN_PIXELS).any() or (pixels > limit).any():
        return False
    upright = np.linalg.norm(pixels[[0, 1]] - pixels[[3, 2]], axis=1).mean()
    letters = upright * sign.letter_height / sign.height
    if letters < (MIN_CHINESE_PIXELS if is_chinese(sign.text) else MIN_LATIN_PIXELS):
        return False
    opened = camera.project(transform_points(inverse_transform(world_from_start), sign.corners))
    closed = camera.project(transform_points(inverse_transform(world_from_end), sign.corners))
    if np.linalg.norm(closed - opened, axis=1).max() > MAX_BLUR_PIXELS:
        return False
    return not _covered(scene.origin, scene.edge_u, scene.edge_v, scene.normal, eye, _spots(sign))


def _spots(sign: Sign) -> NDArray[np.float64]:
    """(15, 3) points spread over a sign's ink: five across, three down."""
    upper_left, upper_right, _, lower_left = sign.corners
    across, down = np.meshgrid(np.linspace(0.01, 0.99, 5), np.linspace(0.05, 0.95, 3))
    spread = across.reshape(-1, 1) * (upper_right - upper_left) + down.reshape(-1, 1) * (lower_left - upper_left)
    return np.asarray(upper_left + spread)


@njit(cache=True, nogil=True)
def _covered(origin: Vectors, edge_u: Vectors, edge_v: Vectors, normal: Vectors, eye: Vectors, spots: Vectors) -> bool:
    """Whether anything stands before any of the spots; a double-sided sign's own thickness does not count."""
    for i in range(spots.shape[0]):  # noqa: SIM110 - generators do not compile
        if blocked(origin, edge_u, edge_v, normal, spots[i], eye, 0.09):
            return True
    return False
