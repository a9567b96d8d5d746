"""Lettering drawn to be read: lines in many fonts, kinds, sizes, angles, blurs and noises, several in one image.

A sign is drawn once and seen in several views, each of them in several frames, as a camera would that walks by.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from fontTools.ttLib import TTCollection, TTFont
from numpy.typing import NDArray
from PIL import Image as PilImage
from PIL import ImageDraw, ImageFilter, ImageFont

from lpslam.simulation import textures
from lpslam.simulation.lettering import contrasting_colours

Rgb = NDArray[np.uint8]

KINDS = ("flat", "shadow", "outlined", "raised", "glowing", "faded", "spaced")
DRAWN = 120  # pixels, of a letter as it is drawn
STEEPEST = 72.0  # degrees from straight ahead
SMALLEST = 8.0  # pixels, of letters that are drawn
SIZE = (480, 640)  # of an image


@dataclass(frozen=True)
class Walk:
    """How signs are passed: views of a sign, frames of a view, pixels of letters in the first view and the last."""

    views: int
    frames: int
    heights: tuple[float, float]


PAST = Walk(4, 3, (8.0, 90.0))
FAR = Walk(14, 2, (8.0, 22.0))
"""Signs that one comes close to, and signs that are only ever seen from afar, in many poor views."""


@dataclass(frozen=True)
class Font:
    """A font file, and the letters that it has."""

    path: Path
    letters: frozenset[str]

    @classmethod
    def at(cls, path: Path) -> "Font":
        """Read what a font covers."""
        font = TTCollection(path).fonts[0] if path.suffix == ".ttc" else TTFont(path)
        return cls(path, frozenset(map(chr, font.getBestCmap())))


@dataclass(frozen=True)
class Seen:
    """One line in one image: where it stands and how it is seen.

    Attributes:
        sign, view: numbers; frames of one view differ in noise, and by a pixel.
        text: as painted.
        box: (4, 2) pixels, of the ink.
        frontal: cosine of the viewing angle.
    """

    sign: int
    view: int
    text: str
    box: NDArray[np.float64]
    frontal: float


def drawn(
    seed: int, count: int, texts: Sequence[str], fonts: Sequence[Font], walk: Walk = PAST
) -> Iterator[tuple[Rgb, list[Seen]]]:
    """Images (480, 640, 3) of `count` signs, four beside each other, with the lines that they show."""
    rng = np.random.default_rng(seed)
    for first in range(0, count, 4):
        signs = []
        for sign in range(first, min(first + 4, count)):
            text = str(rng.choice(np.array(texts, object)))
            usable = [font for font in fonts if set(text) <= font.letters]
            if usable:
                signs.append((sign, text, *_painted(rng, text, usable[int(rng.integers(len(usable)))])))
        for view in range(walk.views):
            # From afar to near, as the camera comes.
            share = (view + rng.uniform(0.0, 1.0)) / walk.views
            height = walk.heights[0] * (walk.heights[1] / walk.heights[0]) ** share
            angles = rng.uniform(-STEEPEST, STEEPEST, len(signs)) * rng.uniform(0.0, 1.0)
            blur = float(rng.choice([0.0, 0.4, 0.8, 1.4])) * rng.uniform(0.5, 1.3)
            light, noise = rng.uniform(0.35, 1.1), rng.uniform(1.0, 9.0)
            for _ in range(walk.frames):
                image = np.full((*SIZE, 3), rng.uniform(60.0, 190.0), np.float32)
                image *= 1 + 0.15 * textures.clouds(rng, SIZE[0], SIZE[1], 160, 4)[..., None]
                seen = []
                for row, (sign, text, board, ink) in enumerate(signs):
                    placed = _placed(rng, image, board, ink, height, float(angles[row]), row)
                    if placed is not None:
                        seen.append(Seen(sign, view, text, placed, float(np.cos(np.radians(angles[row])))))
                yield _taken(rng, image, blur, light, noise), seen


def _painted(rng: np.random.Generator, text: str, font: Font) -> tuple[Rgb, NDArray[np.float32]]:
    """A board with a line on it, and the (4, 2) corners of the ink."""
    kind = str(rng.choice(KINDS))
    face = ImageFont.truetype(str(font.path), DRAWN)
    spread = " ".join(text) if kind == "spaced" and len(text) < 8 else text
    left, top, right, bottom = face.getbbox(spread)
    margin = int(0.6 * DRAWN)
    size = (int(right - left) + 2 * margin, int(bottom - top) + 2 * margin)
    ground, ink = contrasting_colours(rng, str(rng.choice(["shop", "facility", "warning"])))
    if kind == "faded":
        share = rng.uniform(0.25, 0.6)
        ink = tuple(int(share * one + (1 - share) * other) for one, other in zip(ink, ground, strict=True))
    shade = 1 + 0.12 * textures.clouds(rng, size[1], size[0], max(16, size[0] / 3), 5)
    image = PilImage.fromarray(textures.to_image(np.array(ground, np.float32) * shade[..., None]))
    at = (margin - left, margin - top)
    draw = ImageDraw.Draw(image)
    dim = tuple(int(0.45 * value) for value in ink)
    if kind == "shadow":
        draw.text((at[0] + 5, at[1] + 5), spread, font=face, fill=(40, 40, 40))
    elif kind == "raised":
        for step in range(int(rng.integers(6, 16)), 0, -1):
            draw.text((at[0] + step, at[1] + step // 2), spread, font=face, fill=dim)
    elif kind == "glowing":
        glow = PilImage.new("RGB", size)
        ImageDraw.Draw(glow).text(at, spread, font=face, fill=ink, stroke_width=6)
        halo = np.asarray(glow.filter(ImageFilter.GaussianBlur(12)), np.float32)
        image = PilImage.fromarray(np.clip(np.asarray(image, np.float32) * 0.5 + halo, 0, 255).astype(np.uint8))
        draw = ImageDraw.Draw(image)
    if kind == "outlined":
        draw.text(at, spread, font=face, fill=ink, stroke_width=6, stroke_fill=dim)
    else:
        draw.text(at, spread, font=face, fill=ink)
    x0, y0, x1, y1 = draw.textbbox(at, spread, font=face)
    return np.asarray(image), np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]], np.float32)


def _placed(
    rng: np.random.Generator,
    image: NDArray[np.float32],
    board: Rgb,
    ink: NDArray[np.float32],
    height: float,
    angle: float,
    row: int,
) -> NDArray[np.float64] | None:
    """Paint a board into its quarter of the image as it is seen turned; the ink's corners, None without room."""
    scale = height / DRAWN
    quarter = np.array([SIZE[1] / 2, SIZE[0] / 4])
    width, tall = board.shape[1] * scale, board.shape[0] * scale
    shrink = min(1.0, 0.94 * 2 * quarter[0] / (width * np.cos(np.radians(angle)) + 1), 0.94 * quarter[1] / tall)
    distance = 4.0 * max(width, tall)
    corners = np.array([[0, 0], [board.shape[1], 0], [board.shape[1], board.shape[0]], [0, board.shape[0]]], np.float32)

    def seen(points: NDArray[np.float32]) -> NDArray[np.float32]:
        flat = (points - corners.mean(axis=0)) * scale * shrink
        away = distance + flat[:, 0] * np.sin(np.radians(angle))
        across = np.column_stack([flat[:, 0] * np.cos(np.radians(angle)), flat[:, 1]]) * (distance / away)[:, None]
        return np.asarray(across + np.array([SIZE[1] / 2, (row + 0.5) * quarter[1]]), np.float32)

    if height * shrink < SMALLEST:
        return None
    shift = rng.uniform(-1.0, 1.0, 2).astype(np.float32)
    homography = cv2.getPerspectiveTransform(corners, seen(corners) + shift)
    smooth = cv2.GaussianBlur(board, (0, 0), max(0.3, 0.4 / (scale * shrink)))
    warped = cv2.warpPerspective(smooth, homography, SIZE[::-1], flags=cv2.INTER_LINEAR)
    covered = cv2.warpPerspective(np.ones(board.shape[:2], np.float32), homography, SIZE[::-1])[..., None]
    image *= 1 - covered
    image += covered * warped
    return np.asarray(seen(ink) + shift, np.float64)


def _taken(rng: np.random.Generator, image: NDArray[np.float32], blur: float, light: float, noise: float) -> Rgb:
    """What the sensor makes of it: blur of motion, light, noise, and the codec."""
    if blur > 0.0:
        length = 1 + 2 * round(blur * 1.5)
        image = cv2.GaussianBlur(cv2.blur(image, (length, 1)), (0, 0), max(blur * 0.6, 0.2))
    grainy = np.clip(image * light + rng.normal(0.0, noise, image.shape), 0, 255).astype(np.uint8)
    _, packed = cv2.imencode(".jpg", grainy, [cv2.IMWRITE_JPEG_QUALITY, int(rng.integers(70, 96))])
    return np.asarray(cv2.imdecode(packed, cv2.IMREAD_COLOR), np.uint8)
