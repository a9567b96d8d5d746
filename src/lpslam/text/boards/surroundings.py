"""What is around a text: the colours of its ground and of its letters, and how far its ground goes on to each side."""

from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.text.reading.boxes import widths_and_heights

Array = NDArray[np.float64]
Colour = tuple[int, int, int]
Clear = tuple[float, float, float, float]

REACH = 2.5
"""How far beyond a box its ground is followed, as a share of the box's shorter side."""

# How far beyond a box's long sides the colour of its ground is looked at too, as a share of its height.
_BEYOND = 0.1
# Samples across and along a box, and along and outwards of the stripe beside it.
_ACROSS, _ALONG, _BESIDE, _OUTWARDS = 20, 48, 24, 50
# The first samples outwards that are not looked at: letters stick out of their box.
_SKIPPED = 0.1
# Difference of a channel, 0 to 255 and as a share of the ground's brightest one, that ends a ground: noise and
# shade are less, and letters, frames and walls are more.
_STEP, _STEP_SHARE = 22.0, 0.16
# Of the ground in the rows of letters, the share least like them: blurred, thick letters lighten or darken the rest.
_BARE = 0.2
# A ground goes on as far as it does for this share of its side: letters leave gaps, frames leave none.
_OPEN = 0.9


class Surroundings(NamedTuple):
    """The ground that a text is written on.

    Attributes:
        ground, ink: (red, green, blue), 0 to 255.
        bare: of the ground in the rows of letters, where it is least like them.
        clear: how far the ground goes on above, right of, below and left of the box, as shares of the box's shorter
            side on the surface it is written on, at most `REACH`.
    """

    ground: Colour
    ink: Colour
    bare: Colour
    clear: Clear


def surroundings(rgb: NDArray[np.uint8], box: Array, size: tuple[float, float] | None = None) -> Surroundings:
    """Look at the ground in and around the (4, 2) box of an RGB image; its width and height in metres, where known.

    Of the bright and the dark part of the box the larger is ground: letters cover less of a line than what they are
    written on.
    """
    colours = _sampled(rgb, box, np.linspace(-_BEYOND, 1.0 + _BEYOND, _ACROSS), np.linspace(0.0, 1.0, _ALONG))
    bright = colours.astype(np.float32).mean(axis=2).astype(np.uint8)
    _, is_bright = cv2.threshold(bright, 0, 1, cv2.THRESH_BINARY | cv2.THRESH_OTSU)
    larger = np.asarray(is_bright == (2 * int(is_bright.sum()) >= bright.size))
    ground = np.median(colours[larger], axis=0)
    ink = np.median(colours[~larger], axis=0) if not larger.all() else ground
    width, height = size or (float(side[0]) for side in widths_and_heights(box[None]))
    sides = []
    for corner, length in enumerate((height, width, height, width)):
        turned = np.roll(box, -corner, axis=0)
        sides.append(_goes_on(rgb, turned, min(width, height) / max(length, 1e-6), ground))
    bare = _colour(_bare(colours, larger, ink))
    return Surroundings(_colour(ground), _colour(ink), bare, (sides[0], sides[1], sides[2], sides[3]))


def _bare(colours: NDArray[np.uint8], is_ground: NDArray[np.bool_], ink: Array) -> Array:
    """The ground in the rows that have half as much ink as any at least, where it is least like the ink."""
    inked = (~is_ground).mean(axis=1)
    rows = inked >= inked.max() / 2.0
    between = colours[rows][is_ground[rows]].astype(np.float64)
    unlike = np.abs(between - ink).sum(axis=1)
    bare = between[unlike >= np.quantile(unlike, 1.0 - _BARE)] if len(between) else colours[is_ground]
    return np.asarray(np.median(bare, axis=0), np.float64)


def _goes_on(rgb: NDArray[np.uint8], box: Array, unit: float, ground: Array) -> float:
    """How far the ground goes on beyond the box's first side, in units of so large a share of the box that way."""
    outwards = np.linspace(_SKIPPED, REACH, _OUTWARDS)
    stripe = _sampled(rgb, box, -outwards * unit, np.linspace(-0.05, 1.05, _BESIDE)).astype(np.float32)
    limit = max(_STEP, _STEP_SHARE * float(ground.max()))
    blurred = cv2.blur(stripe, (1, 3))
    differs = (np.abs(blurred - ground.astype(np.float32)) > limit).any(axis=2)
    ends = np.where(differs.any(axis=0), differs.argmax(axis=0), _OUTWARDS - 1)
    farthest = int(np.sort(ends)[round(_OPEN * (_BESIDE - 1))])
    return round(float(outwards[farthest]), 2)


def _sampled(rgb: NDArray[np.uint8], box: Array, across: Array, along: Array) -> NDArray[np.uint8]:
    """Pixels at shares of a box's sides, (across, along, 3); beyond the image its rim."""
    down, right = across[:, None, None], along[None, :, None]
    top, bottom = box[0] + right * (box[1] - box[0]), box[3] + right * (box[2] - box[3])
    height, width = rgb.shape[:2]
    pixels = np.clip(np.rint(top + down * (bottom - top)), 0, [width - 1, height - 1]).astype(int)
    return np.asarray(rgb[pixels[..., 1], pixels[..., 0]], np.uint8)


def _colour(values: Array) -> Colour:
    red, green, blue = values
    return int(red), int(green), int(blue)
