"""Which texts the image's border cuts off (Fig. 11): they mislead, and wait until the rest is in view.

The paper drops what touches the image's rim. A whole word may stand there too: what matters is whether it goes on
outside. It does not where a letter's space beyond both of its ends is in the image, or as much of it as is in the image
is plain ground, and none of its strokes runs into the border.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.text.reading.boxes import Boxes, along_the_lines, may_run_either_way

Image = NDArray[np.uint8]
Mask = NDArray[np.bool_]
Pixel = NDArray[np.float64]

_SPACE = 0.5
"""Box heights beyond an end in which a next letter would begin: wider than the space between two words."""

_LEAST_GROUND = 0.15
"""Box heights of ground that must be seen beyond the last stroke: wider than the gap between two letters."""

_WIDER = 1.5
"""The same as a multiple of the usual gap between the letters of this text, which may be spaced out."""

_MARGIN = 0.15
"""Box heights by which a detected box is grown beyond its letters; so much above and below must be in the image."""

_PIXELS = 24
"""Height of the box, pixels, at which strokes are looked for."""

_PLAIN = 0.04
"""Largest share of a column that may be ink in the ground between letters: a stroke covers more."""


_QUARTER = 0.25
"""Share of a line's height above and below the half of it that must be in view."""

_SEEN = 0.5
"""Share of a column that must be in view, and on the letters' surface, for what stands there to be seen."""


def cut_by_border(rgb: Image, boxes: Boxes) -> Mask:
    """Tell which (n, 4, 2) boxes hold text that goes on beyond the border of an (h, w, 3) image: (n,)."""
    cut = np.zeros(len(boxes), np.bool_)
    if not len(boxes):
        return cut
    cut |= _are_cut(rgb, along_the_lines(boxes))
    # A column of two characters of which one is cut is as wide as high.
    either = np.flatnonzero(may_run_either_way(boxes) & ~cut)
    cut[either] = _are_cut(rgb, np.roll(boxes[either], -1, axis=1))
    return cut


def _are_cut(rgb: Image, lines: Boxes) -> Mask:
    """Which (n, 4, 2) lines go on beyond the border of an (h, w, 3) image."""
    cut = np.zeros(len(lines), np.bool_)
    if not len(lines):
        return cut
    spacious = _grown(lines, _heights(lines)[:, None], _SPACE, _MARGIN)
    first, last = view_of(rgb)
    for row in np.flatnonzero(~((spacious >= first) & (spacious <= last)).all(axis=(1, 2))).tolist():
        cut[row] = _goes_on(rgb, lines[row], first, last, None)
    return cut


def goes_on(rgb: Image, line: Boxes, hidden: Mask) -> bool:
    """Whether the text of a line (4, 2) goes on behind what hides some pixels (h, w) of an (h, w, 3) image."""
    return _goes_on(rgb, line, *view_of(rgb), hidden)


def room_beyond(rgb: Image, box: Boxes, hidden: Mask | None = None, either_way: bool = False) -> tuple[float, float]:
    """How far an (h, w, 3) image goes on before and behind the text of a box (4, 2), in heights of the box.

    What hides some pixels (h, w) ends the view as the image's border does.

    Args:
        rgb, box, hidden: as above; nothing is hidden without.
        either_way: whether the text may run across or down: then there is as much room as the lesser way has.
    """
    first, last = view_of(rgb)
    ways = [box, np.roll(box, -1, axis=0)] if either_way else [along_the_lines(box[None])[0]]
    rooms = [_room_of_line(line, first, last, hidden) for line in ways]
    return min(before for before, _ in rooms), min(behind for _, behind in rooms)


def _room_of_line(line: Boxes, first: Pixel, last: Pixel, hidden: Mask | None) -> tuple[float, float]:
    height = max(float(_heights(line[None])[0]), 1.0)
    before, behind = line[[0, 3]], line[[1, 2]]
    rooms = []
    for ends in ((before, behind), (behind, before)):
        room = _steps_to_border(*ends, first, last)
        rooms.append((room if hidden is None else _steps_to_hidden(*ends, room, hidden)) / height)
    return rooms[0], rooms[1]


def _heights(lines: Boxes) -> NDArray[np.float64]:
    """(n,) pixels across (n, 4, 2) lines, which run from their first corner to the second."""
    return np.asarray(np.linalg.norm(lines[:, 3] - lines[:, 0] + lines[:, 2] - lines[:, 1], axis=1) / 2.0)


def _steps_to_border(end: Boxes, other: Boxes, first: Pixel, last: Pixel) -> float:
    """Pixels from the corners (2, 2) of an end, away from those of the other one, to where half of the line is out."""
    steps = _away(end, other)
    rails = end[::-1] * _QUARTER + end * (1.0 - _QUARTER)
    room = np.where(steps > 0.0, last - rails, rails - first) / np.maximum(np.abs(steps), 1e-9)
    return max(float(room.min()), 0.0)


def _steps_to_hidden(end: Boxes, other: Boxes, room: float, hidden: Mask) -> float:
    """Pixels from the corners (2, 2) of an end to what hides half of the line's height, `room` if nothing does."""
    steps = np.arange(room)
    if not len(steps):
        return room
    rails = end[:, None] + steps[:, None] * _away(end, other)[:, None]
    across = np.linspace(_MARGIN, 1.0 - _MARGIN, _PIXELS)[:, None, None]
    pixels = np.round(rails[0] + across * (rails[1] - rails[0])).astype(np.intp)
    columns, rows = (np.clip(pixels[..., axis], 0, hidden.shape[1 - axis] - 1) for axis in (0, 1))
    is_hidden = hidden[rows, columns].mean(axis=0) > 1.0 - _SEEN
    return float(steps[is_hidden.argmax()]) if is_hidden.any() else room


def _away(end: Boxes, other: Boxes) -> Boxes:
    """Unit steps (2, 2) from the corners of the other end of a line towards those of an end."""
    steps = end - other
    return np.asarray(steps / np.maximum(np.linalg.norm(steps, axis=1, keepdims=True), 1e-9))


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
    most, width = int(_WIDEST_FRAME * image.shape[0]), image.shape[1]
    for depth in range(most):
        line = image[depth]
        if min(np.count_nonzero(line > _BLACK), np.count_nonzero(line < _WHITE)) > _TRACES * width:
            return depth
    return most


_WIDEST_FRAME = 0.05
"""Of a side's length: more than any lens model leaves blank."""

_UNEVEN = 4
"""Pixels by which one side of the frame may be wider than another."""

_BLACK, _WHITE = 10, 245
"""Levels of 255 that a blank line stays within, compressed as it is."""

_TRACES = 0.02
"""Share of a blank line that may be otherwise: compression leaves traces of the image near its ends."""


def _grown(lines: Boxes, heights: NDArray[np.float64], ends: float, sides: float) -> Boxes:
    """Lines (n, 4, 2) with so many heights (n, 1) added beyond their ends and beyond their sides."""
    along = lines[:, 1] + lines[:, 2] - lines[:, 0] - lines[:, 3]
    across = lines[:, 2] + lines[:, 3] - lines[:, 0] - lines[:, 1]
    along = along / np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-9) * heights * ends
    across = across / np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-9) * heights * sides
    steps = np.stack([-along - across, along - across, along + across, across - along], axis=1)
    return np.asarray(lines + steps, dtype=np.float64)


def _goes_on(rgb: Image, line: Boxes, first: Pixel, last: Pixel, hidden: Mask | None) -> bool:
    """Whether the text of a line (4, 2) near where the view ends goes on beyond it."""
    strip, visible = _surroundings(rgb, line, first, last, hidden)
    space, margin = round(_SPACE * _PIXELS), round(_MARGIN * _PIXELS)
    ink = _ink(strip, visible, slice(margin, -margin), slice(space, -space)) & visible
    rows = slice(margin, -margin)
    ground, edges = visible & ~_surfaces(ink), _leaving(ink)
    # Along an edge stands what belongs to neither side.
    strokes = ink & (cv2.erode(ground.astype(np.uint8), np.ones((1, 5), np.uint8), borderValue=1) > 0)
    if 2 * np.count_nonzero(strokes[rows, space:-space]) < np.count_nonzero(ink[rows, space:-space]):
        return True
    for towards_end in (slice(None, None, -1), slice(None)):
        beside = slice(-space, None) if towards_end.step is None else slice(0, space)
        is_seen = bool((visible[rows, beside].mean(axis=0) > _SEEN).all())
        is_leaving = visible[:, beside].sum(axis=0).min() < visible[:, space:-space].sum(axis=0).min()
        if not is_seen and _may_go_on(strokes[rows, towards_end], ground[rows, towards_end]):
            return True
        # A slanted line leaves the view bit by bit: a letter of which only the foot is left is in no box.
        if is_seen and is_leaving and _is_painted((strokes & ~edges)[rows, beside][:, towards_end]):
            return True
    # A box is grown beyond its letters: one whose sides are in view lacks an ascender's tip at most.
    sides = np.array([line[0] + line[1], line[2] + line[3]]) / 2.0
    return not ((sides > first) & (sides < last)).all() and _runs_out(ink, visible, margin, space)


def _surroundings(rgb: Image, line: Boxes, first: Pixel, last: Pixel, hidden: Mask | None) -> tuple[Image, Mask]:
    """The line and the space around it as a level grey strip, and which of its pixels are in view."""
    width = float(np.linalg.norm(line[1] - line[0] + line[2] - line[3])) / 2.0
    height = max(float(_heights(line[None])[0]), 1.0)
    space, margin = round(_SPACE * _PIXELS), round(_MARGIN * _PIXELS)
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
    if hidden is not None:
        view[hidden] = 0
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
    ground = bright[rim & visible]
    return np.asarray(~bright if np.count_nonzero(ground) > 0.5 * len(ground) else bright, dtype=np.bool_)


def _surfaces(ink: Mask) -> Mask:
    """What is no letter but another surface, on which the board ends: it goes on above and below the line."""
    _, pieces = cv2.connectedComponents(ink.astype(np.uint8), connectivity=8)
    through = np.intersect1d(pieces[0], pieces[-1])
    return np.asarray(np.isin(pieces, through[through > 0]), dtype=np.bool_)


def _leaving(ink: Mask) -> Mask:
    """What is no letter but the line along a board's edge: it goes on above the line of text or below it."""
    _, pieces = cv2.connectedComponents(ink.astype(np.uint8), connectivity=8)
    beyond = np.union1d(pieces[0], pieces[-1])
    return np.asarray(np.isin(pieces, beyond[beyond > 0]), dtype=np.bool_)


def _may_go_on(strokes: Mask, ground: Mask) -> bool:
    """Whether a next letter may stand where the view of a line ends.

    It does not where the ground between the last stroke and the end of the view is wider than that between letters.

    Args:
        strokes: (rows, columns) of the line, towards its end.
        ground: the same for what is in view and on the letters' own surface.
    """
    seen = ground.mean(axis=0) > _SEEN
    half = len(seen) // 2
    end = half + int(np.cumprod(seen[half:]).sum())
    inked = np.flatnonzero(strokes[:, :end].mean(axis=0) > _PLAIN)
    if not len(inked):
        return True
    gaps = np.diff(inked) - 1
    between_letters = float(np.median(gaps[gaps > 0])) if (gaps > 0).any() else 0.0
    return end - 1 - int(inked[-1]) < max(_LEAST_GROUND * _PIXELS, _WIDER * between_letters)


def _is_painted(strokes: Mask) -> bool:
    """Whether a letter, or part of one, stands in the space (rows, columns) beyond an end of a box."""
    return bool((strokes[:, _LETTER_ROUND:].mean(axis=0) > _PLAIN).sum() >= _LETTER_ROUND)


_LETTER_ROUND = 2
"""Columns of a strip by which a letter may reach beyond its box, and which one in the next space covers at least."""


def _runs_out(ink: Mask, visible: Mask, margin: int, space: int) -> bool:
    """Whether a stroke of the letters runs into the border of the image."""
    border = visible & (cv2.erode(visible.astype(np.uint8), np.ones((3, 3), np.uint8), borderValue=1) == 0)
    _, strokes = cv2.connectedComponents(ink.astype(np.uint8), connectivity=8)
    # Of the letters is what comes through the middle of the line.
    quarter = _PIXELS // 4
    letters = np.unique(strokes[margin + quarter : margin + 3 * quarter, space:-space])
    return bool(np.isin(strokes[border], letters[letters > 0]).any())
