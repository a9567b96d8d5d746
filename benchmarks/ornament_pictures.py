"""Drawn ornaments that a reader takes for text, and drawn texts that look most like them."""

from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from lpslam.assets import font_names, font_path
from ornament_kinds import KINDS
from ornament_mouldings import MOULDINGS
from ornament_strokes import STROKES
from ornament_things import THINGS

Picture = NDArray[np.uint8]
Draw = Callable[[Picture, np.random.Generator, int, tuple[int, int, int]], None]

SIZE = 640, 480

REPEATED = (
    "COFFEE",
    "OOO",
    "101",
    "88",
    "00",
    "1000",
    "WWW",
    "XXL",
    "100%",
    "BOOKKEEPER",
    "MISSISSIPPI",
    "LILLI",
    "H&M",
)
REPEATED += ("NANA", "BANANA", "COCO", "TOTO", "H2O", "24/7", "7-11", "XOXO", "AAA", "III", "XXX", "888", "www", "0000")
REPEATED += ("HUHU", "MIMI", "IN", "ILL", "111", "HHH", "TTT", "BBQ", "EEE", "VVV", "NON", "MOM", "WOW", "1001", "5000")
WORDS = ("STARBUCKS", "HOUSE BLEND", "Exit", "Toilets", "Nike", "ZARA", "Uniqlo", "Burger King", "Bookshop", "PARKING")
WORDS += (
    "Lift 3",
    "Gate A12",
    "Information",
    "Café",
    "Optician",
    "MEN",
    "WOMEN",
    "No smoking",
    "Sale",
    "50% OFF",
    "KFC",
)
CHINESE = (
    "一二三",
    "星巴克",
    "出口",
    "洗手间",
    "三三",
    "工商银行",
    "電梯",
    "日月",
    "王王",
    "十一",
    "口口",
    "吅",
    "肯德基",
    "小小",
)


def _motifs(image: Picture, random: np.random.Generator, size: int, ink: tuple[int, int, int]) -> None:
    kinds = random.permutation(5)[: random.integers(1, 4)]
    thick = max(1, size // int(random.integers(5, 9)))
    pitch = int(size * random.uniform(1.05, 1.5))
    for top in range(int(random.integers(0, 60)), SIZE[1], int(size * random.uniform(1.8, 3.0))):
        for number, left in enumerate(range(0, SIZE[0], pitch)):
            middle, half = (left + size // 2, top + size // 2), int(size * 0.42)
            x, y = middle
            kind = kinds[number % len(kinds)]
            if kind == 0:
                cv2.circle(image, middle, half, ink, thick, cv2.LINE_AA)
            elif kind == 1:
                cv2.line(image, (x - half, y - half), (x + half, y + half), ink, thick, cv2.LINE_AA)
                cv2.line(image, (x - half, y + half), (x + half, y - half), ink, thick, cv2.LINE_AA)
            elif kind == 2:
                diamond = np.array([[x, y - half], [x + half, y], [x, y + half], [x - half, y]])
                cv2.polylines(image, [diamond], True, ink, thick, cv2.LINE_AA)
            elif kind == 3:
                cv2.rectangle(image, (x - half, y - half), (x + half, y + half), ink, thick)
            else:
                cv2.line(image, (x, y - half), (x, y + half), ink, thick, cv2.LINE_AA)
                cv2.line(image, (x - half, y), (x + half, y), ink, thick, cv2.LINE_AA)


def _meander(image: Picture, random: np.random.Generator, size: int, ink: tuple[int, int, int]) -> None:
    key = np.array([[0, 1], [0, 0], [0.8, 0], [0.8, 0.7], [0.4, 0.7], [0.4, 0.35], [0.4, 1], [1, 1]])
    thick = max(2, size // 8)
    for top in range(int(random.integers(0, 60)), SIZE[1], int(size * random.uniform(1.6, 3.0))):
        for left in range(0, SIZE[0], size):
            cv2.polylines(image, [np.int32(key * size * (1.0, 0.9) + (left, top))], False, ink, thick, cv2.LINE_AA)


def _zigzag(image: Picture, random: np.random.Generator, size: int, ink: tuple[int, int, int]) -> None:
    thick, step = max(2, size // 6), int(size * random.uniform(0.35, 0.8))
    for top in range(int(random.integers(0, 60)), SIZE[1], int(size * random.uniform(1.6, 3.0))):
        line = [[left, top + size * (number % 2)] for number, left in enumerate(range(-step, SIZE[0] + step, step))]
        cv2.polylines(image, [np.int32(line)], False, ink, thick, cv2.LINE_AA)


def _chevrons(image: Picture, random: np.random.Generator, size: int, ink: tuple[int, int, int]) -> None:
    thick, pitch = max(2, size // 6), int(size * random.uniform(0.5, 0.9))
    for top in range(int(random.integers(0, 60)), SIZE[1], int(size * random.uniform(1.6, 3.0))):
        for left in range(0, SIZE[0], pitch):
            arrow = np.int32([[left, top], [left + size // 2, top + size // 2], [left, top + size]])
            cv2.polylines(image, [arrow], False, ink, thick, cv2.LINE_AA)


def _grille(image: Picture, random: np.random.Generator, size: int, ink: tuple[int, int, int]) -> None:
    thick, slope = max(1, size // 7), float(random.choice([0.0, 1.0, 0.6]))
    high = int(size * random.integers(1, 4))
    for top in range(int(random.integers(0, 60)), SIZE[1], int(high * 1.7)):
        for left in range(-2 * high, SIZE[0] + 2 * high, int(size * random.choice([0.5, 0.5, 0.5]))):
            lean = int(slope * high)
            cv2.line(image, (left, top), (left + lean, top + high), ink, thick, cv2.LINE_AA)
            cv2.line(image, (left + lean, top), (left, top + high), ink, thick, cv2.LINE_AA)
        for row in (top, top + high):
            cv2.line(image, (0, row), (SIZE[0], row), ink, thick)


def _bricks(image: Picture, random: np.random.Generator, size: int, ink: tuple[int, int, int]) -> None:
    wide, shift = int(size * random.uniform(1.0, 2.5)), int(random.integers(0, 2))
    thick = max(1, size // int(random.integers(6, 14)))
    for row, top in enumerate(range(0, SIZE[1], size)):
        cv2.line(image, (0, top), (SIZE[0], top), ink, thick)
        for left in range(-(row % 2) * shift * wide // 2, SIZE[0], wide):
            cv2.line(image, (left, top), (left, top + size), ink, thick)


def _railing(image: Picture, random: np.random.Generator, size: int, ink: tuple[int, int, int]) -> None:
    pitch, thick = max(5, int(size * random.uniform(0.25, 0.7))), max(1, size // 8)
    for top in range(int(random.integers(0, 60)), SIZE[1], int(size * random.uniform(1.6, 3.0))):
        for left in range(0, SIZE[0], pitch):
            cv2.line(image, (left, top), (left, top + size), ink, thick)
        if random.random() < 0.6:
            cv2.line(image, (0, top), (SIZE[0], top), ink, thick)
            cv2.line(image, (0, top + size), (SIZE[0], top + size), ink, thick)


def _blinds(image: Picture, random: np.random.Generator, size: int, ink: tuple[int, int, int]) -> None:
    pitch, thick = max(4, size // 4), max(1, size // 10)
    left, wide = int(random.integers(20, 200)), int(random.integers(100, 400))
    for top in range(30, SIZE[1] - 30, pitch):
        if (top // (2 * size)) % 2:
            cv2.line(image, (left, top), (left + wide, top), ink, thick)


def _barcode(image: Picture, random: np.random.Generator, size: int, ink: tuple[int, int, int]) -> None:
    for top in range(30, SIZE[1] - size, int(size * 2.5)):
        left = int(random.integers(20, 120))
        for _ in range(int(random.integers(20, 45))):
            wide = int(random.integers(1, 4)) * max(1, size // 24)
            cv2.rectangle(image, (left, top), (left + wide - 1, top + size), ink, -1)
            left += wide + int(random.integers(1, 4)) * max(1, size // 24)


def _bottles(image: Picture, random: np.random.Generator, size: int, ink: tuple[int, int, int]) -> None:
    wide, paper = int(size * random.uniform(0.28, 0.4)), tuple(int(each) for each in random.integers(0, 255, 3))
    for top in range(20, SIZE[1] - size, int(size * 1.3)):
        cv2.line(image, (0, top + size + 2), (SIZE[0], top + size + 2), ink, 3)
        for left in range(10, SIZE[0], int(wide * 1.15)):
            cv2.rectangle(image, (left, top + size // 3), (left + wide, top + size), ink, -1)
            cv2.rectangle(image, (left + wide // 3, top), (left + 2 * wide // 3, top + size // 3), ink, -1)
            cv2.rectangle(image, (left + 2, top + size // 2), (left + wide - 2, top + 4 * size // 5), paper, -1)


def _arches(image: Picture, random: np.random.Generator, size: int, ink: tuple[int, int, int]) -> None:
    thick, round_half = max(2, size // 8), size // 2
    for top in range(int(random.integers(0, 60)), SIZE[1], int(size * random.uniform(1.4, 3.0))):
        for left in range(0, SIZE[0], int(size * random.uniform(0.95, 1.05))):
            cv2.ellipse(image, (left, top + size), (round_half, size), 0, 180, 360, ink, thick, cv2.LINE_AA)


def _dentils(image: Picture, random: np.random.Generator, size: int, ink: tuple[int, int, int]) -> None:
    wide, thick = max(4, int(size * random.uniform(0.3, 0.6))), max(2, size // 6)
    pitch = wide + max(3, int(size * random.uniform(0.25, 0.6)))
    for top in range(int(random.integers(0, 60)), SIZE[1], int(size * random.uniform(1.6, 3.0))):
        cv2.rectangle(image, (0, top), (SIZE[0], top + thick), ink, -1)
        for left in range(0, SIZE[0], pitch):
            cv2.rectangle(image, (left, top), (left + wide, top + size), ink, -1)


def _woven(image: Picture, random: np.random.Generator, size: int, ink: tuple[int, int, int]) -> None:
    half, gap = max(5, size // 2), max(1, size // 9)
    for row, top in enumerate(range(0, SIZE[1], half)):
        for column, left in enumerate(range(0, SIZE[0], half)):
            over = (half, half // 2) if (row + column) % 2 else (half // 2, half)
            corner = left + (half - over[0]) // 2, top + (half - over[1]) // 2
            cv2.rectangle(image, corner, (corner[0] + over[0] - gap, corner[1] + over[1] - gap), ink, -1)


def _loops(image: Picture, random: np.random.Generator, size: int, ink: tuple[int, int, int]) -> None:
    """Curls that lean on each other, as ironwork has them."""
    thick, pitch = max(2, size // 8), int(size * random.uniform(0.7, 1.1))
    turn, open_end = int(random.integers(0, 360)), int(random.integers(250, 330))
    for top in range(int(random.integers(0, 60)), SIZE[1], int(size * random.uniform(1.6, 3.0))):
        for number, left in enumerate(range(0, SIZE[0], pitch)):
            middle, reach = (left + size // 2, top + size // 2), (int(size * 0.36), int(size * 0.45))
            cv2.ellipse(image, middle, reach, turn + 180 * (number % 2), 0, open_end, ink, thick, cv2.LINE_AA)


ORNAMENTS: dict[str, Draw] = {
    "motifs": _motifs,
    "meander": _meander,
    "zigzag": _zigzag,
    "chevrons": _chevrons,
    "grille": _grille,
    "bricks and tiles": _bricks,
    "railing": _railing,
    "blinds": _blinds,
    "barcode": _barcode,
    "shelf of bottles": _bottles,
    "arches": _arches,
    "dentils": _dentils,
    "woven": _woven,
    "loops": _loops,
    **KINDS,
    **THINGS,
    **MOULDINGS,
    **STROKES,
}


def ornament(kind: str, random: np.random.Generator) -> Picture:
    """A wall with an ornament, seen a little aslant: (480, 640, 3)."""
    image, ground = _wall(kind, random)
    return _seen(image, random, ground)


def ornament_walked_past(
    kind: str, random: np.random.Generator, views: int
) -> tuple[list[Picture], float, NDArray[np.float64]]:
    """A wall with an ornament as it is seen in passing: so many pictures, from one side to the other.

    Returns:
        The pictures, from how far (times the distance at which the wall fills the picture), and the (views,) degrees
        by which the wall is turned.
    """
    image, ground = _wall(kind, random)
    away = float(random.uniform(1.0, 1.6))
    yaws = np.linspace(-50.0, 50.0, views)
    return [_noisy(_aslant(image, yaw, away, ground), random) for yaw in yaws], away, yaws


def _aslant(image: Picture, yaw: float, away: float, ground: tuple[int, int, int]) -> Picture:
    """A wall seen at so many degrees, from so many times the distance at which it fills the picture."""
    cosine, sine = np.cos(np.radians(yaw)), np.sin(np.radians(yaw))
    corners = np.array([[-320.0, -240.0], [320.0, -240.0], [320.0, 240.0], [-320.0, 240.0]])
    depth = away * FOCAL + corners[:, 0] * sine
    seen = np.stack([corners[:, 0] * cosine, corners[:, 1]], axis=1) * FOCAL / depth[:, None]
    warp = cv2.getPerspectiveTransform(np.float32(corners + MIDDLE), np.float32(seen + MIDDLE))
    return np.asarray(cv2.warpPerspective(image, warp, SIZE, borderValue=ground, flags=cv2.INTER_AREA), np.uint8)


MIDDLE = np.array([320.0, 240.0])
FOCAL = 525.0
"""Pixels, of the camera that walks past."""


def _wall(kind: str, random: np.random.Generator) -> tuple[Picture, tuple[int, int, int]]:
    """The wall as it is, and the colour of its ground."""
    ground, ink = _colours(random)
    image = np.full((SIZE[1], SIZE[0], 3), ground, np.uint8)
    size = int(random.integers(16, 56))
    ORNAMENTS[kind](image, random, size, ink)
    if random.random() < 0.6:
        # Most ornaments end somewhere: a band of a few motifs.
        left, wide = int(random.integers(20, 200)), int(size * random.uniform(2.5, 9.0))
        image[:, :left], image[:, left + wide :] = ground, ground
    return image, ground


def text(random: np.random.Generator) -> tuple[str, Picture, NDArray[np.float64]]:
    """A word on a wall, seen a little aslant, and its box (4, 2) as a detector draws it."""
    kind = random.random()
    words, prefix = (CHINESE, "chinese") if kind < 0.25 else (REPEATED if kind < 0.7 else WORDS, "latin")
    word = str(random.choice(words))
    if prefix == "latin" and random.random() < 0.15:
        word = str(random.integers(0, 10 ** int(random.integers(2, 6))))
    if prefix == "latin" and random.random() < 0.3:
        # Spaced out, letters stand as evenly as motifs do.
        word = (" ", "\u2009", "  ")[int(random.integers(0, 3))].join(word.replace(" ", ""))
    ground, ink = _colours(random)
    font = ImageFont.truetype(str(font_path(str(random.choice(font_names(prefix))))), int(random.integers(12, 80)))
    wall = Image.new("RGB", SIZE, ground)
    pen = ImageDraw.Draw(wall)
    downwards = prefix == "chinese" and random.random() < 0.3
    written = "\n".join(word) if downwards else word
    left, top, right, bottom = pen.multiline_textbbox((60, 120), written, font=font, spacing=4)
    pen.multiline_text((60, 120), written, font=font, fill=ink, spacing=4)
    height = (right - left) if downwards else (bottom - top)
    grown = height * random.uniform(0.1, 0.25)
    box = np.array([[left, top], [right, top], [right, bottom], [left, bottom]], np.float64)
    box += np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * grown
    turn = cv2.getRotationMatrix2D((320, 240), float(random.normal(0.0, 3.0)), 1.0)
    image = cv2.warpAffine(np.asarray(wall, np.uint8), turn, SIZE, borderValue=ground)
    box = box @ turn[:, :2].T + turn[:, 2] + random.normal(0.0, 0.03 * height, (4, 2))
    return word, _noisy(image, random), box


def _colours(random: np.random.Generator) -> tuple[tuple[int, int, int], tuple[int, int, int]]:
    while True:
        ground, ink = random.integers(0, 256, (2, 3))
        if abs(float(ground.mean() - ink.mean())) > 60.0:
            return (int(ground[0]), int(ground[1]), int(ground[2])), (int(ink[0]), int(ink[1]), int(ink[2]))


def _seen(image: Picture, random: np.random.Generator, ground: tuple[int, int, int]) -> Picture:
    corners = np.array([[0, 0], [640, 0], [640, 480], [0, 480]], np.float32)
    moved = corners + random.normal(0.0, 18.0, (4, 2)).astype(np.float32)
    warp = cv2.getPerspectiveTransform(corners, moved)
    return _noisy(cv2.warpPerspective(image, warp, SIZE, borderValue=ground), random)


def _noisy(image: cv2.typing.MatLike, random: np.random.Generator) -> Picture:
    blurred = cv2.GaussianBlur(image, (0, 0), float(random.uniform(0.4, 1.3))).astype(np.float64)
    return np.asarray(np.clip(blurred + random.normal(0.0, 4.0, blurred.shape), 0, 255), np.uint8)
