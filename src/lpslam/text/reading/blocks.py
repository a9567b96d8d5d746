"""Boxes that hold several columns or several lines of text, taken apart where their ground shows through."""

from collections.abc import Sequence
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.config import SpottingConfig
from lpslam.language.tables.spelling import is_ideograph
from lpslam.text.reading.boxes import DOWNWARDS, Boxes, letter_heights, may_run_either_way, runs_downwards
from lpslam.text.reading.spotting import SURE, TextSpotter, accepted_texts
from lpslam.text.types import SpottedText

# Pixels of a block's shorter side as it is looked at, and of its longer one at most.
_SIDE, _LONGEST = 96, 384
# Longest side of a block, in shorter ones: what is longer is a line.
_LONGEST_BLOCK = 3.0
# Share of a strip that is ink from which it is no letter but the world beyond the board's edge, ...
_BEYOND = 0.9
# ... and share of the usual ink of a strip below which the ground shows through between two bands.
_THROUGH = 0.15
# Most bands of a block, and how many times as thick as the thinnest the thickest may be: bands are set alike.
_MOST_BANDS, _ALIKE = 6, 1.6
# Pitches of characters by which a line of a stack may stand out of it.
_SHIFTED = 0.5
# Ground kept around a band, as a share of its thickness.
_ROUND = 0.1


def parts_of(rgb: NDArray[np.uint8], box: NDArray[np.float64]) -> list[Boxes]:
    """Ways to take a box apart: into columns, from the right, and into lines, from the top.

    Args:
        rgb: (h, w, 3).
        box: (4, 2) pixels.

    Returns:
        (k, 4, 2) boxes of two bands or more; those first that lie farther apart, as lines do against their letters.
    """
    top, right, bottom, left = np.linalg.norm(np.roll(box, -1, axis=0) - box, axis=1)
    width, height = max(top, bottom, 1.0), max(left, right, 1.0)
    if max(width, height) > _LONGEST_BLOCK * min(width, height):
        return []
    scale = _SIDE / min(width, height)
    size = (min(round(width * scale), _LONGEST), min(round(height * scale), _LONGEST))
    corners = np.array([[0, 0], [size[0], 0], [size[0], size[1]], [0, size[1]]], np.float32)
    flat_from_image = cv2.getPerspectiveTransform(box.astype(np.float32), corners)
    flat = cv2.warpPerspective(rgb, flat_from_image, size, flags=cv2.INTER_AREA, borderMode=cv2.BORDER_REPLICATE)
    ink = _ink(np.asarray(flat, np.uint8))
    image_from_flat = np.linalg.inv(flat_from_image)
    ways: list[tuple[int, Boxes]] = []
    for upright in (ink, ink.T):
        bands = _bands(upright)
        if bands is None:
            continue
        rectangles = np.array([_rectangle(upright, start, end) for start, end in bands], np.float64)
        # Columns are read from the right.
        rectangles = rectangles[::-1] if upright is ink else rectangles[:, [1, 0, 3, 2]]
        points = rectangles[:, [[0, 1], [2, 1], [2, 3], [0, 3]]].reshape(-1, 1, 2)
        boxes = np.asarray(cv2.perspectiveTransform(points, image_from_flat), np.float64).reshape(-1, 4, 2)
        apart = min(start - end for (_, end), (start, _) in pairwise(bands))
        ways.append((apart, boxes))
    return [boxes for _, boxes in sorted(ways, key=lambda way: -way[0])]


def read_in_parts(
    rgb: NDArray[np.uint8],
    box: NDArray[np.float64],
    whole: SpottedText | None,
    spotter: TextSpotter,
    config: SpottingConfig,
) -> list[SpottedText]:
    """Read a box that as one line says nothing, or says it unsurely, column by column and line by line.

    Args:
        rgb: (h, w, 3).
        box: (4, 2) pixels.
        whole: what was read in it as one line.
        spotter, config: read the parts.

    Returns:
        What the parts of the first way say that is surer in each of its parts than the whole; none without.
    """
    least = 0.0 if whole is None else whole.confidence
    if least >= SURE:
        return []
    for boxes in parts_of(rgb, box):
        if letter_heights(boxes).min() < config.min_letter_height:
            continue
        read = accepted_texts(boxes, spotter.recognise(rgb, boxes), config)
        texts = [each for each in read if each is not None]
        surest = min((each.confidence for each in texts), default=0.0)
        if len(texts) == len(boxes) and surest > least and _may_stand_so(texts, boxes):
            return texts
    return []


def stacks_of(texts: Sequence[SpottedText]) -> list[list[int]]:
    """Lines that stand over each other more closely than their characters stand beside each other, from the top.

    What is nearest belongs together: they are columns, which were found as lines across.
    """
    rows = [row for row, each in enumerate(texts) if _is_line_of_ideographs(each)]
    rows.sort(key=lambda row: float(texts[row].box[:, 1].mean()))
    stacks: list[list[int]] = []
    for row in rows:
        above = next((stack for stack in stacks if _is_close_below(texts[stack[-1]], texts[row])), None)
        if above is None:
            stacks.append([row])
        else:
            above.append(row)
    return [stack for stack in stacks if len(stack) > 1]


def around(texts: Sequence[SpottedText]) -> NDArray[np.float64]:
    """The (4, 2) box of lines over each other, from the top."""
    first, last = texts[0].box, texts[-1].box
    return np.stack([first[0], first[1], last[2], last[3]])


def may_run_down(text: SpottedText) -> bool:
    """Whether a text in a box as wide as high may be a piece of a column: only ideographs stand over each other."""
    letters = [ch for ch in text.text if ch.isalnum()]
    return bool(may_run_either_way(text.box[None])[0]) and all(map(is_ideograph, letters))


def _is_line_of_ideographs(text: SpottedText) -> bool:
    letters = [ch for ch in text.text if not ch.isspace()]
    across = not runs_downwards(text.box[None])[0]
    return bool(across and len(letters) > 1 and all(map(is_ideograph, letters)))


def _is_close_below(above: SpottedText, below: SpottedText) -> bool:
    """Whether a line of as many characters stands under another one, nearer than its characters are to each other."""
    letters = [sum(not ch.isspace() for ch in each.text) for each in (above, below)]
    step = below.box.mean(axis=0) - above.box.mean(axis=0)
    along = above.box[1] - above.box[0]
    pitch = float(np.linalg.norm(along)) / letters[0]
    away = abs(float(step @ along)) / max(float(np.linalg.norm(along)), 1e-9)
    return letters[0] == letters[1] and 0.0 < step[1] < pitch and away < _SHIFTED * pitch


def _may_stand_so(texts: Sequence[SpottedText], boxes: Boxes) -> bool:
    """Whether texts may be written so: only ideographs stand over each other in columns."""
    across = np.ptp(boxes.mean(axis=1), axis=0)
    is_beside = across[0] > across[1]
    return bool(not is_beside or all(is_ideograph(ch) for each in texts for ch in each.text if ch.isalnum()))


def _ink(flat: NDArray[np.uint8]) -> NDArray[np.bool_]:
    """Where a block is not of its ground's colour, by Otsu's threshold, without what lies beyond the board's edge."""
    ground = np.median(flat.reshape(-1, 3), axis=0)
    away = np.abs(flat.astype(np.float32) - ground).max(axis=2)
    away = np.clip(away, 0, 255).astype(np.uint8)
    _, ink = cv2.threshold(away, 0, 1, cv2.THRESH_BINARY | cv2.THRESH_OTSU)
    inked = np.asarray(ink, bool)
    for axis in (0, 1):
        full = inked.mean(axis=axis) > _BEYOND
        inside = np.flatnonzero(~full)
        if not len(inside):
            return np.zeros_like(inked)
        keep = np.zeros_like(full)
        keep[inside[0] : inside[-1] + 1] = True
        inked &= keep[None, :] if axis == 0 else keep[:, None]
    return inked


def _bands(ink: NDArray[np.bool_]) -> list[tuple[int, int]] | None:
    """The bands [start, end) of columns of an (h, w) block between which its ground shows through; None for one."""
    profile = ink.mean(axis=0)
    usual = float(np.percentile(profile, 80.0))
    is_band = profile > _THROUGH * usual
    steps = np.flatnonzero(np.diff(np.concatenate([[False], is_band, [False]]).astype(np.int8)))
    bands = [(int(start), int(end)) for start, end in steps.reshape(-1, 2)]
    if not 2 <= len(bands) <= _MOST_BANDS:
        return None
    thick = [end - start for start, end in bands]
    rows = np.flatnonzero(ink.any(axis=1))
    is_alike = max(thick) <= _ALIKE * min(thick)
    is_long = rows[-1] + 1 - rows[0] >= DOWNWARDS * max(thick)
    return bands if is_alike and is_long else None


def _rectangle(ink: NDArray[np.bool_], start: int, end: int) -> tuple[float, float, float, float]:
    """Left, top, right and bottom of a band's ink, with some ground around it."""
    rows = np.flatnonzero(ink[:, start:end].any(axis=1))
    margin = _ROUND * (end - start)
    low, high = max(rows[0] - margin, 0.0), min(rows[-1] + 1 + margin, float(ink.shape[0]))
    return max(start - margin, 0.0), low, min(end + margin, float(ink.shape[1])), high
