"""How a text is seen: how well it can be read, and on what ground it stands."""

from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.text.types import Placement

Array = NDArray[np.float64]

# Cosine of the viewing angle of what has no sure place: beyond the depth sensor's reach, or all but edge-on.
UNPLACED = 0.5
# How far beyond a box's long sides its ground is looked at too, as a share of its height.
_BEYOND = 0.1
# Brightness below which colours are mostly noise.
_DARK = 40.0


def frontal_cosine(placement: Placement, keyframe_from_camera: Array) -> float:
    """Cosine of the angle between a text's normal and the direction it is seen from; 1 is from straight ahead."""
    ray = keyframe_from_camera[:3, 3] - np.array(placement.position)
    return float(np.array(placement.normal) @ ray / max(float(np.linalg.norm(ray)), 1e-9))


class SeenSize(NamedTuple):
    """How large letters are seen: height of the box, pixels, and cosine of the viewing angle."""

    height: float
    frontal: float

    @property
    def effective(self) -> float:
        """Pixels of height times the cosine, which narrows the letters."""
        return self.height * min(max(self.frontal, 0.0), 1.0)


def ground_colour(rgb: NDArray[np.uint8], box: Array) -> tuple[int, int, int]:
    """Colour of the surface around the letters in the (4, 2) box: of its bright and its dark part, that of the larger.

    Letters cover less of a line than what they are written on.
    """
    across = np.linspace(-_BEYOND, 1.0 + _BEYOND, 24)[:, None, None]
    along = np.linspace(0.0, 1.0, 64)[None, :, None]
    top, bottom = box[0] + along * (box[1] - box[0]), box[3] + along * (box[2] - box[3])
    height, width = rgb.shape[:2]
    pixels = np.clip(np.rint(top + across * (bottom - top)), 0, [width - 1, height - 1]).astype(int)
    colours = rgb[pixels[..., 1], pixels[..., 0]].reshape(-1, 3)
    bright = colours.astype(np.float32).mean(axis=1).astype(np.uint8)
    _, is_bright = cv2.threshold(bright, 0, 1, cv2.THRESH_BINARY | cv2.THRESH_OTSU)
    larger = is_bright.ravel() == (2 * int(is_bright.sum()) >= len(bright))
    red, green, blue = np.median(colours[larger], axis=0)
    return int(red), int(green), int(blue)


def ground_difference(first: tuple[int, int, int], second: tuple[int, int, int]) -> float:
    """Largest difference of a channel of two colours, 0 to 255, as a share of the brightest channel of both."""
    a, b = np.array(first, dtype=np.float64), np.array(second, dtype=np.float64)
    return float(np.abs(a - b).max() / max(a.max(), b.max(), _DARK))
