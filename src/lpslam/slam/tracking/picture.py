"""A frame and what was seen in it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lpslam.frames import RgbdFrame
from lpslam.slam.features import Features


@dataclass(frozen=True, slots=True, eq=False)
class Picture:
    """A frame with the keypoints that were found or followed in it.

    Attributes:
        gray: (h, w).
        features: its keypoints (n rows), straightened.
        seen: the same as they are in the image.
        is_repeated: whether the image is that of the frame before.
    """

    frame: RgbdFrame
    gray: NDArray[np.uint8]
    features: Features
    seen: Features
    is_repeated: bool

    @property
    def timestamp(self) -> float:
        """Seconds."""
        return self.frame.timestamp

    @property
    def depths(self) -> int:
        """How many keypoints have depth."""
        return int(self.features.has_depth.sum())
