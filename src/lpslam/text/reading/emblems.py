"""Round logos beside a name, which a recogniser reads as a letter: “OGAO” for a disc and GAO.

No round letter has a hole with corners; none is filled, or unlike its hole, and taller than the letters beside it.
"""

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

RINGS = frozenset("O0")
"""Characters as which a round logo is read."""

_SHORTEST = 3  # letters that must be left of a name
_LETTER = 0.35  # of a line's height: smaller pieces are dots, accents and dirt
_TALLER = 1.08  # times the letters beside it; a round letter overshoots by about 0.03
_ROUND = (0.75, 1.3)  # width by height of a logo seen aslant
_NO_HOLE, _HOLE = 0.03, 0.12  # of its box: less is no hole, and one that is smaller than the second has no sure shape
_DISC = (0.7, 0.87)  # of its box that a disc fills; a square or a character of many strokes does not
_ROUND_OUTLINE, _CORNERED = 0.96, 0.91  # roundness of a disc at least, and of a triangle in it at most
_UNLIKE = 0.13  # by how much the fullness of a letter's outline and of its hole may differ

Mask = NDArray[np.uint8]


def without_emblems(line: NDArray[np.uint8], text: str) -> str:
    """Drop a first or last letter that was no letter.

    Args:
        line: (h, w, 3) upright line of text, as it was read.
        text: what was read.
    """
    first, last = text[:1] in RINGS, text[-1:] in RINGS
    if not (first or last) or len(text) <= _SHORTEST:
        return text
    ink = _ink(line)
    _, _, boxes, _ = cv2.connectedComponentsWithStats(ink)
    # The first component is the ground; what reaches the ends of the line is what the board hangs on.
    left, width = boxes[:, cv2.CC_STAT_LEFT], boxes[:, cv2.CC_STAT_WIDTH]
    is_piece = (boxes[:, cv2.CC_STAT_HEIGHT] >= _LETTER * len(line)) & (left > 0) & (left + width < line.shape[1])
    is_piece[0] = False
    boxes = boxes[is_piece]
    boxes = boxes[np.argsort(boxes[:, cv2.CC_STAT_LEFT])]
    if len(boxes) <= 2:
        return text
    # A capital is taller than the small letters after it, and no taller than those with ascenders.
    is_capital = text[1:2].islower() and not _is_taller(boxes[0], boxes[1:], 100.0)
    if first and not is_capital and _is_emblem(ink, boxes[0], boxes[1:]):
        return text[1:].lstrip()
    if last and _is_emblem(ink, boxes[-1], boxes[:-1]):
        return text[:-1].rstrip()
    return text


def _ink(line: NDArray[np.uint8]) -> Mask:
    """What is painted, 1, on the ground, 0: the ground is what most of the rim shows."""
    grey = cv2.cvtColor(line, cv2.COLOR_RGB2GRAY)
    _, bright = cv2.threshold(grey, 0, 1, cv2.THRESH_BINARY + cv2.THRESH_OTSU)
    rim = np.concatenate([bright[0], bright[-1], bright[:, 0], bright[:, -1]])
    return np.asarray(1 - bright if rim.mean() > 0.5 else bright, dtype=np.uint8)


def _is_taller(box: NDArray[Any], letters: NDArray[Any], percentile: float) -> bool:
    """Whether a piece of ink is taller than so many percent of the letters beside it."""
    usual = float(np.percentile(letters[:, cv2.CC_STAT_HEIGHT], percentile))
    return bool(box[cv2.CC_STAT_HEIGHT] >= _TALLER * usual)


def _is_emblem(ink: Mask, box: NDArray[Any], letters: NDArray[Any]) -> bool:
    left, top, width, height = box[:4].tolist()
    piece = np.pad(ink[top : top + height, left : left + width], 1)
    outlines, tree = cv2.findContours(piece, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
    outer = max(outlines, key=cv2.contourArea)
    holes = [each for each, (_, _, _, parent) in zip(outlines, tree[0], strict=True) if parent >= 0]
    hole = max(holes, key=cv2.contourArea, default=None)
    share = 0.0 if hole is None else cv2.contourArea(hole) / (width * height)
    if hole is not None and share >= _HOLE and _roundness(outer) >= _ROUND_OUTLINE and _roundness(hole) <= _CORNERED:
        return True
    is_tall = _is_taller(box, letters, 50.0)
    if not is_tall or not _ROUND[0] <= width / height <= _ROUND[1]:
        return False
    if hole is None or share < _NO_HOLE:
        return _DISC[0] <= _fullness(outer) <= _DISC[1]
    return share >= _HOLE and abs(_fullness(outer) - _fullness(hole)) > _UNLIKE


def _roundness(outline: NDArray[Any]) -> float:
    """Area by that of the ellipse of equal spread: 1 of an ellipse, 0.95 of a rectangle, 0.83 of a triangle, however
    they are seen.
    """
    moments = cv2.moments(outline)
    spread = moments["mu20"] * moments["mu02"] - moments["mu11"] ** 2
    return float(moments["m00"] ** 2 / (4.0 * np.pi * np.sqrt(spread))) if spread > 0.0 else 0.0


def _fullness(outline: NDArray[Any]) -> float:
    """The share of its box that an outline encloses: 1 of a rectangle, 0.785 of an ellipse, 0.5 of a triangle."""
    _, _, across, down = cv2.boundingRect(outline)
    return float(cv2.contourArea(outline)) / max((across - 1) * (down - 1), 1)
