"""Placing labels beside their points so that none covers another."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_ANGLES = np.deg2rad([0, 180, 45, 135, 315, 225, 90, 270, 22.5, 157.5, 337.5, 202.5, 67.5, 112.5, 292.5, 247.5])
_RINGS = 24
_HARD = 100.0  # how much worse it is to cover a label or a labelled point than any other


def place_labels(
    anchors: Array, sizes: Array, bounds: tuple[float, float], gap: float = 6.0, obstacles: Array | None = None
) -> Array:
    """Find a place for each label, in order: the nearest one that is free.

    Args:
        anchors: (n, 2) pixels, the labelled points.
        sizes: (n, 2) pixels, width and height of the labels.
        bounds: width and height of the picture in pixels.
        gap: pixels between a label and what is beside it.
        obstacles: (m, 2) pixels, further points that labels should rather not cover.

    Returns:
        (n, 2) pixels, the labels' centres. Where no free place is left, the least covered one.
    """
    centres = np.empty_like(anchors, dtype=np.float64)
    soft = np.zeros((0, 2)) if obstacles is None else obstacles
    point = np.full(2, gap / 2)
    # Farther away is worse, but less so than covering another label.
    cost_of_distance = np.repeat(np.arange(_RINGS), len(_ANGLES)) * gap**2
    for i, (anchor, size) in enumerate(zip(anchors, sizes, strict=True)):
        candidates = _candidates(anchor, size, gap)
        half = size / 2 + gap / 4
        covered = _overlap(candidates, half, centres[:i], sizes[:i] / 2 + gap / 4).sum(axis=1)
        covered += _overlap(candidates, half, anchors, point[None]).sum(axis=1)
        outside = np.maximum(half - candidates, 0) + np.maximum(candidates + half - np.array(bounds), 0)
        covered += outside.sum(axis=1) * size.max()
        crossed = _overlap(candidates, half, soft, point[None]).sum(axis=1)
        centres[i] = candidates[int(np.argmin(_HARD * covered + crossed + cost_of_distance))]
    return centres


def _candidates(anchor: Array, size: Array, gap: float) -> Array:
    """Centres around a point, nearest ring first, the right and the left side before the others."""
    directions = np.column_stack([np.cos(_ANGLES), np.sin(_ANGLES)])
    # The label's edge, not its centre, keeps the distance: wide labels go further sideways than up.
    rings = [directions * (size / 2 + gap + ring * size[1] * 0.6) for ring in range(_RINGS)]
    candidates: Array = anchor + np.concatenate(rings)
    return candidates


def _overlap(centres: Array, half: Array, others: Array, other_halves: Array) -> Array:
    """Area shared by boxes about (n, 2) centres with boxes about (m, 2) others; (n, m)."""
    distance = np.abs(centres[:, None] - others[None])
    shared = np.minimum(half + other_halves[None] - distance, 2 * np.minimum(half, other_halves[None]))
    area: Array = np.clip(shared, 0, None).prod(axis=2)
    return area
