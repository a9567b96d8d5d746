"""How a text is seen: how well it can be read, and on what ground it stands."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lpslam.text.types import Placement

Array = NDArray[np.float64]

# Cosine of the viewing angle of what has no sure place: beyond the depth sensor's reach, or all but edge-on.
UNPLACED = 0.5
# Brightness below which colours are mostly noise.
_DARK = 40.0
# Brightness below which a colour has little hue.
_HUELESS = 80.0


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


def ground_difference(first: tuple[int, int, int], second: tuple[int, int, int]) -> float:
    """Largest difference of a channel of two colours, 0 to 255, as a share of the brightest channel of both."""
    a, b = np.array(first, dtype=np.float64), np.array(second, dtype=np.float64)
    return float(np.abs(a - b).max() / max(a.max(), b.max(), _DARK))


def hue_difference(first: tuple[int, int, int], second: tuple[int, int, int]) -> float:
    """Largest difference of a channel of two colours made equally bright, 0 to 1: uneven light leaves these alike.

    Very dark colours have no hue of their own and differ from bright ones.
    """
    a, b = np.array(first, dtype=np.float64), np.array(second, dtype=np.float64)
    return float(np.abs(a / max(a.max(), _HUELESS) - b / max(b.max(), _HUELESS)).max())
