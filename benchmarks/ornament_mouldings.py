"""Ornaments of mouldings, iron and mosaics: rows of pieces that look like letters and are not quite the same."""

from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray

Picture = NDArray[np.uint8]
Ink = tuple[int, int, int]
Draw = Callable[[Picture, np.random.Generator, int, Ink], None]


def _rows(image: Picture, random: np.random.Generator, size: int) -> range:
    """Upper rows of bands of a height, some way apart."""
    return range(int(random.integers(0, 80)), image.shape[0], int(size * random.uniform(2.0, 4.0)))


def _rails(image: Picture, top: int, size: int, thick: int, ink: Ink) -> None:
    """A line above a band and one below it."""
    for row in (top - 2 * thick, top + size + 2 * thick):
        cv2.line(image, (0, row), (image.shape[1], row), ink, thick)


def _cross(image: Picture, left: int, top: int, wide: int, size: int, thick: int, ink: Ink) -> None:
    cv2.line(image, (left, top), (left + wide, top + size), ink, thick, cv2.LINE_AA)
    cv2.line(image, (left, top + size), (left + wide, top), ink, thick, cv2.LINE_AA)


def _egg_and_dart(image: Picture, random: np.random.Generator, size: int, ink: Ink) -> None:
    thick, pitch = max(1, size // 9), int(size * random.uniform(0.9, 1.3))
    for top in _rows(image, random, size):
        for left in range(int(random.integers(-size, 0)), image.shape[1], pitch):
            middle = (left + pitch // 2, top + size // 2)
            cv2.ellipse(image, middle, (pitch // 4, size // 2), 0, 0, 360, ink, thick, cv2.LINE_AA)
            dart = np.int32([[left, top], [left + thick, top + size], [left - thick, top + size]])
            cv2.fillPoly(image, [dart], ink, cv2.LINE_AA)


def _crosses_and_rings(image: Picture, random: np.random.Generator, size: int, ink: Ink) -> None:
    """Panels of a balustrade, now a cross and now a ring, as the smith liked."""
    thick, pitch = max(2, size // 8), int(size * random.uniform(1.0, 1.6))
    for top in _rows(image, random, size):
        _rails(image, top, size, thick, ink)
        for left in range(int(random.integers(-size, 0)), image.shape[1], pitch):
            if random.random() < 0.5:
                _cross(image, left, top, int(0.7 * pitch), size, thick, ink)
            else:
                cv2.circle(image, (left + pitch // 3, top + size // 2), size // 2, ink, thick, cv2.LINE_AA)


def _iron_scrolls(image: Picture, random: np.random.Generator, size: int, ink: Ink) -> None:
    """Scrolls like S and C, every second one the other way round."""
    thick, pitch = max(2, size // 10), int(size * random.uniform(0.7, 1.1))
    both = bool(random.random() < 0.5)
    for top in _rows(image, random, size):
        _rails(image, top, size, thick, ink)
        for at, left in enumerate(range(int(random.integers(-size, 0)), image.shape[1], pitch)):
            middle, quarter = left + pitch // 2, size // 4
            turn = 180 if both and at % 2 else 0
            for row, first in ((top + quarter, 20 + turn), (top + 3 * quarter, 200 + turn)):
                cv2.ellipse(image, (middle, row), (quarter, quarter), 0, first, first + 250, ink, thick, cv2.LINE_AA)


def _gables(image: Picture, random: np.random.Generator, size: int, ink: Ink) -> None:
    """Trusses with a beam across, and struts between them that lean."""
    thick, pitch = max(2, size // 8), int(size * random.uniform(0.8, 1.3))
    beam = int(size * random.uniform(0.5, 0.75))
    for top in _rows(image, random, size):
        for left in range(int(random.integers(-size, 0)), image.shape[1], pitch):
            if random.random() < 0.2:
                strut = [[left, top], [left + pitch // 2, top], [left, top + size], [left + pitch // 2, top + size]]
                cv2.polylines(image, [np.int32(strut)], False, ink, thick, cv2.LINE_AA)
                continue
            roof = np.int32([[left, top + size], [left + pitch // 3, top], [left + 2 * pitch // 3, top + size]])
            cv2.polylines(image, [roof], False, ink, thick, cv2.LINE_AA)
            cv2.line(image, (left + pitch // 6, top + beam), (left + pitch // 2, top + beam), ink, thick)


def _slots_and_holes(image: Picture, random: np.random.Generator, size: int, ink: Ink) -> None:
    """Punched sheet metal: holes, slots and half slots in turn."""
    pattern = random.integers(0, 3, int(random.integers(2, 5))).tolist()
    wide = int(size * random.uniform(0.5, 0.8))
    for top in _rows(image, random, size):
        for at, left in enumerate(range(int(random.integers(-size, 0)), image.shape[1], int(1.4 * wide))):
            middle, kind = (left + wide // 2, top + size // 2), pattern[at % len(pattern)]
            axes = ((wide // 2, size // 2), (max(2, wide // 6), size // 2), (wide // 2, size // 4))[kind]
            cv2.ellipse(image, middle, axes, 0, 0, 360, ink, -1 if random.random() < 0.5 else 3, cv2.LINE_AA)


def _mosaic_border(image: Picture, random: np.random.Generator, size: int, ink: Ink) -> None:
    """Small stones in rows of five that repeat a drawing, some missing."""
    stone = max(4, size // 5)
    drawing = random.random((5, int(random.integers(4, 8)))) < 0.5
    for top in _rows(image, random, size):
        for at in range(image.shape[1] // stone + 1):
            for row in np.flatnonzero(drawing[:, at % drawing.shape[1]]).tolist():
                if random.random() < 0.05:
                    continue
                corner = (at * stone, top + row * stone)
                cv2.rectangle(image, corner, (corner[0] + stone - 2, corner[1] + stone - 2), ink, -1)


def _leaning_books(image: Picture, random: np.random.Generator, size: int, ink: Ink) -> None:
    """Spines on a shelf, upright ones and some that lean on the next."""
    for top in _rows(image, random, size):
        cv2.rectangle(image, (0, top + size), (image.shape[1], top + size + 4), ink, -1)
        left = int(random.integers(0, 20))
        while left < image.shape[1]:
            wide, high = int(size * random.uniform(0.1, 0.3)), int(size * random.uniform(0.7, 1.0))
            lean = int(size * 0.4) if random.random() < 0.2 else 0
            foot = top + size
            spine = [[left, foot], [left + wide, foot], [left + wide + lean, foot - high], [left + lean, foot - high]]
            cv2.polylines(image, [np.int32(spine)], True, ink, max(1, size // 16), cv2.LINE_AA)
            left += wide + lean + int(random.integers(1, 5))


def _half_timber(image: Picture, random: np.random.Generator, size: int, ink: Ink) -> None:
    """Beams of a front: uprights, sills, and crosses and braces between them."""
    thick, pitch = max(3, size // 6), int(size * random.uniform(1.0, 1.5))
    for top in _rows(image, random, size):
        _rails(image, top, size, thick, ink)
        for left in range(int(random.integers(-size, 0)), image.shape[1], pitch):
            cv2.line(image, (left, top), (left, top + size), ink, thick)
            kind = int(random.integers(0, 4))
            if kind == 0:
                _cross(image, left, top, pitch, size, thick, ink)
            elif kind < 3:
                ends = (
                    [(left, top), (left + pitch, top + size)]
                    if kind == 1
                    else [(left, top + size), (left + pitch, top)]
                )
                cv2.line(image, ends[0], ends[1], ink, thick, cv2.LINE_AA)


MOULDINGS: dict[str, Draw] = {
    "egg and dart": _egg_and_dart,
    "crosses and rings": _crosses_and_rings,
    "iron scrolls": _iron_scrolls,
    "gables": _gables,
    "slots and holes": _slots_and_holes,
    "mosaic border": _mosaic_border,
    "leaning books": _leaning_books,
    "half-timber": _half_timber,
}
