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
    depth = np.ascontiguousarray(depth[::every, ::every])
    rows, columns, near, side = _ends_along_rows(depth, config)
    turned_rows, turned_columns, turned_near, turned_side = _ends_along_rows(np.ascontiguousarray(depth.T), config)
    pixels = np.column_stack(
        [
            np.concatenate([columns + 0.5 * side, turned_rows]),
            np.concatenate([rows, turned_columns + 0.5 * turned_side]),
        ]
    )
    depths = np.concatenate([near, turned_near]).astype(np.float64)
    axis = np.repeat([0, 1], [len(near), len(turned_near)])
    kept = np.unique(np.linspace(0, len(depths) - 1, config.contour_pixels).astype(int)) if len(depths) else slice(0)
    return Contours(pixels[kept] * every, depths[kept], axis[kept])


def _ends_along_rows(
    depth: Picture, config: RegistrationCheckConfig
) -> tuple[NDArray[np.intp], NDArray[np.intp], Picture, NDArray[np.intp]]:
    """Rows, columns and depths beside which something much farther comes; to the right (1) or to the left (-1).

    Of readings that follow each other in a row the nearer one ends, if those on its other side read alike.
    """
    width = depth.shape[1]
    flat = depth.ravel()
    with np.errstate(invalid="ignore"):
        at = np.flatnonzero(np.isfinite(flat) & (flat > config.nearest))
    z = flat[at]
    pair = np.flatnonzero(np.abs(np.diff(z)) > config.step)
    is_first_near = z[pair] < z[pair + 1]
    near, far = at[pair + ~is_first_near], at[pair + is_first_near]
    side = np.where(is_first_near, 1, -1)
    is_end = (near // width == far // width) & (np.abs(far - near) <= config.shadow * width)
    is_end &= flat[far] - flat[near] > config.step_share * flat[near]
    behind = near % width - config.steady_pixels * side
    is_end &= (behind >= 0) & (behind < width)
    near, side = near[is_end], side[is_end]
    back = near - side * np.arange(1, config.steady_pixels + 1)[:, None]
    is_steady = (np.abs(flat[back] - flat[near]) < config.steady_share * flat[near]).all(axis=0)
    near, side = near[is_steady], side[is_steady]
    return near // width, near % width, flat[near], side


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
