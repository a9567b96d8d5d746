"""Words as masks of strokes: along a line, along an arc, down a column; regular, or as a hand sets them."""

import math
from dataclasses import dataclass
from functools import cache
from typing import Literal

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image as PilImage
from PIL import ImageDraw, ImageFont

from lpslam.simulation.boards.fields import grain, slopes, soft
from lpslam.simulation.fonts import sign_font
from lpslam.simulation.lettering import is_chinese

Mask = NDArray[np.float32]
Course = Literal["line", "arc", "column"]
COLUMN_PITCH = 1.14  # heights of a character from one to the next below it
ARC_DEGREES = 52.0  # that a curved word turns from its first letter to its last
_PROBE = 200  # size at which fonts are measured


@dataclass(frozen=True, slots=True)
class Hand:
    """How unevenly letters are set.

    Attributes:
        turn: standard deviation of each letter's turn, radians.
        shift: of its place, in letter heights.
        scale: of its size, as a share.
    """

    turn: float = 0.0
    shift: float = 0.0
    scale: float = 0.0


STEADY = Hand()
LOOSE = Hand(turn=0.055, shift=0.035, scale=0.07)


@cache
def _cap_top_and_height(name: str, letter: str) -> tuple[float, float]:
    """Where a capital (or a character) begins below the drawing point, and its height; in sizes of the font."""
    _, top, _, bottom = sign_font(name, _PROBE).getbbox(letter)
    return top / _PROBE, (bottom - top) / _PROBE


@cache
def covers(name: str, text: str) -> bool:
    """Whether a font has all characters of a text."""
    font = sign_font(name, 48)
    absent = _ink(font, "\U0010fffd")
    return all(letter == " " or not np.array_equal(_ink(font, letter), absent) for letter in set(text))


def _ink(font: ImageFont.FreeTypeFont, letter: str) -> NDArray[np.uint8]:
    image = PilImage.new("L", (80, 80))
    ImageDraw.Draw(image).text((8, 8), letter, font=font, fill=255)
    return np.asarray(image, np.uint8)


def draw_words(
    rng: np.random.Generator, text: str, font: str, height: float, course: Course = "line", hand: Hand = STEADY
) -> Mask:
    """Draw a text as strokes.

    Args:
        rng: decides how uneven a hand is.
        text: one line; a column takes its letters one below the other.
        font: name of a carried font.
        height: of a capital or of a Chinese character, pixels.
        course: how the letters follow each other.
        hand: how unevenly they are set.

    Returns:
        (h, w) 0 to 1, cut to the ink with a pixel around it.
    """
    top, tall = _cap_top_and_height(font, "国" if is_chinese(text) else "H")
    size = height / tall
    face = sign_font(font, round(size, 2))
    places = _places(face, text, height, course)
    margin = math.ceil(1.6 * size)
    width = math.ceil(max(x for x, _, _ in places) + 2 * margin + size)
    rows = math.ceil(max(y for _, y, _ in places) - min(y for _, y, _ in places) + 2 * margin + size)
    low = min(y for _, y, _ in places)
    canvas = np.zeros((rows, width), np.float32)
    for letter, (x, y, turn) in zip(text, places, strict=True):
        if letter == " ":
            continue
        tile = PilImage.new("L", (math.ceil(2.4 * size), math.ceil(2.4 * size)))
        advance = face.getlength(letter)
        origin = (tile.width / 2 - advance / 2, tile.height / 2 - (top + tall / 2) * size)
        ImageDraw.Draw(tile).text(origin, letter, font=face, fill=255)
        angle = turn + rng.normal(0, hand.turn)
        scale = 1 + rng.normal(0, hand.scale)
        shift = rng.normal(0, hand.shift * height, 2)
        centre = np.array([x + margin, y - low + margin + height / 2]) + shift
        cos, sin = scale * math.cos(angle), scale * math.sin(angle)
        middle = tile.width / 2
        matrix = np.array(
            [
                [cos, -sin, centre[0] - cos * middle + sin * middle],
                [sin, cos, centre[1] - sin * middle - cos * middle],
            ]
        )
        drawn = cv2.warpAffine(np.asarray(tile, np.float32) / 255, matrix, (width, rows), flags=cv2.INTER_LINEAR)
        np.maximum(canvas, drawn, out=canvas)
    return cut(canvas)


def _places(face: ImageFont.FreeTypeFont, text: str, height: float, course: Course) -> list[tuple[float, float, float]]:
    """Middle of each letter along the baseline, its drop in pixels, and its turn in radians."""
    if course == "column":
        return [(0.0, row * COLUMN_PITCH * height, 0.0) for row in range(len(text))]
    # Lengths of beginnings rather than of letters: they have the kerning.
    ends = [face.getlength(text[: i + 1]) for i in range(len(text))]
    middles = [end - face.getlength(letter) / 2 for letter, end in zip(text, ends, strict=True)]
    if course == "line":
        return [(x, 0.0, 0.0) for x in middles]
    whole = max(ends[-1], 1.0)
    radius = whole / math.radians(ARC_DEGREES)
    angles = [(x - whole / 2) / radius for x in middles]
    half = math.radians(ARC_DEGREES) / 2
    return [(radius * (math.sin(a) + math.sin(half)), radius * (1 - math.cos(a)), a) for a in angles]


def cut(mask: Mask) -> Mask:
    """A mask without what is empty around its ink, but for one pixel; unchanged where it has none."""
    rows, columns = np.flatnonzero(mask.max(axis=1) > 0.1), np.flatnonzero(mask.max(axis=0) > 0.1)
    if not len(rows):
        return mask
    return mask[max(rows[0] - 1, 0) : rows[-1] + 2, max(columns[0] - 1, 0) : columns[-1] + 2]


def brushed(rng: np.random.Generator, mask: Mask, height: float) -> Mask:
    """Strokes of a brush that runs dry: wavering edges, and streaks where the hairs part."""
    rows, columns = mask.shape
    waver = 0.02 * height * grain(rng, rows, columns, 0.06 * height)
    x, y = np.meshgrid(np.arange(columns, dtype=np.float32), np.arange(rows, dtype=np.float32))
    bent = cv2.remap(mask, x + waver, y + waver[::-1], cv2.INTER_LINEAR)
    hairs = grain(rng, rows, columns, 0.22 * height, max(0.7, 0.008 * height))
    dry = grain(rng, rows, columns, 0.4 * height)
    streaks = np.clip(1.5 * (hairs + 1.0 * dry - 1.9), 0, 0.85)
    return np.asarray(bent * (1 - streaks), np.float32)


def tubes(mask: Mask, height: float) -> Mask:
    """Glass tubes along the rim of every stroke."""
    thickness = max(1.5, 0.034 * height)
    ridge = soft(mask, max(0.8, thickness / 2.2))
    # A tube runs where the smoothed mask passes the middle.
    steep = np.hypot(*slopes(ridge)) / 8
    away = np.abs(ridge - 0.5) / np.maximum(steep, 1e-3)
    return np.asarray(np.clip(thickness / 2 + 0.5 - away, 0, 1), np.float32)


def dots(mask: Mask, height: float, rows_a_letter: int) -> tuple[Mask, Mask]:
    """A matrix of lamps: those that are lit, and all; both of the mask's size."""
    pitch = height / rows_a_letter
    rows, columns = (max(1, round(side / pitch)) for side in mask.shape)
    lit = cv2.resize(mask, (columns, rows), interpolation=cv2.INTER_AREA) > 0.42
    y, x = np.meshgrid(np.arange(mask.shape[0]) + 0.5, np.arange(mask.shape[1]) + 0.5, indexing="ij")
    row, column = y * rows / mask.shape[0], x * columns / mask.shape[1]
    off = np.hypot((row % 1 - 0.5), (column % 1 - 0.5)) * pitch
    lamp = np.clip(0.42 * pitch - off + 0.5, 0, 1).astype(np.float32)
    i, j = np.minimum(row.astype(int), rows - 1), np.minimum(column.astype(int), columns - 1)
    return np.asarray(lamp * lit[i, j], np.float32), lamp
