"""How a text is seen: how well it can be read, and on what ground it stands."""

import numpy as np
from numpy.typing import NDArray

from lpslam.text.types import Placement

Array = NDArray[np.float64]

# Box height from which a text is as legible as it gets, pixels; boxes are half as high again as their letters.
_FULL_HEIGHT = 28.0
# What a reading is worth at least, seen from afar or aslant: it is evidence all the same.
_LEAST = 0.4
# How far inside the box's edge its ground is looked at, as a share of its sides: boxes are looser than letters.
_EDGE = 0.04


def frontal_cosine(placement: Placement, keyframe_from_camera: Array) -> float:
    """Cosine of the angle between a text's normal and the direction it is seen from; 1 is from straight ahead."""
    ray = keyframe_from_camera[:3, 3] - np.array(placement.position)
    return float(np.array(placement.normal) @ ray / max(float(np.linalg.norm(ray)), 1e-9))


def legibility(letter_height: float, frontal: float) -> float:
    """What a reading is worth, 0 to 1: large letters from straight ahead are read right more often.

    Args:
        letter_height: pixels, of the box.
        frontal: cosine of the viewing angle.
    """
    seen = min(letter_height / _FULL_HEIGHT, 1.0) * min(max(frontal, 0.0), 1.0)
    return max(_LEAST, seen)


def ground_colour(rgb: NDArray[np.uint8], box: Array) -> tuple[int, int, int]:
    """Colour of the surface around the letters: the median along the edge of the (4, 2) box, just inside."""
    along = np.linspace(0.0, 1.0, 24)
    edge = np.concatenate(
        [
            np.column_stack([along, np.full(24, _EDGE)]),
            np.column_stack([along, np.full(24, 1.0 - _EDGE)]),
            np.column_stack([np.full(8, _EDGE), along[::3]]),
            np.column_stack([np.full(8, 1.0 - _EDGE), along[::3]]),
        ]
    )
    u, v = edge[:, :1], edge[:, 1:]
    top, bottom = box[0] + u * (box[1] - box[0]), box[3] + u * (box[2] - box[3])
    height, width = rgb.shape[:2]
    pixels = np.clip(np.rint(top + v * (bottom - top)), 0, [width - 1, height - 1]).astype(int)
    red, green, blue = np.median(rgb[pixels[:, 1], pixels[:, 0]], axis=0)
    return int(red), int(green), int(blue)


def is_same_ground(first: tuple[int, int, int], second: tuple[int, int, int], difference: float) -> bool:
    """Whether two colours may be one surface's, light falling off across it.

    Args:
        first, second: (red, green, blue), 0 to 255.
        difference: largest difference of a channel, as a share of the brightest channel of both.
    """
    a, b = np.array(first, dtype=np.float64), np.array(second, dtype=np.float64)
    return bool(np.abs(a - b).max() <= difference * max(a.max(), b.max(), 40.0))
