"""What the corners of a text's box say of it."""

import numpy as np
from numpy.typing import NDArray

Boxes = NDArray[np.float64]
"""(n, 4, 2) raw pixels, each box ordered top left, top right, bottom right, bottom left."""

DOWNWARDS = 1.5
"""Ratio of height to width from which a box holds a line that runs downwards."""


def letter_heights(boxes: Boxes) -> NDArray[np.float64]:
    """Height of the letters in (n, 4, 2) boxes, (n,) pixels: across the direction of writing."""
    width, height = widths_and_heights(boxes)
    # A line that runs downwards is as wide as its letters.
    return np.where(runs_downwards(boxes), width, height)


def runs_downwards(boxes: Boxes) -> NDArray[np.bool_]:
    """Tell which (n, 4, 2) boxes hold a line that runs downwards: those half again as high as wide."""
    width, height = widths_and_heights(boxes)
    return height >= DOWNWARDS * width


def may_run_either_way(boxes: Boxes) -> NDArray[np.bool_]:
    """Tell which (n, 4, 2) boxes are about as wide as high: one character, or two of which a part is in view."""
    width, height = widths_and_heights(boxes)
    return (height < DOWNWARDS * width) & (width < DOWNWARDS * height)


def along_the_lines(boxes: Boxes) -> Boxes:
    """The (n, 4, 2) boxes, those whose line runs downwards turned so that its first letter is on the left."""
    return np.where(runs_downwards(boxes)[:, None, None], np.roll(boxes, -1, axis=1), boxes)


def share_a_middle(box: Boxes, others: Boxes) -> bool:
    """Whether the middle of one of (n, 4, 2) boxes lies within a (4, 2) box, or its middle within one of them."""
    least, most = others.min(axis=1), others.max(axis=1)
    inside = [(box.min(axis=0) <= (least + most) / 2.0) & ((least + most) / 2.0 <= box.max(axis=0))]
    inside.append((least <= box.mean(axis=0)) & (box.mean(axis=0) <= most))
    return bool(np.any([each.all(axis=1) for each in inside]))


def widths_and_heights(boxes: Boxes) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Widths and heights of (n, 4, 2) boxes, (n,) pixels each: the mean of two opposite sides."""
    sides = np.linalg.norm(np.roll(boxes, -1, axis=1) - boxes, axis=2)
    return (sides[:, 0] + sides[:, 2]) / 2.0, (sides[:, 1] + sides[:, 3]) / 2.0
