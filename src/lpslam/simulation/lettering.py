"""Sign painting: words on a board in one of several styles, with the place of every line on it."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image as PilImage
from PIL import ImageDraw, ImageFont

from lpslam.simulation import textures
from lpslam.simulation.fonts import sign_font

Image = NDArray[np.uint8]
Rgb = tuple[int, int, int]

LATIN_FONTS = {
    "plain": ("latin-sans-bold", "latin-sans-black", "latin-grotesque-bold", "latin-condensed-bold"),
    "shop": (
        "latin-sans-bold", "latin-sans-black", "latin-grotesque-bold", "latin-slab-bold", "latin-poster",
        "latin-serif-bold", "latin-geometric-bold", "latin-round-bold", "latin-narrow-bold", "latin-square-bold",
        "latin-serif", "latin-script-bold", "latin-script-fat", "latin-script-brush",
    ),
    "friendly": ("latin-comic-bold", "latin-script-bold", "latin-script-fat", "latin-round-bold", "latin-slab-bold"),
}  # fmt: skip
CHINESE_FONTS = {
    "plain": ("chinese-hei-bold", "chinese-hei-black"),
    "shop": ("chinese-hei-bold", "chinese-hei-black", "chinese-song-bold", "chinese-kai-bold"),
    "friendly": ("chinese-kai-bold", "chinese-hei-bold", "chinese-song-bold"),
}


@dataclass(frozen=True, slots=True)
class PaintedLine:
    """One line of text on a board; metres from the board's upper left corner, x right, y down.

    Attributes:
        text: what it says.
        left, top, right, bottom: the ink's box.
        letter_height: height of a capital or of a Chinese character.
        role: what the line is for, "primary", "secondary", "contact" or "list"; empty where nobody said.
    """

    text: str
    left: float
    top: float
    right: float
    bottom: float
    letter_height: float
    role: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Board:
    """A painted board: its picture, its size in metres and its lines, the most prominent first."""

    image: Image
    width: float
    height: float
    lines: tuple[PaintedLine, ...]


def is_chinese(text: str) -> bool:
    """Whether a line has Chinese characters."""
    return any("\u4e00" <= letter <= "\u9fff" for letter in text)


def contrasting_colours(rng: np.random.Generator, kind: str) -> tuple[Rgb, Rgb]:
    """Background and letters of a sign, light on dark or dark on light."""
    if kind == "warning":
        pairs = (((250, 205, 20), (15, 15, 15)), ((200, 20, 25), (255, 255, 255)), ((255, 255, 255), (190, 15, 20)))
        return pairs[int(rng.integers(len(pairs)))]
    if kind == "facility":
        pairs = (((20, 95, 60), (255, 255, 255)), ((25, 60, 130), (255, 255, 255)), ((40, 42, 46), (240, 240, 235)))
        return pairs[int(rng.integers(len(pairs)))]
    dark = textures.pick_colour(rng, (0.3, 1.0), (0.08, 0.42)) if rng.random() < 0.7 else (24.0, 24.0, 26.0)
    light = textures.pick_colour(rng, (0.0, 0.18), (0.9, 1.0)) if rng.random() < 0.75 else (250.0, 215.0, 90.0)
    pair = (dark, light) if rng.random() < 0.6 else (light, dark)
    ground, ink = (tuple(int(value) for value in colour) for colour in pair)
    return (ground[0], ground[1], ground[2]), (ink[0], ink[1], ink[2])


def paint_board(
    rng: np.random.Generator,
    lines: tuple[str, ...],
    kind: str,
    style: str,
    letter_height: float,
    max_width: float,
    pixels_per_metre: float,
) -> Board:
    """Paint one or two lines; the board takes the size that they need.

    Args:
        rng: decides fonts, colours, frame and logo.
        lines: one or two texts; the first is drawn larger.
        kind: of the sign, for its colours.
        style: "plain", "shop" or "friendly": which fonts may be taken.
        letter_height: wanted height of the first line's capitals or characters, metres.
        max_width: of the board, metres; letters shrink to fit.
        pixels_per_metre: of the picture.
    """
    ground, ink = contrasting_colours(rng, kind)
    fonts = [_font_for(rng, line, style) for line in lines]
    heights = [letter_height if row == 0 else letter_height * rng.uniform(0.5, 0.65) for row in range(len(lines))]
    logo = 1.25 * letter_height if style == "shop" and rng.random() < 0.4 else 0.0
    margin = letter_height * rng.uniform(0.4, 0.65)
    widths = [_ink_width(line, font, height) for line, font, height in zip(lines, fonts, heights, strict=True)]
    shrink = min(1.0, (max_width - 2 * margin - logo) / max(widths))
    if shrink < 1.0:
        logo, margin = logo * shrink, margin * max(shrink, 0.6)
        heights = [height * shrink for height in heights]
        widths = [width * shrink for width in widths]
    gap = 0.42 * heights[0]
    width = max(widths) + 2 * margin + logo
    height = sum(1.12 * h for h in heights) + gap * (len(lines) - 1) + 2 * margin
    scale = pixels_per_metre
    size = (max(8, round(width * scale)), max(8, round(height * scale)))
    picture = _ground(rng, size, ground, ink)
    image = PilImage.fromarray(picture)
    draw = ImageDraw.Draw(image)
    painted = []
    top = margin
    for line, name, h, w in zip(lines, fonts, heights, widths, strict=True):
        left = margin + logo + (width - 2 * margin - logo - w) / 2
        box = _paint_line(draw, line, name, h * scale, left * scale, top * scale, ink, rng)
        x0, y0, x1, y1 = (value / scale for value in box)
        painted.append(PaintedLine(line, x0, y0, x1, y1, h))
        top += 1.12 * h + gap
    picture = np.asarray(image).copy()
    if logo:
        _paint_logo(rng, picture, (margin + 0.4 * logo) * scale, height * scale / 2, 0.42 * logo * scale, ink, ground)
    # Plastic and lacquer are never of one shade: a soft gradient and a little grain.
    shade = 1 + 0.05 * textures.clouds(rng, size[1], size[0], max(16, size[0] / 2), 6)
    return Board(textures.to_image(picture * shade[..., None]), width, height, tuple(painted))


def _font_for(rng: np.random.Generator, line: str, style: str) -> str:
    names = (CHINESE_FONTS if is_chinese(line) else LATIN_FONTS)[style]
    # Script letters in capitals only are unreadable, also for people.
    usable = [name for name in names if "script" not in name or not line.isupper()]
    return str(rng.choice(usable))


def _font(name: str, letter_height: float, chinese: bool) -> ImageFont.FreeTypeFont:
    """The font at which a capital (or a Chinese character) is `letter_height` pixels high."""
    probe = sign_font(name, 200)
    _, top, _, bottom = probe.getbbox("国" if chinese else "H")
    return sign_font(name, 200 * letter_height / (bottom - top))


def _ink_width(line: str, name: str, height: float) -> float:
    left, _, right, _ = _font(name, 100, is_chinese(line)).getbbox(line)
    return float((right - left) / 100 * height)


def _paint_line(
    draw: ImageDraw.ImageDraw, line: str, name: str, height: float, left: float, top: float, ink: Rgb,
    rng: np.random.Generator,
) -> tuple[float, float, float, float]:  # fmt: skip
    font = _font(name, height, is_chinese(line))
    _, cap_top, _, _ = font.getbbox("国" if is_chinese(line) else "H")
    x0, _, _, _ = font.getbbox(line)
    anchor = (left - x0, top - cap_top)
    if rng.random() < 0.25:
        shift = max(1.0, 0.03 * height)
        shadow = tuple(int(0.35 * value + 60) for value in ink)
        draw.text((anchor[0] + shift, anchor[1] + shift), line, font=font, fill=shadow)
    draw.text(anchor, line, font=font, fill=ink)
    box = draw.textbbox(anchor, line, font=font)
    return float(box[0]), float(box[1]), float(box[2]), float(box[3])


def _ground(rng: np.random.Generator, size: tuple[int, int], ground: Rgb, ink: Rgb) -> Image:
    width, height = size
    ramp = np.linspace(1 + rng.uniform(0, 0.08), 1 - rng.uniform(0, 0.12), height)[:, None, None]
    picture = np.broadcast_to(np.array(ground) * ramp, (height, width, 3)).copy()
    image = textures.to_image(picture.astype(np.float32))
    frame = rng.random()
    thickness = max(2, round(0.035 * height))
    if frame < 0.35:
        inset = thickness * 2
        cv2.rectangle(image, (inset, inset), (width - 1 - inset, height - 1 - inset), ink, thickness, cv2.LINE_AA)
    elif frame < 0.7:
        cv2.rectangle(image, (0, 0), (width - 1, height - 1), (70, 70, 72), 2 * thickness)
    return image


def _paint_logo(
    rng: np.random.Generator, image: Image, x: float, y: float, radius: float, ink: Rgb, ground: Rgb
) -> None:
    """A small emblem without letters beside the words."""
    centre, r = (round(x), round(y)), max(2, round(radius))
    accent = tuple(int(value) for value in textures.pick_colour(rng, (0.6, 1.0), (0.6, 1.0)))
    shape = int(rng.integers(3))
    if shape == 0:
        cv2.circle(image, centre, r, ink, -1, cv2.LINE_AA)
        peak = np.array([[x - 0.75 * r, y + 0.45 * r], [x - 0.1 * r, y - 0.6 * r], [x + 0.75 * r, y + 0.45 * r]])
        cv2.fillPoly(image, [peak.round().astype(np.int32)], ground, cv2.LINE_AA)
    elif shape == 1:
        turn = np.arange(10) * np.pi / 5 - np.pi / 2
        reach = np.where(np.arange(10) % 2 == 0, r, 0.45 * r)
        corners = np.column_stack([x + reach * np.cos(turn), y + reach * np.sin(turn)])
        cv2.fillPoly(image, [corners.round().astype(np.int32)], accent, cv2.LINE_AA)
    else:
        cv2.rectangle(image, (centre[0] - r, centre[1] - r), (centre[0] + r, centre[1] + r), accent, -1)
        cv2.circle(image, centre, round(0.7 * r), ground, -1, cv2.LINE_AA)
