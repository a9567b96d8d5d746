"""Fields of noise: drawn once, shifted at random for every frame."""

import cv2
import numpy as np
from numpy.typing import NDArray

MARGIN = 48  # pixels by which the fields are larger than the image

Field = NDArray[np.float32]


class NoiseFields:
    """Smooth random fields of unit variance for images of one size.

    Args:
        rng: draws them.
        width, height: pixels.
        sigmas: of the smoothing of each kind of field, pixels; 0 for independent pixels.
    """

    def __init__(self, rng: np.random.Generator, width: int, height: int, sigmas: tuple[float, ...]) -> None:
        self._size = (height, width)
        self._fields = [_fields(rng, (height + MARGIN, width + MARGIN), sigma) for sigma in sigmas]

    def draw(self, rng: np.random.Generator, kind: int) -> Field:
        """(height, width) field of a kind, for one frame."""
        layers = self._fields[kind]
        height, width = self._size
        y, x = int(rng.integers(MARGIN)), int(rng.integers(MARGIN))
        layer = layers[int(rng.integers(len(layers)))]
        if rng.random() < 0.5:
            layer = layer[::-1]
        return np.ascontiguousarray(layer[y : y + height, x : x + width])


def _fields(rng: np.random.Generator, shape: tuple[int, int], sigma: float, count: int = 3) -> list[Field]:
    fields = []
    for _ in range(count):
        field = rng.standard_normal(shape, dtype=np.float32)
        if sigma > 0:
            field = np.asarray(cv2.GaussianBlur(field, (0, 0), sigma), np.float32)
        fields.append(np.asarray(field / field.std(), np.float32))
    return fields
