"""Which texts the image's border cuts off (Fig. 11): they mislead, and wait until the rest is in view.

The paper drops what touches the image's rim. A whole word may stand there too: what matters is whether it goes on
outside. It does not where a letter's space beyond both of its ends is in the image, or as much of it as is in the image
is plain ground, and none of its strokes runs into the border.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.text.reading.boxes import Boxes, along_the_lines, letter_heights

Image = NDArray[np.uint8]
Mask = NDArray[np.bool_]
Pixel = NDArray[np.float64]

_SPACE = 0.5
"""Box heights beyond an end in which a next letter would begin: wider than the space between two words."""

_LEAST_SPACE = 0.2
"""Box heights of it that must be seen: with the box's own margin it is wider than the gap between two letters."""

_MARGIN = 0.15
"""Box heights by which a detected box is grown beyond its letters; so much above and below must be in the image."""

_WORD = 2.5
"""Box heights beyond an end in which the rest of a word that the border cuts off is looked for: the detector finds none
of it, while what is left of it are pieces of letters."""

_WORD_GAP = 1.0
"""Largest gap, box heights, before that word: more parts two texts."""

_TO_THE_BORDER = 0.35
"""Box heights before the border at which its ink must end at last: a word that ends before is whole."""

_AS_HIGH = 0.65
"""Of the letters' height, that of the next word's: small letters beside tall ones are lower."""

_STROKES = 0.1, 0.7
"""Share of its pixels that are ink, where it is letters."""

_SAME_LEVEL = 0.25
"""Share of the contrast between letters and ground by which those of the next word may differ."""

_BAR = 0.9
"""Share of a column from which it is no letter's stroke but the end of the ground: a frame, or what is behind it."""

_PIXELS = 24
"""Height of the box, pixels, at which strokes are looked for."""

_PLAIN = 0.04
"""Largest share of the pixels beyond an end that may be ink: a single stroke of a letter covers more."""


def cut_by_border(rgb: Image, boxes: Boxes) -> Mask:
    """Tell which (n, 4, 2) boxes hold text that goes on beyond the border of an (h, w, 3) image: (n,)."""
    cut = np.zeros(len(boxes), np.bool_)
    if not len(boxes):
        return cut
    lines = along_the_lines(boxes)
    heights = letter_heights(boxes)[:, None]
    first, last = view_of(rgb)
    for row in _reaching_out(_grown(lines, heights, _SPACE, _MARGIN), first, last):
        cut[row] = _goes_on(rgb, lines[row], first, last)
    for row in _reaching_out(_grown(lines, heights, _WORD, 0.0), first, last):
        cut[row] = cut[row] or _goes_on_after_a_gap(rgb, lines[row], first, last)
    return cut


def _reaching_out(boxes: Boxes, first: Pixel, last: Pixel) -> list[int]:
    """Which (n, 4, 2) boxes are not wholly in the image."""
    return np.flatnonzero(~((boxes >= first) & (boxes <= last)).all(axis=(1, 2))).tolist()


def view_of(rgb: Image) -> tuple[Pixel, Pixel]:
    """First and last (x, y) of an (h, w, 3) image within the blank frame that rectifying or registering left around it.

    Where there is a frame it is black or white on all four sides, and the line next to it is a mixture.
    """
    green = rgb[:, :, 1]
    sides = np.array([_blank_lines(each) for each in (green.T, green, green.T[::-1], green[::-1])])
    # A frame is about even: what is blank farther in is the scene itself.
    sides = np.minimum(sides, sides.min() + _UNEVEN) + 1 if sides.all() else np.zeros(4, np.intp)
    last = np.array([green.shape[1] - 1, green.shape[0] - 1])
    return sides[:2].astype(np.float64), (last - sides[2:]).astype(np.float64)


def _blank_lines(image: Image) -> int:
    """How many lines at the top of a grey image (h, w) are white, or black, throughout."""
    most = int(_WIDEST_FRAME * image.shape[0])
    for depth in range(most):
        # Compression leaves traces of the image near the ends of a line.
        low, high = np.percentile(image[depth], (2, 98))
        if high > _BLACK and low < _WHITE:
            return depth
    return most


_WIDEST_FRAME = 0.05
"""Of a side's length: more than any lens model leaves blank."""

_UNEVEN = 4
"""Pixels by which one side of the frame may be wider than another."""

_BLACK, _WHITE = 10, 245
"""Levels of 255 that a blank line stays within, compressed as it is."""


def _grown(lines: Boxes, heights: NDArray[np.float64], ends: float, sides: float) -> Boxes:
    """Lines (n, 4, 2) with so many heights (n, 1) added beyond their ends and beyond their sides."""
    along = lines[:, 1] + lines[:, 2] - lines[:, 0] - lines[:, 3]
    across = lines[:, 2] + lines[:, 3] - lines[:, 0] - lines[:, 1]
    along = along / np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-9) * heights * ends
    across = across / np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-9) * heights * sides
    steps = np.stack([-along - across, along - across, along + across, across - along], axis=1)
    return np.asarray(lines + steps, dtype=np.float64)


def _goes_on(rgb: Image, line: Boxes, first: Pixel, last: Pixel) -> bool:
    """Whether the text of a line (4, 2) near the border goes on beyond it."""
    strip, visible = _surroundings(rgb, line, first, last)
    space, margin = round(_SPACE * _PIXELS), round(_MARGIN * _PIXELS)
    ink = _ink(strip, visible, slice(margin, -margin), slice(space, -space)) & visible
    rows = slice(margin, -margin)
    ends = (ink[rows, :space][:, ::-1], visible[rows, :space][:, ::-1]), (ink[rows, -space:], visible[rows, -space:])
    if any(_may_go_on(*end) for end in ends):
        return True
    # A box is grown beyond its letters: one whose sides are in view lacks an ascender's tip at most.
    sides = np.array([line[0] + line[1], line[2] + line[3]]) / 2.0
    return not ((sides > first) & (sides < last)).all() and _runs_out(ink, visible, margin, space)


def _goes_on_after_a_gap(rgb: Image, line: Boxes, first: Pixel, last: Pixel) -> bool:
    """Whether the next word of a line (4, 2), on the same ground, is cut off by the border."""
    strip, visible = _surroundings(rgb, line, first, last, _WORD)
    space, margin = round(_WORD * _PIXELS), round(_MARGIN * _PIXELS)
    rows = slice(margin, -margin)
    ink = _ink(strip, visible, rows, slice(space, -space)) & visible
    line_ink, line_strip = ink[rows, space:-space], strip[rows, space:-space].astype(np.float64)
    if not line_ink.any() or line_ink.all():
        return False
    like = float(line_strip[line_ink].mean()), float(line_strip[~line_ink].mean())
    for side in (slice(space - 1, None, -1), slice(-space, None)):
        beyond = ink[rows, side], visible[rows, side]
        end = _end_of_cut_word(*beyond, _reach(line_ink))
        if end and _is_same_paint(strip[rows, side][:, :end], beyond[0][:, :end], beyond[1][:, :end], *like):
            return True
    return False


def _is_same_paint(strip: Image, ink: Mask, visible: Mask, letters: float, ground: float) -> bool:
    """Whether a part of a strip has letters and ground of these levels: else it is a wall, or another board."""
    levels, off = strip.astype(np.float64), _SAME_LEVEL * abs(letters - ground)
    plain = levels[visible & ~ink]
    painted = levels[visible & ink]
    return bool(
        len(plain)
        and len(painted)
        and abs(plain.mean() - ground) <= off
        and abs(painted.mean() - letters) <= off
        and plain.std() <= off
    )


def _reach(ink: Mask) -> int:
    """From the first to the last row with ink, without the odd speck."""
    inked = np.flatnonzero(ink.mean(axis=1) > _PLAIN)
    return int(inked[-1] - inked[0]) + 1 if len(inked) else 0


def _end_of_cut_word(ink: Mask, visible: Mask, letters: int) -> int:
    """The last column, plus one, of a cut word in (rows, columns from the end of a text outwards); 0 without one.

    Its letters are about as high as so many rows; a line beside it that is smaller is another one.
    """
    seen = int(np.cumprod(visible.mean(axis=0) > 0.5).sum())
    if seen == visible.shape[1] or seen == 0:
        return 0
    share = ink[:, :seen].sum(axis=0) / visible[:, :seen].sum(axis=0)
    inked = np.flatnonzero(share > _PLAIN)
    if not len(inked) or (share > _BAR).any():
        return 0
    begins, ends = int(inked[0]), int(inked[-1])
    few, many = _STROKES
    is_near = begins <= _WORD_GAP * _PIXELS and seen - 1 - ends <= _TO_THE_BORDER * _PIXELS
    is_as_high = _reach(ink[:, begins : ends + 1]) >= _AS_HIGH * letters
    is_written = few <= float(share[begins : ends + 1].mean()) <= many
    return ends + 1 if is_near and is_as_high and is_written else 0


def _surroundings(rgb: Image, line: Boxes, first: Pixel, last: Pixel, beyond: float = _SPACE) -> tuple[Image, Mask]:
    """The line and so many heights beyond its ends as a level grey strip, and which of its pixels are in the image."""
    width = float(np.linalg.norm(line[1] - line[0] + line[2] - line[3])) / 2.0
    height = max(float(np.linalg.norm(line[3] - line[0] + line[2] - line[1])) / 2.0, 1.0)
    space, margin = round(beyond * _PIXELS), round(_MARGIN * _PIXELS)
    columns = max(round(width / height * _PIXELS), 1)
    target = np.array([[0, 0], [columns, 0], [columns, _PIXELS], [0, _PIXELS]], np.float32)
    target += np.array([space, margin], np.float32)
    homography = cv2.getPerspectiveTransform(line.astype(np.float32), target)
    size = columns + 2 * space, _PIXELS + 2 * margin
    grey = cv2.warpPerspective(
        cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY), homography, size, flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
    )
    view = np.zeros(rgb.shape[:2], np.uint8)
    view[int(first[1]) : int(last[1]) + 1, int(first[0]) : int(last[0]) + 1] = 1
    inside = cv2.warpPerspective(view, homography, size, flags=cv2.INTER_NEAREST)
    return np.asarray(grey, dtype=np.uint8), np.asarray(inside > 0, dtype=np.bool_)


def _ink(strip: Image, visible: Mask, rows: slice, columns: slice) -> Mask:
    """Which pixels of a strip are strokes, by the threshold that parts strokes and ground within rows and columns."""
    inside = strip[rows, columns][visible[rows, columns]]
    if not len(inside):
        return np.zeros(strip.shape, np.bool_)
    threshold, _ = cv2.threshold(inside[None], 0, 255, cv2.THRESH_OTSU)
    bright = strip > threshold
    # The ground is what the rim of a box shows: its letters stand in the middle.
    rim = np.zeros(strip.shape, np.bool_)
    rim[[rows.start, rows.stop - 1], columns] = True
    return np.asarray(~bright if bright[rim & visible].mean() > 0.5 else bright, dtype=np.bool_)


def _may_go_on(ink: Mask, visible: Mask) -> bool:
    """Whether a next letter may stand in the space (rows, columns from the end outwards) beyond an end of a text."""
    seen = int(np.cumprod(visible.mean(axis=0) > 0.9).sum())
    if seen == visible.shape[1]:
        return False
    return seen < _LEAST_SPACE * _PIXELS or float(ink[:, :seen].mean()) > _PLAIN


def _runs_out(ink: Mask, visible: Mask, margin: int, space: int) -> bool:
    """Whether a stroke of the letters runs into the border of the image."""
    border = visible & (cv2.erode(visible.astype(np.uint8), np.ones((3, 3), np.uint8), borderValue=1) == 0)
    _, strokes = cv2.connectedComponents(ink.astype(np.uint8), connectivity=8)
    # Of the letters is what comes through the middle of the line.
    quarter = _PIXELS // 4
    letters = np.unique(strokes[margin + quarter : margin + 3 * quarter, space:-space])
    return bool(np.isin(strokes[border], letters[letters > 0]).any())
