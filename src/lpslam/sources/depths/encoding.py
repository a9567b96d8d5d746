"""Raw numbers of depth that are no multiples of a length: flags in upper bits, bytes in channels, inverse depth."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class DepthEncoding:
    """How the raw numbers of a depth picture are taken.

    Attributes:
        kept_bits: of each number the lowest that are depth; 0 for all.
        weights: of red, green and blue, whose sum is the number; empty where it has a channel of its own.
        numerator, offset: depth is numerator / (number + offset) metres; None where it is a multiple of a length.
        scale: numbers in a metre, where the encoding states it; None where the calibration does.
    """

    kept_bits: int = 0
    weights: tuple[float, ...] = ()
    numerator: float | None = None
    offset: float = 0.0
    scale: float | None = None

    def numbers(self, raw: NDArray[Any], *, is_blue_first: bool) -> NDArray[Any]:
        """One number a pixel: (height, width) of a picture with or without channels."""
        if self.weights and raw.ndim == 3 and raw.shape[2] >= 3:
            order = (2, 1, 0) if is_blue_first else (0, 1, 2)
            parts = [weight * raw[..., at].astype(np.float64) for at, weight in zip(order, self.weights, strict=True)]
            found = np.sum(parts, axis=0)
            # All ones are no reading, as of any type.
            return np.where(found >= 255 * sum(self.weights), 0.0, found).astype(np.uint32)
        if self.kept_bits and raw.dtype.kind in "ui":
            most = (1 << self.kept_bits) - 1
            return np.where((raw & most) == most, 0, raw & most).astype(raw.dtype)
        return raw

    def metres(self, numbers: NDArray[np.float32]) -> NDArray[np.float32]:
        """Depth of numbers that stand for its inverse; what is none stays 0."""
        if self.numerator is None:
            return numbers
        with np.errstate(divide="ignore", invalid="ignore"):
            found = np.float32(self.numerator) / (numbers + np.float32(self.offset))
        return np.where(np.isfinite(numbers) & (numbers > 0) & (found > 0), found, 0).astype(np.float32)
