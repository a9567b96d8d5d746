"""Marks that say nothing beside a text: what stands among them is one of them, whatever it looks like.

A rune, a window of a lattice and a cell of a pattern may look like a letter from every side. The others of its row are
found as well, are as large, and are read as nothing.
"""

import numpy as np
from numpy.typing import NDArray

from lpslam.text.reading.boxes import Boxes

Mask = NDArray[np.bool_]

_ALIKE = 1.6
"""Largest ratio between the heights of two marks of one row, and between the areas of their boxes its square."""

_NEAR = 1.0
"""Gap between two such marks, in heights of the text's box."""


def are_among_marks(boxes: Boxes, marks: Boxes) -> Mask:
    """Tell which (n, 4, 2) boxes of texts have one of (m, 4, 2) boxes beside them that is as large and says nothing."""
    if not len(boxes) or not len(marks):
        return np.zeros(len(boxes), np.bool_)
    lows, highs = boxes.min(axis=1)[:, None], boxes.max(axis=1)[:, None]
    mark_lows, mark_highs = marks.min(axis=1), marks.max(axis=1)
    heights, mark_heights = (highs - lows)[..., 1], (mark_highs - mark_lows)[:, 1]
    areas, mark_areas = np.prod(highs - lows, axis=2), np.prod(mark_highs - mark_lows, axis=1)
    is_alike = (_ratio(heights, mark_heights) <= _ALIKE) & (_ratio(areas, mark_areas) <= _ALIKE**2)
    gaps = np.maximum(mark_lows - highs, lows - mark_highs).clip(0.0)
    is_near = np.linalg.norm(gaps, axis=2) <= _NEAR * heights
    return np.asarray((is_alike & is_near).any(axis=1), np.bool_)


def _ratio(first: NDArray[np.float64], second: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.maximum(first, second) / np.maximum(np.minimum(first, second), 1e-6)
