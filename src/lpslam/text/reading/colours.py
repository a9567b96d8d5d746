"""Texts that differ from their ground in colour and hardly in brightness: gold on red, green on brown."""

from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.config import SpottingConfig
from lpslam.text.reading.spotting import SURE, TextSpotter, accepted_texts
from lpslam.text.types import SpottedText

# Weights of red, green and blue in brightness (ITU-R BT.601): a grey ink has 0.58 of its distance in brightness.
_BRIGHTNESS = np.array([0.299, 0.587, 0.114])
# Share of the distance between ink and ground below which it is one of colour.
_COLOURED = 0.3
# Least distance of ink and ground, grey values: below, it is noise.
_LEAST_DISTANCE = 15.0
# Share of a box, about its middle, whose colours are its own: boxes are wider than boards now and then.
_INNER = 0.7
# Pixels, standard deviation: codecs keep colour at half the resolution, so noise is taken off it, and no letters.
_SMOOTH = 1.0
# Grey values of ground and ink as they are drawn, and pixels around a box that are drawn with it.
_GROUND, _INK, _AROUND = 64.0, 192.0, 16


def _ink_and_ground(
    rgb: NDArray[np.uint8], box: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The (3,) colours of letters and of what is around them, within the (4, 2) box; not of what is beyond a board."""
    middle = box.mean(axis=0)
    inner = np.rint(middle + _INNER * (box - middle)).astype(np.int32)
    mask = cv2.fillConvexPoly(np.zeros(rgb.shape[:2], np.uint8), inner, 1)
    pixels = rgb[np.asarray(mask, bool)].astype(np.float64)
    ground = np.median(pixels, axis=0)
    away = np.linalg.norm(pixels - ground, axis=1)
    levels = np.clip(away, 0, 255).astype(np.uint8)[:, None]
    threshold, _ = cv2.threshold(levels, 0, 1, cv2.THRESH_BINARY | cv2.THRESH_OTSU)
    is_ink = away > threshold
    return (np.median(pixels[is_ink], axis=0) if is_ink.any() else ground), ground


def read_in_colours(
    rgb: NDArray[np.uint8],
    box: NDArray[np.float64],
    plain: SpottedText | None,
    spotter: TextSpotter,
    config: SpottingConfig,
) -> SpottedText | None:
    """Look for a text once more in what is around a box, where its ink differs from its ground in colour alone.

    Args:
        rgb: (h, w, 3).
        box: (4, 2) pixels.
        plain: what was read in it, if anything.
        spotter, config: find and read.

    Returns:
        The surest of what is read so, if it is surer than `plain`; else `plain`.
    """
    drawn = None if plain is not None and plain.confidence >= SURE else in_their_colours(rgb, box)
    if drawn is None:
        return plain
    grey, corner = drawn
    found, _ = spotter.detect(grey)
    boxes = np.concatenate([(box - corner)[None], found])
    texts = accepted_texts(boxes, spotter.recognise(grey, boxes), config)
    surest = max((each for each in texts if each is not None), key=lambda each: each.confidence, default=None)
    if surest is None or (plain is not None and plain.confidence >= surest.confidence):
        return plain
    return replace(surest, box=surest.box + corner)


def in_their_colours(
    rgb: NDArray[np.uint8], box: NDArray[np.float64]
) -> tuple[NDArray[np.uint8], NDArray[np.int64]] | None:
    """What is around a box, drawn in grey by how much it has of the ink's colour.

    Args:
        rgb: (h, w, 3).
        box: (4, 2) pixels.

    Returns:
        (h', w', 3) picture and the (2,) pixel of its upper left corner; None where ink and ground differ in brightness.
    """
    low = np.maximum(np.floor(box.min(axis=0)).astype(int) - _AROUND, 0)
    high = np.ceil(box.max(axis=0)).astype(int) + _AROUND + 1
    part = rgb[low[1] : high[1], low[0] : high[0]]
    if not part.size:
        return None
    part = np.asarray(cv2.GaussianBlur(part, (0, 0), _SMOOTH), np.uint8)
    ink, ground = _ink_and_ground(part, box - low)
    axis = ink - ground
    distance = float(np.linalg.norm(axis))
    if distance < _LEAST_DISTANCE or abs(axis @ _BRIGHTNESS) > _COLOURED * distance:
        return None
    share = (part.astype(np.float64) - ground) @ axis / distance**2
    grey = np.clip(_GROUND + share * (_INK - _GROUND), 0, 255).astype(np.uint8)
    return np.repeat(grey[..., None], 3, axis=2), low
