"""Fields of noise, drawn anew for every frame."""

import cv2
import numpy as np
from numpy.typing import NDArray

Field = NDArray[np.float32]


class NoiseFields:
    """Smooth random fields of unit variance for images of one size.

    Each frame has its own: a field that is shown twice, shifted or not, is a pattern that moves with nothing in the
    world, and whoever compares pictures finds it.

    Args:
        width, height: pixels.
        sigmas: of the smoothing of each kind of field, pixels; 0 for independent pixels.
    """

    def __init__(self, width: int, height: int, sigmas: tuple[float, ...]) -> None:
        self._shape, self._sigmas = (height, width), sigmas

    def draw(self, rng: np.random.Generator, kind: int) -> Field:
        """(height, width) field of a kind, for one frame."""
        field = rng.standard_normal(self._shape, dtype=np.float32)
        sigma = self._sigmas[kind]
        if sigma > 0:
            field = np.asarray(cv2.GaussianBlur(field, (0, 0), sigma), np.float32)
        return np.asarray(field / field.std(), np.float32)
