"""How a camera sees a sign in every frame, and in which frames a person could read it: from geometry alone."""

import math
from dataclasses import dataclass

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
NEAREST = 0.3  # metres before the camera
STEEPEST = math.radians(85.0)  # views from farther aside show no text


@dataclass(frozen=True, slots=True, eq=False)
class SignViews:
    """How one sign is seen in each of n frames; columns of (n,).

    Attributes:
        letter_pixels: height of the main line's letters; 0 where the sign is behind the camera or seen from behind.
        angle: radians between the normal of the side that is seen and the line of sight.
        distance: metres.
        blur_pixels: farthest way of a corner while the shutter is open.
        inside: whether all ink is in the image, with a margin.
        seen_share: of its ink, how much is in the image and not covered; 0 where `letter_pixels` is.
        heights: of the lines' letters, in those of the main line's.
        needed_pixels: of each line, to be readable.
    """

    letter_pixels: NDArray[np.float64]
    angle: NDArray[np.float64]
    distance: NDArray[np.float64]
    blur_pixels: NDArray[np.float64]
    inside: NDArray[np.bool_]
    seen_share: NDArray[np.float64]
    heights: tuple[float, ...]
    needed_pixels: tuple[float, ...]

    def readable(self, line: int = 0) -> NDArray[np.bool_]:
        """In which frames a person could read a line of the sign.

        That is: seen within 50 degrees of its normal, all ink inside the image with a margin, letters of 12 pixels
        (Latin) or 16 (Chinese), at most 3 pixels of motion blur, nothing in between.
        """
        return np.asarray(
            (self.angle <= MAX_ANGLE)
            & self.inside
            & (self.letter_pixels * self.heights[line] >= self.needed_pixels[line])
            & (self.blur_pixels <= MAX_BLUR_PIXELS)
            & (self.seen_share == 1.0)
        )


def views_of(
    sign: Sign, scene: Scene, camera: PinholeCamera, middle: Vectors, opened: Vectors, closed: Vectors
) -> SignViews:
    """Say how a sign is seen.

    Args:
        sign, scene, camera: what is seen, what may stand before it, and by whom.
        middle, opened, closed: (n, 4, 4) world from camera at the middle of each exposure, and when the shutter opens
            and closes.
    """
    eyes = middle[:, :3, 3]
    way = eyes - sign.corners.mean(axis=0)
    distance = np.linalg.norm(way, axis=1)
    cosine = way @ sign.normal / distance
    angle = np.arccos(np.clip(np.abs(cosine) if sign.double_sided else cosine, -1.0, 1.0))

    seen = np.array([transform_points(inverse_transform(pose), sign.corners) for pose in middle]).reshape(-1, 4, 3)
    is_before = (seen[..., 2].min(axis=1) >= NEAREST) & (angle <= STEEPEST)
    pixels = np.full((len(middle), 4, 2), np.nan)
    pixels[is_before] = camera.project(seen[is_before].reshape(-1, 3)).reshape(-1, 4, 2)
    limit = np.array([camera.width, camera.height]) - 1 - MARGIN_PIXELS
    inside = is_before & ((pixels >= MARGIN_PIXELS) & (pixels <= limit)).all(axis=(1, 2))
    upright = np.linalg.norm(pixels[:, [0, 1]] - pixels[:, [3, 2]], axis=2).mean(axis=1)
    letters = np.where(is_before, upright * sign.letter_height / sign.height, 0.0)

    blur = np.zeros(len(middle))
    shares = np.zeros(len(middle))
    spots = _spots(sign)
    for row in np.flatnonzero(is_before).tolist():
        ends = [
            camera.project(transform_points(inverse_transform(pose[row]), sign.corners)) for pose in (opened, closed)
        ]
        blur[row] = np.linalg.norm(ends[1] - ends[0], axis=1).max()
        seen_spots = camera.project(transform_points(inverse_transform(middle[row]), spots))
        in_image = ((seen_spots >= 0) & (seen_spots <= [camera.width - 1, camera.height - 1])).all(axis=1)
        if in_image.any():
            shares[row] = _uncovered(
                scene.origin, scene.edge_u, scene.edge_v, scene.normal, eyes[row].copy(), spots[in_image]
            ) / len(spots)
    return SignViews(
        letter_pixels=letters,
        angle=angle,
        distance=distance,
        blur_pixels=blur,
        inside=inside,
        seen_share=shares,
        heights=tuple(line.letter_height / sign.letter_height for line in sign.lines),
        needed_pixels=tuple(MIN_CHINESE_PIXELS if is_chinese(line.text) else MIN_LATIN_PIXELS for line in sign.lines),
    )


def _spots(sign: Sign) -> NDArray[np.float64]:
    """(15, 3) points spread over a sign's ink: five across, three down."""
    upper_left, upper_right, _, lower_left = sign.corners
    across, down = np.meshgrid(np.linspace(0.01, 0.99, 5), np.linspace(0.05, 0.95, 3))
    spread = across.reshape(-1, 1) * (upper_right - upper_left) + down.reshape(-1, 1) * (lower_left - upper_left)
    return np.asarray(upper_left + spread)


@njit(cache=True, nogil=True)
def _uncovered(origin: Vectors, edge_u: Vectors, edge_v: Vectors, normal: Vectors, eye: Vectors, spots: Vectors) -> int:
    """Number of spots that nothing stands before; a double-sided sign's own thickness does not count."""
    count = 0
    for i in range(spots.shape[0]):
        if not blocked(origin, edge_u, edge_v, normal, spots[i], eye, 0.09):
            count += 1
    return count
