"""More of what is no text and is read as such: what rooms and streets have, some of it in light and shade alone."""

from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray

Picture = NDArray[np.uint8]
Ink = tuple[int, int, int]
Draw = Callable[[Picture, np.random.Generator, int, Ink], None]


def _shaded(image: Picture, light: NDArray[np.float64]) -> None:
    """Make an image (h, w, 3) lighter and darker by factors (h, w)."""
    image[:] = np.clip(image * light[..., None], 0, 255).astype(np.uint8)


def _bathroom_tiles(image: Picture, random: np.random.Generator, size: int, ink: Ink) -> None:
    """Small glazed tiles, a border of two colours among them, each with its gleam."""
    tile, joint = max(6, size // 2), max(1, size // 20)
    band = range(int(random.integers(1, 4)), int(random.integers(5, 9)))
    for row, top in enumerate(range(0, image.shape[0], tile)):
        for column, left in enumerate(range(0, image.shape[1], tile)):
            is_ink = row in band and (row + column) % int(2 + random.integers(0, 2)) == 0
            own = np.array(ink if is_ink else image[0, 0], float) * random.uniform(0.9, 1.1)
            glazed = np.clip(own, 0, 255).astype(int).tolist()
            cv2.rectangle(image, (left, top), (left + tile - joint, top + tile - joint), glazed, -1)
            gleam = np.clip(own + 50.0, 0, 255).astype(int).tolist()
            cv2.line(image, (left + 2, top + 2), (left + tile // 2, top + 2), gleam, joint)


def _radiator(image: Picture, random: np.random.Generator, size: int, ink: Ink) -> None:
    """Ribs in light and shade, between a bar above and one below."""
    pitch, tall = max(6, int(size * random.uniform(0.3, 0.6))), int(size * random.uniform(1.5, 4.0))
    light = np.ones(image.shape[:2])
    for top in range(int(random.integers(0, 60)), image.shape[0], int(tall * 1.6)):
        columns = np.arange(image.shape[1]) / pitch
        light[top : top + tall] = 1.0 + random.uniform(0.15, 0.4) * np.cos(2 * np.pi * columns) ** 3
        for row in (top, top + tall):
            light[row : row + max(2, size // 6)] = 0.6
    _shaded(image, cv2.GaussianBlur(light, (0, 0), 0.8))


def _keyboard(image: Picture, random: np.random.Generator, size: int, ink: Ink) -> None:
    """Rows of keys, a few of them wide, each with a smudge where its letter was."""
    key = max(10, int(size * random.uniform(0.6, 1.0)))
    for row in range(4):
        left, top = int(row * key * 0.3), 40 + int(row * key * 1.15)
        while left < image.shape[1]:
            wide = int(key * (random.uniform(1.5, 2.5) if random.random() < 0.1 else 1.0))
            cv2.rectangle(image, (left, top), (left + wide, top + key), ink, -1)
            face = np.clip(np.array(ink) + 25, 0, 255).astype(int).tolist()
            cv2.rectangle(
                image, (left + key // 8, top + key // 10), (left + wide - key // 8, top + 3 * key // 4), face, -1
            )
            smudge = (left + key // 3, top + key // 3)
            cv2.circle(image, smudge, max(1, key // 10), image[0, 0].tolist(), -1, cv2.LINE_AA)
            left += wide + max(2, key // 8)


def _brick_relief(image: Picture, random: np.random.Generator, size: int, ink: Ink) -> None:
    """Rough bricks of one colour, told by the shadow under and the light above each."""
    tall, wide = max(8, size // 2), int(size * random.uniform(1.0, 1.6))
    light = 1.0 + 0.06 * random.standard_normal(image.shape[:2])
    for row, top in enumerate(range(0, image.shape[0], tall)):
        for left in range(-(row % 2) * wide // 2, image.shape[1], wide):
            deep = int(random.integers(1, max(2, size // 10) + 1))
            columns = slice(max(left, 0), max(left + wide - deep, 0))
            light[top : top + deep, columns] *= 1.25
            light[top + tall - deep : top + tall, columns] *= random.uniform(0.45, 0.7)
            light[top : top + tall, max(left + wide - deep, 0) : max(left + wide, 0)] *= 0.6
    _shaded(image, cv2.GaussianBlur(light, (0, 0), 0.7))


def _railing_shadows(image: Picture, random: np.random.Generator, size: int, ink: Ink) -> None:
    """Slanted soft shadows of bars and of the rail that holds them."""
    shade, slant = np.ones(image.shape[:2]), random.uniform(-0.9, 0.9)
    pitch, thick = int(size * random.uniform(0.5, 1.1)), max(2, size // 8)
    top, tall = int(random.integers(20, 120)), int(size * random.uniform(1.2, 4.0))
    for left in range(-tall, image.shape[1] + tall, pitch):
        cv2.line(shade, (left, top), (left + int(slant * tall), top + tall), 0.55, thick, cv2.LINE_AA)
    for row in (top, top + tall):
        cv2.line(shade, (0, row), (image.shape[1], row), 0.55, thick)
    _shaded(image, cv2.GaussianBlur(shade, (0, 0), random.uniform(0.8, 2.5)))


def _branches(image: Picture, random: np.random.Generator, size: int, ink: Ink) -> None:
    """Bare trees: every branch parts in two or three."""
    for _ in range(int(random.integers(2, 5))):
        start = np.array([random.uniform(0, image.shape[1]), image.shape[0] - 1.0])
        ends = [(start, -np.pi / 2, 3.0 * size, max(3, size // 5))]
        while ends:
            at, angle, length, thick = ends.pop()
            to = at + length * np.array([np.cos(angle), np.sin(angle)])
            cv2.line(image, at.astype(int).tolist(), to.astype(int).tolist(), ink, thick, cv2.LINE_AA)
            if length > size / 3:
                for _ in range(int(random.integers(2, 4))):
                    turned = angle + random.normal(0.0, 0.5)
                    ends.append((to, turned, length * random.uniform(0.5, 0.8), max(1, thick - 2)))


def _zebra_crossing(image: Picture, random: np.random.Generator, size: int, ink: Ink) -> None:
    """Worn white bars on asphalt, wide apart."""
    image[:] = np.clip(random.normal(75.0, 12.0, image.shape[:2]), 0, 255).astype(np.uint8)[..., None]
    pitch, tall = int(size * random.uniform(0.7, 1.4)), int(size * random.uniform(1.5, 5.0))
    worn = cv2.GaussianBlur(random.standard_normal(image.shape[:2]), (0, 0), 2.0) > random.uniform(-0.6, -0.1)
    top = int(random.integers(20, 120))
    for left in range(int(random.integers(0, pitch)), image.shape[1], pitch):
        bar = np.zeros(image.shape[:2], np.bool_)
        bar[top : top + tall, left : left + pitch // 2] = True
        image[bar & worn] = 220


def _slatted_blinds(image: Picture, random: np.random.Generator, size: int, ink: Ink) -> None:
    """Slats with light between them, cords through them, and a broken one here and there."""
    pitch = max(5, int(size * random.uniform(0.25, 0.5)))
    for row in range(0, image.shape[0], pitch):
        sag = int(random.integers(-pitch // 3, pitch // 3 + 1)) if random.random() < 0.1 else 0
        cv2.line(image, (0, row), (image.shape[1], row + sag), ink, max(2, 2 * pitch // 3), cv2.LINE_AA)
    for left in range(int(random.integers(10, 80)), image.shape[1], int(size * random.uniform(2.0, 4.0))):
        cv2.line(image, (left, 0), (left, image.shape[0]), (245, 245, 240), max(1, size // 20))


def _roller_shutter(image: Picture, random: np.random.Generator, size: int, ink: Ink) -> None:
    """Curved strips of metal with rows of slots."""
    pitch = max(6, size // 2)
    rows = np.arange(image.shape[0]) / pitch
    _shaded(image, np.tile((0.85 + 0.25 * np.sin(2 * np.pi * rows))[:, None], (1, image.shape[1])))
    wide, gap = int(size * random.uniform(0.3, 0.9)), int(size * random.uniform(0.15, 0.5))
    for top in range(pitch // 3, image.shape[0], int(pitch * random.integers(1, 3))):
        for left in range(int(random.integers(0, 10)), image.shape[1], wide + gap):
            cv2.ellipse(
                image, (left + wide // 2, top), (wide // 2, max(1, pitch // 6)), 0, 0, 360, ink, -1, cv2.LINE_AA
            )


THINGS: dict[str, Draw] = {
    "bathroom tiles": _bathroom_tiles,
    "radiator": _radiator,
    "keyboard": _keyboard,
    "brick relief": _brick_relief,
    "railing shadows": _railing_shadows,
    "branches": _branches,
    "zebra crossing": _zebra_crossing,
    "slatted blinds": _slatted_blinds,
    "roller shutter": _roller_shutter,
}
