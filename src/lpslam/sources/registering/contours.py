"""Contours of things in a depth image, and where a colour image changes: what shows whether the two lie together."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.config import RegistrationCheckConfig

Array = NDArray[np.float64]
Picture = NDArray[np.float32]


@dataclass(frozen=True, slots=True, eq=False)
class Contours:
    """The last pixels of things before what is farther, where their depth ends.

    Attributes:
        pixels: (n, 2) u, v, half a pixel beyond the last one.
        depths: (n,) metres, of the thing.
        axis: (n,) 0 where it ends to the left or right, 1 up or down.
    """

    pixels: Array
    depths: Array
    axis: NDArray[np.intp]


def contours_of(depth: Picture, config: RegistrationCheckConfig) -> Contours:
    """Look for contours to all four sides of every pixel of depth (h, w), metres.

    What a thing hides from a projector or the second eye has no depth: the next reading within a reach is asked.
    """
    every = max(1, round(depth.shape[1] / config.depth_width))
    depth = depth[::every, ::every]
    found = [_ends(turned, config) for turned in _four_ways(depth)]
    height, width = depth.shape
    (r0, c0, z0), (r1, c1, z1), (r2, c2, z2), (r3, c3, z3) = found
    rows = np.concatenate([r0, r1, c2 + 0.5, height - 1 - c3 - 0.5])
    columns = np.concatenate([c0 + 0.5, width - 1 - c1 - 0.5, r2, r3])
    axis = np.repeat([0, 1], [len(r0) + len(r1), len(r2) + len(r3)])
    depths = np.concatenate([z0, z1, z2, z3]).astype(np.float64)
    kept = np.unique(np.linspace(0, len(depths) - 1, config.contour_pixels).astype(int)) if len(depths) else slice(0)
    return Contours(np.column_stack([columns, rows])[kept] * every, depths[kept], axis[kept])


def _four_ways(depth: Picture) -> tuple[Picture, Picture, Picture, Picture]:
    """Turned so that right, left, down and up are along a row."""
    upright = np.ascontiguousarray(depth.T)
    return depth, depth[:, ::-1], upright, upright[:, ::-1]


def _ends(depth: Picture, config: RegistrationCheckConfig) -> tuple[Array, Array, Picture]:
    """Rows, columns and depths after which, along a row, something much farther comes."""
    height, width = depth.shape
    columns = np.arange(width)
    with np.errstate(invalid="ignore"):
        is_read = np.isfinite(depth) & (depth > config.nearest)
    beyond = np.full((height, width + 1), width, dtype=np.intp)
    beyond[:, :width] = np.where(is_read, columns, width)
    after = np.minimum.accumulate(beyond[:, ::-1], axis=1)[:, ::-1][:, 1:]
    row, column = np.nonzero(is_read & (after < width) & (after - columns <= config.shadow * width))
    steady = column >= config.steady_pixels
    row, column = row[steady], column[steady]
    near, far = depth[row, column], depth[row, after[row, column]]
    is_end = far > near + np.maximum(config.step, config.step_share * near)
    for back in range(1, config.steady_pixels + 1):
        before = depth[row, column - back]
        is_end &= np.abs(before - near) < config.steady_share * near
    return row[is_end].astype(np.float64), column[is_end].astype(np.float64), near[is_end]


def changes_of(rgb: NDArray[np.uint8], side: int) -> tuple[Picture, Picture]:
    """How much a picture changes to the side and downwards, beside how much it does all around; 0 to 1.

    Args:
        rgb: (h, w, 3).
        side: pixels to which its longer side is reduced.
    """
    gray = cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY)
    height, width = (max(1, round(side * length / max(gray.shape))) for length in gray.shape)
    small = cv2.resize(gray, (width, height), interpolation=cv2.INTER_AREA).astype(np.float32)
    smooth = cv2.GaussianBlur(small, (0, 0), 0.7)
    return _beside_around(cv2.Sobel(smooth, cv2.CV_32F, 1, 0)), _beside_around(cv2.Sobel(smooth, cv2.CV_32F, 0, 1))


def _beside_around(slope: NDArray[np.generic]) -> Picture:
    strength = np.abs(np.asarray(slope, np.float32))
    side = max(3, strength.shape[1] // 10)
    # One grey value a pixel, eight times that in Sobel's sum: flat walls have noise, and no changes.
    share = strength / (cv2.blur(strength, (side, side)) + 8.0)
    return np.asarray(share / (1.0 + share), np.float32)
