"""Fields of numbers over a picture: softened, grained, bent."""

import cv2
import numpy as np
from numpy.typing import NDArray

Field = NDArray[np.float32]


def soft(field: NDArray[np.float32] | NDArray[np.bool_], across: float, down: float | None = None) -> Field:
    """A field blurred by so many pixels, across and down (as much without)."""
    down = across if down is None else down
    return np.asarray(cv2.GaussianBlur(field.astype(np.float32), (0, 0), sigmaX=across, sigmaY=down), np.float32)


def grain(rng: np.random.Generator, rows: int, columns: int, across: float, down: float | None = None) -> Field:
    """Noise (rows, columns) of unit deviation, even over so many pixels."""
    field = soft(rng.standard_normal((rows, columns)).astype(np.float32), across, down)
    return np.asarray(field / max(float(field.std()), 1e-6), np.float32)


def slopes(field: Field) -> tuple[Field, Field]:
    """How a field rises to the right and downwards (Sobel)."""
    right, down = cv2.Sobel(field, cv2.CV_32F, 1, 0), cv2.Sobel(field, cv2.CV_32F, 0, 1)
    return np.asarray(right, np.float32), np.asarray(down, np.float32)


def colour(value: tuple[float, float, float]) -> Field:
    """A colour (3,) to reckon with."""
    return np.array(value, np.float32)
