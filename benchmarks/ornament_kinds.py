"""More ornaments: what walls, fences, shelves and fronts have, whose pieces are alike but seldom quite the same."""

from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray

Picture = NDArray[np.uint8]
Ink = tuple[int, int, int]
Draw = Callable[[Picture, np.random.Generator, int, Ink], None]


def _tops(image: Picture, random: np.random.Generator, size: int) -> range:
    """Upper rows of bands of a height, some way apart."""
    return range(int(random.integers(0, 60)), image.shape[0], int(size * random.uniform(1.6, 3.0)))


def _tinted(random: np.random.Generator, ink: Ink, by: float = 18.0) -> Ink:
    """An ink as one piece of many has it."""
    red, green, blue = np.clip(np.array(ink) + random.normal(0.0, by), 0, 255).astype(int).tolist()
    return red, green, blue


def _linked_rings(image: Picture, random: np.random.Generator, size: int, ink: Ink) -> None:
    thick, pitch = max(1, size // int(random.integers(6, 12))), int(size * random.uniform(0.55, 0.85))
    for top in _tops(image, random, size):
        for left in range(-size, image.shape[1], pitch):
            cv2.circle(image, (left + size // 2, top + size // 2), int(size * 0.45), ink, thick, cv2.LINE_AA)
        for row in (top - thick, top + size + thick):
            cv2.line(image, (0, row), (image.shape[1], row), ink, thick)


def _stepped_keys(image: Picture, random: np.random.Generator, size: int, ink: Ink) -> None:
    thick, pitch = max(2, size // 7), int(size * random.uniform(0.9, 1.6))
    dotted = bool(random.random() < 0.5)
    for top in _tops(image, random, size):
        for left in range(0, image.shape[1], pitch):
            half = left + pitch // 2
            step = np.array(
                [[left, top + size], [left, top], [half, top], [half, top + size], [left + pitch, top + size]]
            )
            cv2.polylines(image, [np.int32(step)], False, ink, thick)
            if dotted:
                middle = (half + pitch // 4, top + size // 3)
                cv2.rectangle(image, middle, (middle[0] + thick, middle[1] + thick), ink, -1)


def _nested_chevrons(image: Picture, random: np.random.Generator, size: int, ink: Ink) -> None:
    thick, pitch = max(1, size // 9), int(size * random.uniform(1.0, 1.5))
    up, count = bool(random.random() < 0.5), int(random.integers(2, 4))
    for top in _tops(image, random, size):
        for left in range(0, image.shape[1], pitch):
            for inner in range(count):
                reach, drop = size // 2 - inner * 2 * thick, inner * 2 * thick
                rows = (top + size - drop, top + drop) if up else (top + drop, top + size - drop)
                middle = left + pitch // 2
                line = [[middle - reach, rows[0]], [middle, rows[1]], [middle + reach, rows[0]]]
                cv2.polylines(image, [np.int32(line)], False, ink, thick, cv2.LINE_AA)


def _picket_fence(image: Picture, random: np.random.Generator, size: int, ink: Ink) -> None:
    wide, tip = max(3, int(size * random.uniform(0.18, 0.35))), int(size * random.uniform(0.1, 0.3))
    pitch = int(wide * random.uniform(1.4, 2.2))
    for top in _tops(image, random, size):
        for row in (top + size // 3, top + 4 * size // 5):
            cv2.rectangle(image, (0, row), (image.shape[1], row + max(2, size // 10)), ink, -1)
        for left in range(0, image.shape[1], pitch):
            high = top + int(random.integers(0, max(2, size // 12)))
            board = [[left, top + size], [left, high + tip], [left + wide // 2, high]]
            board += [[left + wide, high + tip], [left + wide, top + size]]
            cv2.fillPoly(image, [np.int32(board)], _tinted(random, ink))


def _wine_shelf(image: Picture, random: np.random.Generator, size: int, ink: Ink) -> None:
    for top in range(10, image.shape[0] - size, int(size * 1.25)):
        cv2.rectangle(image, (0, top + size), (image.shape[1], top + size + max(3, size // 12)), ink, -1)
        left, kind = 4, random.integers(0, 255, 3)
        while left < image.shape[1]:
            if random.random() < 0.25:
                kind = random.integers(0, 255, 3)
            wide, tall = int(size * random.uniform(0.26, 0.32)), int(size * random.uniform(0.85, 0.97))
            glass = _tinted(random, (int(kind[0]), int(kind[1]), int(kind[2])), 10.0)
            foot, shoulder = top + size, top + size - int(0.6 * tall)
            bottle = [[left, foot], [left, shoulder], [left + wide // 3, shoulder - tall // 8]]
            bottle += [[left + wide // 3, foot - tall], [left + 2 * wide // 3, foot - tall]]
            bottle += [[left + 2 * wide // 3, shoulder - tall // 8], [left + wide, shoulder], [left + wide, foot]]
            cv2.fillPoly(image, [np.int32(bottle)], glass, cv2.LINE_AA)
            paper = _tinted(random, (225, 220, 200))
            cv2.rectangle(image, (left, foot - tall // 2), (left + wide, foot - tall // 5), paper, -1)
            cv2.line(image, (left, foot - tall // 3), (left + wide, foot - tall // 3), glass, max(1, size // 24))
            left += wide + int(random.integers(1, max(2, size // 10)))


def _window_rows(image: Picture, random: np.random.Generator, size: int, ink: Ink) -> None:
    wide, frame = int(size * random.uniform(0.55, 1.2)), max(1, size // 12)
    bars, pitch = int(random.integers(0, 3)), int(wide * random.uniform(1.25, 1.9))
    for top in _tops(image, random, size):
        for left in range(4, image.shape[1], pitch):
            pane = _tinted(random, ink, 40.0)
            cv2.rectangle(image, (left, top), (left + wide, top + size), pane, -1)
            cv2.rectangle(image, (left, top), (left + wide, top + size), ink, frame)
            if bars:
                cv2.line(image, (left + wide // 2, top), (left + wide // 2, top + size), ink, frame)
            if bars > 1:
                cv2.line(image, (left, top + size // 2), (left + wide, top + size // 2), ink, frame)
            cv2.line(image, (left - frame, top + size), (left + wide + frame, top + size), ink, 2 * frame)


def _herringbone(image: Picture, random: np.random.Generator, size: int, ink: Ink) -> None:
    long, wide = size, max(4, size // 3)
    for row in range(-2, image.shape[0] // wide + 2):
        for column in range(-2, image.shape[1] // (2 * long) + 2):
            left, top = column * 2 * long + (row % 4) * wide, row * wide
            brick = _tinted(random, ink)
            cv2.rectangle(image, (left, top), (left + long - 2, top + wide - 2), brick, -1)
            cv2.rectangle(image, (left + long, top - long + wide), (left + long + wide - 2, top + wide - 2), brick, -1)


def _turned_tiles(image: Picture, random: np.random.Generator, size: int, ink: Ink) -> None:
    """Tiles with two quarter circles, each laid either way: lines that never repeat."""
    thick, half = max(2, size // 7), size // 2
    for top in range(0, image.shape[0], size):
        for left in range(0, image.shape[1], size):
            turned = bool(random.random() < 0.5)
            for x, y, start in ((0, 0, 0), (size, size, 180)) if turned else ((size, 0, 90), (0, size, 270)):
                cv2.ellipse(image, (left + x, top + y), (half, half), start, 0, 90, ink, thick, cv2.LINE_AA)


def _ironwork(image: Picture, random: np.random.Generator, size: int, ink: Ink) -> None:
    """Scrolls in mirrored pairs between bars."""
    thick, pitch = max(1, size // 10), int(size * random.uniform(0.8, 1.3))
    curl, gap = int(random.integers(200, 300)), int(random.integers(1, 4))
    for top in _tops(image, random, size):
        for row in (top, top + size):
            cv2.line(image, (0, row), (image.shape[1], row), ink, thick)
        for number, left in enumerate(range(0, image.shape[1], pitch)):
            for at, turn in ((0.28, 180), (0.72, 0)):
                middle = (left + pitch // 2, top + int(at * size))
                turned = turn + (180 if number % 2 else 0)
                cv2.ellipse(
                    image, middle, (pitch // 4, int(0.2 * size)), turned, 90, 90 + curl, ink, thick, cv2.LINE_AA
                )
            if number % gap == 0:
                cv2.line(image, (left, top), (left, top + size), ink, thick)


def _emblems(image: Picture, random: np.random.Generator, size: int, ink: Ink) -> None:
    """Two to four small signs, each in a ring or bare, by turns."""
    kinds = random.permutation(6)[: int(random.integers(2, 5))]
    thick, pitch, ringed = max(1, size // 9), int(size * random.uniform(1.0, 1.7)), bool(random.random() < 0.5)
    for top in _tops(image, random, size):
        for number, left in enumerate(range(0, image.shape[1], pitch)):
            x, y, reach = left + size // 2, top + size // 2, int(size * (0.26 if ringed else 0.42))
            if ringed:
                cv2.circle(image, (x, y), int(size * 0.46), ink, thick, cv2.LINE_AA)
            corners = int(kinds[number % len(kinds)]) + 2
            angles = np.arange(corners) * 2 * np.pi / corners - np.pi / 2
            points = np.stack([x + reach * np.cos(angles), y + reach * np.sin(angles)], axis=1).astype(np.int32)
            if corners == 6:
                cv2.line(image, (x - reach, y), (x + reach, y), ink, thick, cv2.LINE_AA)
                cv2.line(image, (x, y - reach), (x, y + reach), ink, thick, cv2.LINE_AA)
            elif corners == 7:
                cv2.circle(image, (x, y), max(1, reach // 2), ink, -1, cv2.LINE_AA)
            else:
                cv2.polylines(image, [points], True, ink, thick, cv2.LINE_AA)


def _scallops(image: Picture, random: np.random.Generator, size: int, ink: Ink) -> None:
    thick, half = max(1, size // 9), size // 2
    for row, top in enumerate(range(0, image.shape[0], half)):
        for left in range(-(row % 2) * half, image.shape[1], size):
            cv2.ellipse(image, (left + half, top), (half, half), 0, 0, 180, ink, thick, cv2.LINE_AA)


def _vents(image: Picture, random: np.random.Generator, size: int, ink: Ink) -> None:
    """Plates with slots or holes, a few beside each other."""
    slots, round_holes = int(random.integers(3, 9)), bool(random.random() < 0.5)
    pitch = int(size * random.uniform(1.2, 3.0))
    for top in _tops(image, random, size):
        for left in range(int(random.integers(0, 40)), image.shape[1], pitch):
            cv2.rectangle(image, (left, top), (left + size, top + size), ink, max(1, size // 20))
            for slot in range(slots):
                x = left + (2 * slot + 1) * size // (2 * slots)
                if round_holes:
                    for row in range(3):
                        cv2.circle(image, (x, top + (2 * row + 1) * size // 6), max(1, size // (3 * slots)), ink, -1)
                else:
                    cv2.line(image, (x, top + size // 6), (x, top + 5 * size // 6), ink, max(1, size // (3 * slots)))


KINDS: dict[str, Draw] = {
    "linked rings": _linked_rings,
    "stepped keys": _stepped_keys,
    "nested chevrons": _nested_chevrons,
    "picket fence": _picket_fence,
    "wine shelf": _wine_shelf,
    "window rows": _window_rows,
    "herringbone": _herringbone,
    "turned tiles": _turned_tiles,
    "ironwork": _ironwork,
    "emblems": _emblems,
    "scallops": _scallops,
    "vents": _vents,
}
